//! Columns in, values out.

use super::*;

#[test]
fn values_come_in_any_unit_of_the_dimension() {
    let day = 86_400.0;
    let domain = Domain::<f64>::new("bodies")
        .with_unit(Position, "km", [[1.0, 2.0, 3.0]])
        .with_unit(Velocity, "km/d", [[1.0, 0.0, 0.0]])
        .with_unit(Mass, "g", [5.0]);
    let state = State::new([domain], []).unwrap();
    assert_eq!(state.get("bodies", Position, 0).unwrap(), DVec3::new(1000.0, 2000.0, 3000.0));
    assert!((state.get("bodies", Velocity, 0).unwrap().x - 1000.0 / day).abs() < 1e-15);
    assert_eq!(state.get("bodies", Mass, 0).unwrap(), 0.005);
}

#[test]
fn a_subset_may_be_given_in_any_order() {
    let domain = Domain::<f64>::new("bodies").rows(4).subset(Charge, [3, 0, 2], [30.0, 0.5, 20.0]);
    let state = State::new([domain], []).unwrap();
    assert_eq!(state.column("bodies", "charge").unwrap().subset(), Some(&[0, 2, 3][..]));
    assert_eq!(state.values("bodies", Charge).unwrap(), [0.5, 20.0, 30.0]);
    assert_eq!(state.get("bodies", Charge, 2).unwrap(), 20.0);
    assert!(matches!(state.get("bodies", Charge, 1), Err(Fault::NoValue { row: 1, given: 3, rows: 4, .. })));
}

#[test]
fn a_law_on_a_subset_moves_its_rows_only_and_pairs_within_it() {
    let domain = || {
        Domain::new("bodies")
            .with(Position, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3]; 4])
            .with(Mass, [1.0; 4])
    };
    let run = |domain: Domain<f64>| {
        let mut engine = Engine::builder().domain(domain).law(Coulomb).law(Motion).step(0.01).build().unwrap();
        engine.advance(0.1).unwrap();
        engine
    };
    let charged = run(domain().subset(Charge, [3, 1], [2.0, 1.0]));
    let alone = {
        let two =
            Domain::new("bodies").with(Position, [[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]).with(Velocity, [[0.0; 3]; 2]);
        run(two.with(Mass, [1.0; 2]).with(Charge, [1.0, 2.0]))
    };
    assert_eq!((place(&charged, 1), place(&charged, 3)), (place(&alone, 0), place(&alone, 1)));
    assert_eq!((place(&charged, 0), place(&charged, 2)), (DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)));
    assert!(place(&charged, 1).x < 1.0, "equal charges part");
}

#[test]
fn a_field_is_sampled_where_a_row_of_a_subset_is() {
    let domain = Domain::new("bodies")
        .with(Position, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
        .with(Velocity, [[0.0; 3]; 3])
        .with(Mass, [1.0; 3])
        .subset(Charge, [2, 0], [1.0, 1.0]);
    let mut engine = Engine::<f64>::builder()
        .domain(domain)
        .field(ElectricField, |at: DVec3, _: f64| at * 10.0)
        .law(Electric)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .build()
        .unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!([0, 1, 2].map(|row| speed(&engine, row).x), [10.0, 0.0, 30.0]);
}

#[test]
fn a_column_that_is_added_wakes_a_law_and_one_that_is_taken_away_puts_it_to_sleep() {
    let mut engine = Engine::builder().domain(one()).law(Motion).law(Drag).law(Inertia).step(0.5).build().unwrap();
    assert_eq!(status(&mut engine, "drag"), "dormant");
    engine.state_mut().set("bodies", Velocity, 0, DVec3::X).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::X, "nothing slows it");
    engine.state_mut().add_columns(Domain::new("bodies").with(DragCoefficient, [0.5])).unwrap();
    assert_eq!(status(&mut engine, "drag"), "active");
    engine.advance(1.0).unwrap();
    let slower = speed(&engine, 0).x;
    assert!(slower < 1.0);
    engine.state_mut().remove_column("bodies", DragCoefficient).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!((status(&mut engine, "drag"), speed(&engine, 0).x), ("dormant", slower));
    // A property that a law sets takes the place of one that the client no longer gives.
    engine.state_mut().remove_column("bodies", Mass).unwrap();
    assert_eq!((status(&mut engine, "motion"), status(&mut engine, "inertia")), ("dormant", "dormant"));
    engine.state_mut().add_columns(Domain::new("bodies").with(RestMass, [2.0])).unwrap();
    assert_eq!((status(&mut engine, "motion"), status(&mut engine, "inertia")), ("active", "active"));
    engine.advance(1.0).unwrap();
}

