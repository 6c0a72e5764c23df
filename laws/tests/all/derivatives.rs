//! Derivatives of the rates along a direction, of every stock law, against central differences of whole evaluations.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use vesper::prelude::*;
use vesper::registry::Status;
use vesper_laws::catalog::stock_laws;
use vesper_laws::*;

/// What was found: for each row of each state, the derivative's length, its distance from the difference, and the largest
/// length of its state.
type Found = Arc<Mutex<Vec<[f64; 3]>>>;

/// No integrator: in place of a step it compares derivatives with differences.
struct Compare {
    found: Found,
    /// How far apart the two states of a difference are, as parts of the states' magnitudes.
    by: f64,
}

impl Integrator for Compare {
    fn name(&self) -> &'static str {
        "compare"
    }

    fn order(&self) -> u32 {
        1
    }

    fn work_vectors(&self) -> usize {
        4
    }

    fn needs_derivatives(&self) -> bool {
        true
    }

    fn step(&mut self, system: &mut dyn System, _step: f64) -> Result<(), Fault> {
        let [start, along, exact, difference] = [0, 1, 2, 3].map(Register::Work);
        let mut scales = Vec::new();
        system.magnitudes(&[Register::State], Part::All, &mut |state, of| {
            scales.resize(scales.len().max(state + 1), 0.0);
            scales[state] = f64::max(scales[state], of[0]);
        });
        system.copy(start, Register::State, Part::All);
        system.scatter(along, &scales);
        system.derivative(exact, along);
        for (number, sign) in [(0, 1.0), (1, -1.0)] {
            system.combine(Register::State, &[(1.0, start), (sign * self.by, along)], Part::All);
            system.evaluate(Part::All);
            let share = (sign * 0.5 / self.by, Register::Rates);
            if number == 0 {
                system.combine(difference, &[share], Part::All);
            } else {
                system.axpy(difference, share.0, share.1, Part::All);
            }
        }
        system.copy(Register::State, start, Part::All);
        system.axpy(difference, -1.0, exact, Part::All);
        let mut rows = Vec::new();
        let mut largest = Vec::new();
        system.magnitudes(&[exact, difference], Part::All, &mut |state, of| {
            largest.resize(largest.len().max(state + 1), 0.0);
            largest[state] = f64::max(largest[state], of[0]);
            rows.push((state, [of[0], of[1]]));
        });
        *self.found.lock().unwrap() = rows.into_iter().map(|(state, [a, b])| [a, b, largest[state]]).collect();
        Ok(())
    }
}

