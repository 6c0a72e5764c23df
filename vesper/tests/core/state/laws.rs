//! Laws: switched, held, made at run time, over columns, optional, looking back, amending.

use super::*;

#[test]
fn laws_are_switched_on_and_off() {
    let mut engine =
        Engine::builder().domain(one()).law(Motion).law(Weight).integrator(SemiImplicitEuler).build().unwrap();
    let mut speeds = Vec::new();
    for on in [true, false, false, true] {
        engine.enable("weight", on).unwrap();
        engine.advance(1.0).unwrap();
        speeds.push(speed(&engine, 0).z);
    }
    assert_eq!(speeds, [-10.0, -10.0, -10.0, -20.0]);
    engine.enable("motion", false).unwrap();
    let before = place(&engine, 0);
    engine.advance(1.0).unwrap();
    assert_eq!((place(&engine, 0), status(&mut engine, "weight")), (before, "pruned"));
}

/// Bodies that push each other, from a given force of nothing, or from none; in two integrators.
fn pushed(rows: usize, charges: &[u32], external: bool) -> Vec<(String, Vec<f64>)> {
    let state = State::new([cloud::<f64>(rows, 3)], []).unwrap();
    let of = |property: PropertyInfo| Values::new(property.kind.width(), state.numbers("bodies", property).unwrap());
    let run = |builder: Builder<f64>| {
        let all = [Position.info(), Velocity.info(), Mass.info()];
        let domain =
            all.into_iter().fold(Domain::new("bodies"), |domain, property| domain.with(property, of(property)));
        let domain = domain.subset(Charge, charges.iter().copied(), vec![1.5; charges.len()]);
        let domain = if external { domain.with(ExternalForce, vec![[-0.0; 3]; rows]) } else { domain };
        let mut engine = builder.domain(domain).law(Coulomb).law(Motion).step(0.01).build().unwrap();
        engine.advance(0.05).unwrap();
        let numbers = [Position.info(), Velocity.info()].map(|property| engine.state().numbers("bodies", property));
        (engine.explain(), numbers.into_iter().flat_map(Result::unwrap).collect())
    };
    let charged = |builder: Builder<f64>| if charges.len() == rows { builder.law(Gravity::default()) } else { builder };
    vec![run(charged(Engine::builder())), run(charged(Engine::builder()).integrator(SemiImplicitEuler))]
}

#[test]
fn a_pair_law_that_begins_a_sum_gives_the_bits_of_one_that_adds_to_it() {
    for rows in [1, 2, 3, 5, 6, 9, 17] {
        let all: Vec<u32> = (0..rows as u32).collect();
        // Where it is not for all rows, the sum begins before it.
        for (charges, begins) in [(all.as_slice(), true), (&all[..rows / 2], rows < 2)] {
            let (found, expected) = (pushed(rows, charges, false), pushed(rows, charges, true));
            for ((explained, numbers), (other, same)) in found.iter().zip(&expected) {
                let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(numbers), bits(same), "{rows} rows, {} charges", charges.len());
                assert!(rows < 2 || explained.contains("start of sums") != begins, "{explained}");
                assert!(other.contains("start of sums"), "{other}");
            }
        }
    }
}

#[test]
fn a_pair_law_does_not_begin_sums_that_a_held_law_has_added_to() {
    let run = |external: bool, builder: Builder<f64>| {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0, 0.0, 0.0], [1.0, 0.5, 0.0], [-2.0, 0.0, 1.0]])
            .with(Velocity, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
            .with(Mass, [1.0; 3])
            .with(Charge, [1.0, 2.0, 3.0])
            .with(DragCoefficient, [0.5; 3]);
        let bodies = if external { bodies.with(ExternalForce, [[-0.0; 3]; 3]) } else { bodies };
        let mut engine = builder.domain(bodies).law(Gravity::default()).law(Motion).step(0.01).build().unwrap();
        engine.steps_of(7, 0.01).unwrap();
        let numbers = engine.state().numbers("bodies", Velocity).unwrap();
        numbers.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    let integrators = || -> [Box<dyn Integrator>; 3] {
        [Box::new(Leapfrog::default()), Box::new(SemiImplicitEuler), Box::new(Respa::default())]
    };
    for number in 0..3 {
        let builder = || Engine::<f64>::builder().boxed_integrator(integrators().into_iter().nth(number).unwrap());
        for every in [1, 2, 4] {
            // The last one takes no force that depends on velocities.
            for row in [true, false].into_iter().skip(number / 2) {
                let slow = || if row { builder().law(Drag.every(every)) } else { builder().law(Coulomb.every(every)) };
                let [found, expected] = [false, true].map(|external| run(external, slow()));
                assert_eq!(found, expected, "integrator {number}, every {every}, row law {row}");
                assert_ne!(found, run(false, builder()), "the slow law acts");
            }
        }
    }
}