#[test]
fn a_whole_domain_can_come_later() {
    let far = Domain::new("bodies").with(Position, [[0.0; 3], [2.0, 0.0, 0.0]]).with(Velocity, [[0.0; 3]; 2]);
    let mut engine =
        Engine::builder().domain(far.with(Mass, [1.0; 2])).law(Motion).law(Spring).step(0.1).build().unwrap();
    assert_eq!(status(&mut engine, "spring"), "dormant");
    engine.advance(1.0).unwrap();
    assert_eq!(place(&engine, 0), DVec3::ZERO);
    engine.state_mut().add_columns(springs(2)).unwrap();
    engine.advance(0.1).unwrap();
    assert!(place(&engine, 0).x > 0.0 && status(&mut engine, "spring") == "active");
}

#[test]
fn constants_have_defaults_and_can_be_changed_between_steps() {
    let mut engine =
        Engine::builder().domain(one()).law(Motion).law(Weight).integrator(SemiImplicitEuler).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).z, -10.0, "the law's own default");
    for gravity in [-2.0, 3.0] {
        let before = speed(&engine, 0).z;
        engine.state_mut().set_constant(GravityAcceleration, DVec3::new(0.0, 0.0, gravity)).unwrap();
        engine.advance(1.0).unwrap();
        assert_eq!(speed(&engine, 0).z, before + gravity);
    }
    engine.state_mut().remove_column("scene", GravityAcceleration).unwrap();
    let before = speed(&engine, 0).z;
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).z, before - 10.0);
}

#[test]
fn fields_can_be_replaced_between_steps() {
    let mut engine = Engine::builder()
        .domain(one().with(Charge, [4.0]))
        .field(ElectricField, Uniform { value: [1.0, 0.0, 0.0] })
        .law(Electric)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .build()
        .unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::new(2.0, 0.0, 0.0));
    engine.state_mut().set_field(ElectricField, |_: DVec3, time: f64| DVec3::new(0.0, time, 0.0));
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::new(2.0, 2.0, 0.0), "sampled at the time of the step's start, 1 s");
}

#[test]
fn a_body_may_be_teleported_between_frames() {
    for leapfrog in [false, true] {
        let builder = |domain| {
            let builder = Engine::<f64>::builder().domain(domain).law(Gravity::default()).law(Motion).step(0.1);
            if leapfrog { builder } else { builder.integrator(RungeKutta4) }
        };
        let mut engine = builder(cloud(5, 3)).build().unwrap();
        engine.advance(0.5).unwrap();
        engine.state_mut().set("bodies", Position, 2, DVec3::new(3.0, 4.0, 5.0)).unwrap();
        // Whoever starts with the same numbers goes on alike: nothing of the old place is remembered.
        let mut fresh = builder(cloud(5, 3)).build().unwrap();
        *fresh.state_mut() = engine.state().clone();
        engine.advance(0.5).unwrap();
        fresh.advance(0.5).unwrap();
        let places = |engine: &Engine<f64>| engine.state().numbers("bodies", Position).unwrap();
        assert_eq!(places(&engine), places(&fresh));
    }
}

#[test]
fn columns_can_be_changed_in_place() {
    let mut engine = Engine::builder().domain(cloud(3, 1)).law(Motion).step(0.1).build().unwrap();
    let mut components = engine.state_mut().column_mut("bodies", "velocity").unwrap().components_mut().unwrap();
    components[0].fill(7.0);
    engine.advance(0.1).unwrap();
    for row in 0..3 {
        assert!((speed(&engine, row).x - 7.0).abs() < 1.0);
    }
}

#[test]
fn sums_start_from_what_the_client_applies() {
    let domain = one().with(ExternalForce, [[4.0, 0.0, 0.0]]);
    let mut engine =
        Engine::builder().domain(domain).law(Weight).law(Motion).integrator(SemiImplicitEuler).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::new(2.0, 0.0, -10.0));
    engine.state_mut().set("bodies", ExternalForce, 0, DVec3::ZERO).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0), DVec3::new(2.0, 0.0, -20.0));
}

#[test]
fn what_a_law_set_is_gone_when_it_no_longer_runs() {
    let push =
        DynLaw::new("push").reads(Mass).sets(ExternalForce).body(|_, force| force.copy_from_slice(&[6.0, 0.0, 0.0]));
    let builder = Engine::builder().domain(one()).law(push).law(Motion).integrator(SemiImplicitEuler);
    let mut engine = builder.observe("bodies", ExternalForce).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).x, 3.0);
    engine.enable("push", false).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).x, 3.0, "the force is no longer there");
    assert!(engine.state().column("bodies", "external_force").is_err(), "and neither is its column");
    engine.enable("push", true).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(speed(&engine, 0).x, 6.0);
}