/// Numbers that look random, from 0 to 1.
fn random(seed: &mut u64) -> f64 {
    // Knuth's linear congruential generator (MMIX), its upper bits.
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

const ROWS: usize = 5;

fn vectors(seed: &mut u64, size: f64) -> Vec<[f64; 3]> {
    (0..ROWS).map(|_| [(); 3].map(|()| size * (2.0 * random(seed) - 1.0))).collect()
}

fn numbers(seed: &mut u64) -> Vec<f64> {
    (0..ROWS).map(|_| 0.5 + random(seed)).collect()
}

fn placed<P: Precision>(seed: &mut u64) -> Domain<P> {
    Domain::new("bodies").with(Position, vectors(seed, 2.0)).with(Velocity, vectors(seed, 1.0))
}

fn links<P: Precision>(name: &str, seed: &mut u64) -> Domain<P> {
    let ends: Vec<[u32; 2]> = (0..ROWS as u32).map(|row| [row, (row + 1) % ROWS as u32]).collect();
    let domain = Domain::new(name).link(Ends, "bodies", ends);
    match name {
        "springs" => domain.with(Stiffness, numbers(seed)).with(RestLength, numbers(seed)).with(Damping, numbers(seed)),
        _ => domain.with(QuarticStiffness, numbers(seed)),
    }
}

/// Scenes that have every stock law between them.
fn scenes<P: Precision>() -> Vec<(&'static str, Builder<P>)> {
    let seed = &mut 7;
    let forces = placed(seed)
        .with(Mass, numbers(seed))
        .with(Charge, numbers(seed))
        .with(DragCoefficient, numbers(seed))
        .subset(QuadraticDragCoefficient, [1, 3, 4], [0.3, 0.8, 1.9])
        .subset(DrivingAmplitude, [2], [[1.0, 0.0, 0.5]])
        .with(WindVelocity, vectors(seed, 1.0));
    let dipole = Dipole { at: [0.3, 0.1, -4.0], moment: [1.0, 5.0, -3.0] };
    let centres = Points { points: vec![Point { at: [3.0, 3.0, 0.0], strength: -8.0 }] };
    let forces = Engine::builder()
        .domain(forces)
        .domain(links("springs", seed))
        .domain(links("quartic", seed))
        .constant(GravityAcceleration, [[0.0, 0.0, -9.81]])
        .field(ElectricField, dipole)
        .field(MagneticField, Bottle { value: 2.0, length: 3.0 })
        .field(GravityField, centres)
        .law(Gravity { g: 2.0, softening: 0.1 })
        .law(Coulomb { k: 3.0, softening: 0.0 })
        .law(HenonHeiles { stiffness: 1.0, cubic: 0.7 })
        .law(Drag)
        .law(QuadraticDrag)
        .law(DrivenForce { angular_frequency: 2.0, phase: 0.3 })
        .law(ElectricForce)
        .law(MagneticForce)
        .law(FieldGravity)
        .law(UniformGravity)
        .law(RotatingFrame { angular_velocity: DVec3::new(0.1, 0.4, -0.7) })
        .law(Spring)
        .law(Damper)
        .law(QuarticSpring)
        .law(Motion);

    let immovable = placed(seed).with(Mass, [1.0, 0.0, 2.0, 0.0, 0.5]);
    let immovable = Engine::builder().domain(immovable).law(Gravity { g: 2.0, softening: 0.0 }).law(Motion);

    let parameters = placed(seed).with(StandardGravitationalParameter, numbers(seed));
    let parameters = Engine::builder()
        .domain(parameters)
        .constant(SpeedOfLight, [20.0])
        .law(GravityByParameter::default())
        .law(PostNewtonian)
        .law(Kinematics);

    let relative = placed(seed).with(StandardGravitationalParameter, numbers(seed));
    let relative = Engine::builder()
        .domain(relative)
        .constant(SpeedOfLight, [20.0])
        .law(NewtonianField)
        .law(GravityByParameter::default())
        .law(EinsteinInfeldHoffmann)
        .law(Kinematics);

    let fast = Domain::new("bodies")
        .with(Position, vectors(seed, 2.0))
        .with(Momentum, vectors(seed, 3.0))
        .with(RestMass, numbers(seed))
        .with(Charge, numbers(seed));
    let fast = Engine::builder()
        .domain(fast)
        .constant(SpeedOfLight, [3.0])
        // A closure has no derivative of its own.
        .field(MagneticField, |at: P::Vec3, _time: P| P::Vec3::new(at.y(), at.z() * at.z(), at.x()))
        .law(RelativisticVelocity)
        .law(MagneticForce)
        .law(RelativisticMotion);

    let heavier = placed(seed).with(RestMass, numbers(seed)).with(DragCoefficient, numbers(seed));
    let heavier =
        Engine::builder().domain(heavier).constant(SpeedOfLight, [3.0]).law(RelativisticMass).law(Drag).law(Motion);

    let touching = placed(seed).with(Mass, numbers(seed));
    let plane = ContactPlane {
        normal: DVec3::Z,
        offset: 0.0,
        stiffness: 40.0,
        damping: 2.0,
        friction: 0.4,
        resting_speed: 1e-6,
    };
    let touching = Engine::builder().domain(touching).law(plane).law(Motion);

    let made = DynLaw::new("made").reads(Position).reads(Velocity).adds(Force).body(|given, force| {
        let [x, v] = [DVec3::from_slice(&given[..3]), DVec3::from_slice(&given[3..])];
        let sum = x * -x.length_squared() - v * v.length();
        force.copy_from_slice(&sum.to_array());
    });
    let at_run_time = placed(seed).with(Mass, numbers(seed));
    let at_run_time = Engine::builder().domain(at_run_time).law(made).law(Motion);

    let spheres = placed(seed).with(Mass, [1.0, 2e-2, 80.0, 3e-6, 0.5]);
    let law = HierarchicalGravity { g: 2.0, softening: 0.1, lightest: 1e-4 };
    let spheres = Engine::builder().domain(spheres).law(law).law(Motion);
    vec![
        ("forces", forces),
        ("immovable", immovable),
        ("parameters", parameters),
        ("relative", relative),
        ("fast", fast),
        ("heavier", heavier),
        ("touching", touching),
        ("at run time", at_run_time),
        ("spheres", spheres),
    ]
}

/// Compares; gives the lengths of the derivatives, and the names of the laws that ran.
fn compared<P: Precision>(builder: Builder<P>, by: f64) -> (Vec<[f64; 3]>, Vec<String>) {
    let found = Found::default();
    let compare = Compare { found: found.clone(), by };
    let mut engine = builder.integrator(compare).step(1e-3).build().unwrap();
    engine.steps_of(1, 1e-3).unwrap();
    let active = engine.report().laws.iter().filter(|law| matches!(law.status, Status::Active { .. }));
    let active = active.map(|law| law.label.clone()).collect();
    let found = found.lock().unwrap().clone();
    (found, active)
}

#[test]
fn of_all_stock_laws_are_those_of_differences() {
    let mut seen = BTreeSet::new();
    for (name, builder) in scenes::<f64>() {
        let (found, active) = compared(builder, 1e-5);
        seen.extend(active);
        assert!(found.iter().all(|[_, _, largest]| *largest > 0.0), "{name}: something moves");
        let off = found.iter().map(|[_, off, largest]| off / largest).fold(0.0, f64::max);
        println!("{name}: {off:.1e} of the largest derivative");
        assert!(off < 3e-8, "{name}: {off:e}");
    }
    let missing: Vec<&str> =
        stock_laws().iter().map(|law| law.signature.name).filter(|name| !seen.contains(*name)).collect();
    assert_eq!(missing, Vec::<&str>::new(), "every stock law is in a scene");
}

#[test]
fn single_precision_gives_those_of_double() {
    for ((name, single), (_, double)) in scenes::<f32>().into_iter().zip(scenes::<f64>()) {
        let ([single, _], [double, _]) =
            ([compared(single, 1e-3).0, Vec::new()], [compared(double, 1e-5).0, Vec::new()]);
        // Column laws have differences in either precision.
        let enough = if ["parameters", "relative", "spheres"].contains(&name) { 2e-3 } else { 2e-5 };
        for (single, double) in single.iter().zip(&double) {
            assert!((single[0] - double[0]).abs() < enough * double[2], "{name}: {single:?}, {double:?}");
        }
    }
}