/// Drag of coefficient 1 on a mass of 2 by hand; the force is that of the steps that `fresh` says.
fn by_hand(steps: u32, fresh: impl Fn(u32) -> bool) -> (f64, f64) {
    let (mut place, mut speed, mut force) = (0.0, 1.0, 0.0);
    for step in 0..steps {
        if fresh(step) {
            force = (0.0 - speed) * 1.0;
        }
        speed += force / 2.0 * 0.1;
        place += speed * 0.1;
    }
    (place, speed)
}

fn dragged(every: u32) -> Builder<f64> {
    let domain = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[1.0, 0.0, 0.0]]).with(Mass, [2.0]);
    let builder = Engine::builder().domain(domain.with(DragCoefficient, [1.0])).law(Motion).law(Drag.every(every));
    builder.integrator(SemiImplicitEuler).step(0.1)
}

#[test]
fn a_law_that_is_not_evaluated_on_every_step_is_held_between() {
    for every in 1..=4 {
        let mut engine = dragged(every).build().unwrap();
        for step in 1..=11 {
            engine.advance(0.1).unwrap();
            assert_eq!((place(&engine, 0).x, speed(&engine, 0).x), by_hand(step, |step| step % every == 0));
        }
    }
}

#[test]
fn held_shares_are_not_lost_to_other_held_laws() {
    // The second law is only looked at, so it is not part of a step; its rhythm must not disturb the first one's.
    let tally =
        || DynLaw::new("tally").reads(Velocity).adds(Acceleration).body(|velocity, sum| sum.copy_from_slice(velocity));
    let mut engine = dragged(3).law(tally().every(2)).observe("bodies", Acceleration).build().unwrap();
    engine.advance(0.7).unwrap();
    assert_eq!((place(&engine, 0).x, speed(&engine, 0).x), by_hand(7, |step| step % 3 == 0));
}

#[test]
fn looking_at_energy_or_forces_changes_nothing() {
    let build = || {
        let builder = Engine::<f64>::builder().domain(cloud(30, 4)).domain(springs(30)).step(0.01);
        builder.law(Gravity::default()).law(Spring.every(3)).law(Drag.every(2)).law(Weight).law(Motion)
    };
    for leapfrog in [true, false] {
        let pick = |builder: Builder<f64>| if leapfrog { builder } else { builder.integrator(RungeKutta4) };
        let mut blind = pick(build()).build().unwrap();
        let mut looking = pick(build().observe("bodies", Force)).build().unwrap();
        for _ in 0..7 {
            blind.advance(0.01).unwrap();
            looking.advance(0.01).unwrap();
            looking.energy().unwrap();
        }
        assert_eq!(blind.state().hash(), looking.state().hash(), "leapfrog: {leapfrog}");
    }
}

#[test]
fn energy_does_not_depend_on_threads() {
    let energy = |backend| {
        let builder = Engine::<f64>::builder().domain(cloud(1300, 8)).domain(springs(1300)).backend(backend).threads(3);
        let mut engine = builder.law(Motion).law(Gravity::default()).law(Spring).law(Drag).build().unwrap();
        engine.energy().unwrap()
    };
    let (serial, silent) = energy(Backend::Cpu);
    assert_eq!(energy(Backend::Parallel), (serial, silent.clone()));
    assert_eq!(silent, ["spring", "drag"]);
    let engine = Engine::<f64>::builder().domain(cloud(1300, 8)).law(Motion).build().unwrap();
    let kinetic: f64 = (0..1300)
        .map(|row| 0.5 * engine.state().get("bodies", Mass, row).unwrap() * speed(&engine, row).length_squared())
        .sum();
    assert!(kinetic > 100.0 && (serial - kinetic).abs() > 1.0, "both parts count: {serial}, {kinetic}");
}

#[test]
fn threads_give_the_bits_of_one() {
    let hash = |backend, threads| {
        let builder = Engine::<f64>::builder().domain(cloud(1300, 9)).domain(springs(1300)).backend(backend);
        let builder = builder.law(Gravity::default()).law(Spring).law(Drag).law(Weight).law(Motion).law(Herd);
        let mut engine = builder.threads(threads).step(0.01).build().unwrap();
        engine.advance(0.03).unwrap();
        engine.state().hash()
    };
    let serial = hash(Backend::Cpu, 1);
    for threads in [1, 2, 3, 7] {
        assert_eq!(hash(Backend::Parallel, threads), serial, "{threads} threads");
    }
}

#[test]
fn a_law_over_whole_columns_gives_the_bits_of_one_of_rows() {
    let drag = DynLaw::new("drag").reads(Velocity).reads(DragCoefficient).adds(Force).whole(|given, force| {
        for (k, force) in force[0].iter_mut().enumerate() {
            *force = (0.0 - given[0][k]) * given[1][k / 3];
        }
    });
    let weight = DynLaw::new("weight").reads(Mass).scene(GravityAcceleration).adds(Force).whole(|given, force| {
        assert_eq!((given[0].len(), given[1].len()), (20, 3));
        for (k, force) in force[0].iter_mut().enumerate() {
            *force = given[1][k % 3] * given[0][k / 3];
        }
    });
    let hash = |builder: Builder<f64>| {
        let builder = builder.domain(cloud(20, 2)).step(0.01).constant(GravityAcceleration, [[0.0, 1.0, -3.0]]);
        let mut engine = builder.integrator(RungeKutta4).law(Motion).build().unwrap();
        engine.advance(0.5).unwrap();
        engine.state().hash()
    };
    let rows = hash(Engine::builder().law(Drag).law(Weight));
    assert_eq!(hash(Engine::builder().law(drag).law(weight)), rows);
}

#[test]
fn a_law_made_at_run_time_gives_the_bits_of_a_derived_one() {
    let run_time = DynLaw::new("drag").reads(Velocity).reads(DragCoefficient).adds(Force).body(|row, force| {
        for c in 0..3 {
            force[c] = (0.0 - row[c]) * row[3];
        }
    });
    let motion = DynLaw::new("motion").reads(Velocity).reads(Force).reads(Mass);
    let motion = motion.rates_from(Position, &[Velocity.info()]).rates_from(Velocity, &[Force.info(), Mass.info()]);
    let motion = motion.body(|row, rates| {
        rates[..3].copy_from_slice(&row[..3]);
        for c in 0..3 {
            rates[3 + c] = row[3 + c] / row[6];
        }
    });
    let weight = DynLaw::new("weight").reads(Mass).scene(GravityAcceleration).adds(Force).body(|row, force| {
        for c in 0..3 {
            force[c] = row[1 + c] * row[0];
        }
    });
    let electric = DynLaw::new("electric").reads(Charge).field(ElectricField).adds(Force).body(|row, force| {
        for c in 0..3 {
            force[c] = row[1 + c] * row[0];
        }
    });
    for integrator in 0..3 {
        let hash = |builder: Builder<f64>| {
            let builder = builder.domain(cloud(20, 2)).step(0.01).constant(GravityAcceleration, [[0.0, 1.0, -3.0]]);
            let builder = builder.field(ElectricField, |at: DVec3, _: f64| DVec3::new(at.y, at.z, at.x));
            let builder = match integrator {
                0 => builder,
                1 => builder.integrator(RungeKutta4),
                _ => builder.integrator(SemiImplicitEuler),
            };
            let mut engine = builder.build().unwrap();
            engine.advance(0.5).unwrap();
            engine.state().hash()
        };
        let derived = hash(Engine::builder().law(Drag).law(Motion).law(Weight).law(Electric));
        let dynamic = (run_time.clone(), motion.clone(), weight.clone(), electric.clone());
        assert_eq!(hash(Engine::builder().law(dynamic.0).law(dynamic.1).law(dynamic.2).law(dynamic.3)), derived);
    }
}

#[test]
fn a_law_over_columns_has_an_algorithm_of_its_own() {
    let places = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 6.0, 0.0]];
    let domain = Domain::new("bodies").with(Position, places).with(Velocity, [[0.0; 3]; 3]).with(Mass, [1.0; 3]);
    let mut engine =
        Engine::<f64>::builder().domain(domain).law(Herd).law(Motion).integrator(SemiImplicitEuler).build().unwrap();
    engine.advance(1.0).unwrap();
    let mean = DVec3::new(1.0, 2.0, 0.0);
    for (row, place) in places.into_iter().enumerate() {
        assert_eq!(speed(&engine, row), mean - DVec3::from(place));
    }
}

#[test]
fn an_optional_property_is_used_where_it_is() {
    let domain = || {
        let domain =
            Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[2.0, 0.0, 0.0]]).with(Mass, [1.0]);
        domain.with(DragCoefficient, [0.5])
    };
    let run = |domain| {
        let builder = Engine::<f64>::builder().domain(domain).law(Drag).law(Motion).integrator(SemiImplicitEuler);
        let mut engine = builder.build().unwrap();
        engine.advance(1.0).unwrap();
        speed(&engine, 0)
    };
    assert_eq!(run(domain()), DVec3::new(1.0, 0.0, 0.0));
    assert_eq!(run(domain().with(WindVelocity, [[2.0, 4.0, 0.0]])), DVec3::new(2.0, 2.0, 0.0));
}

#[test]
fn a_previous_value_is_that_of_the_evaluation_before() {
    let domain = one().with(ExternalForce, [[8.0, 0.0, 0.0]]);
    let builder = Engine::<f64>::builder()
        .domain(domain)
        .law(Echo)
        .law(Remember)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .step(0.5);
    let mut engine = builder.build().unwrap();
    let (mut force, mut velocity) = (0.0, 0.0);
    for _ in 0..6 {
        engine.advance(0.5).unwrap();
        force = 8.0 + 0.5 * force;
        velocity += force / 2.0 * 0.5;
        assert_eq!(speed(&engine, 0).x, velocity);
    }
}

#[test]
fn an_amending_law_corrects_the_state_after_every_step() {
    let builder = Engine::<f64>::builder().domain(one()).law(Weight).law(Floor).law(Motion).step(0.5);
    let mut engine = builder.integrator(SemiImplicitEuler).build().unwrap();
    engine.state_mut().set("bodies", Velocity, 0, DVec3::new(1.0, 0.0, 7.0)).unwrap();
    let (mut height, mut velocity) = (0.0_f64, 7.0);
    for _ in 0..8 {
        engine.advance(0.5).unwrap();
        velocity -= 5.0;
        height = (height + 0.5 * velocity).max(0.0);
        assert_eq!((place(&engine, 0).z, speed(&engine, 0).z), (height, velocity));
    }
    assert_eq!(height, 0.0);
    assert_eq!(place(&engine, 0).x, 4.0);
}

#[test]
fn a_state_that_is_no_coordinate_is_integrated_too() {
    let rods = Domain::new("rods").with(Temperature, [300.0, 100.0]).with(Cooling, [1.0, 0.0]);
    let mut engine =
        Engine::<f64>::builder().domain(rods).law(Cool).integrator(RungeKutta4).step(0.01).build().unwrap();
    engine.advance(1.0).unwrap();
    let found = engine.state().values("rods", Temperature).unwrap();
    assert!((found[0] - 300.0 * (-1.0_f64).exp()).abs() < 1e-7 && found[1] == 100.0, "{found:?}");
}

#[test]
fn one_law_may_stand_on_several_domains_or_twice_on_one() {
    let stars = Domain::new("stars").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let builder = Engine::builder().domain(one()).domain(stars).integrator(SemiImplicitEuler);
    let builder = builder.law(Motion.on("bodies")).law(Motion.on("stars")).law(Weight.on("stars"));
    let mut engine = builder.law(Weight.on("bodies")).law(Weight.on("bodies").label("again")).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).z, -20.0);
    assert_eq!(engine.state().get("stars", Velocity, 0).unwrap().z, -10.0);
    engine.enable("again", false).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).z, -30.0);
}

#[test]
fn a_law_finds_its_domain_through_those_that_set_what_it_reads() {
    // Only the rods could have a trace, because only they have what its law reads.
    let rods = Domain::<f64>::new("rods").with(Temperature, [1.0]);
    let mark = DynLaw::new("mark").reads(Temperature).sets(Trace).body(|_, _| {});
    let look = DynLaw::new("look").reads(Trace).sets(Colour).body(|_, _| {});
    let engine = Engine::builder().domain(one()).domain(rods).law(look).law(mark).build().unwrap();
    assert_eq!(engine.report().law("look").unwrap().domain, "rods");
}
