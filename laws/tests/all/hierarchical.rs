//! Gravitation by spheres of influence: against Kepler's ellipses, which it follows, and against all pairs, which it does not.

use std::fs;
use std::path::Path;
use vesper::prelude::*;
use vesper_laws::{Gravity, HierarchicalGravity, Motion, kepler_step};

const G: f64 = 6.674_30e-11;
const YEAR: f64 = 365.25 * 86_400.0;
const AU: f64 = 1.495_978_707e11;

const EVERYWHERE: HierarchicalGravity = HierarchicalGravity { g: G, softening: 0.0, lightest: 0.0 };

/// Names, masses, places and velocities.
#[derive(Clone, Debug, Default)]
struct Bodies {
    names: Vec<String>,
    masses: Vec<f64>,
    places: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl Bodies {
    fn add(&mut self, name: &str, mass: f64, place: DVec3, velocity: DVec3) {
        self.names.push(name.to_owned());
        self.masses.push(mass);
        self.places.push(place);
        self.velocities.push(velocity);
    }

    /// Sun, planets and the Moon, in 1969.
    fn solar_system() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/solar_system_1969_de441.csv");
        let mut bodies = Bodies::default();
        for line in fs::read_to_string(path).unwrap().lines().filter(|line| !line.starts_with('#')).skip(1) {
            let (name, numbers) = line.split_once(',').unwrap();
            let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().unwrap()).collect();
            let velocity = DVec3::from_slice(&numbers[5..8]) * (AU / 86_400.0);
            bodies.add(name, numbers[0] * 1e9 / G, DVec3::from_slice(&numbers[2..5]) * AU, velocity);
        }
        bodies
    }

    fn row(&self, name: &str) -> usize {
        self.names.iter().position(|other| other == name).unwrap()
    }

    fn engine<P: Precision>(&self, law: impl Listing, integrator: impl Integrator + 'static, step: f64) -> Engine<P> {
        let bodies = Domain::new("bodies")
            .with(Position, self.places.iter().map(|place| place.to_array()).collect::<Vec<_>>())
            .with(Velocity, self.velocities.iter().map(|velocity| velocity.to_array()).collect::<Vec<_>>())
            .with(Mass, &self.masses);
        let builder = Engine::builder().domain(bodies).law(law).law(Motion).integrator(integrator).step(step);
        builder.strict().build().unwrap()
    }

    /// The centre of mass of some rows, or their mean velocity.
    fn centre(&self, of: &[DVec3], rows: &[usize]) -> DVec3 {
        let mass: f64 = rows.iter().map(|&row| self.masses[row]).sum();
        rows.iter().map(|&row| of[row] * self.masses[row]).sum::<DVec3>() / mass
    }
}

fn vectors<P: Precision>(engine: &Engine<P>, property: impl AsProperty) -> Vec<DVec3> {
    let numbers = engine.state().numbers("bodies", property).unwrap();
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// How far each thing is from its ellipse about what it goes round, by its distance: ship, moon, planet, far planet, and all.
fn off_ellipses<P: Precision>(lightest: f64) -> [f64; 5] {
    let mut bodies = Bodies::default();
    let (planet, moon) = (DVec3::X, DVec3::new(1.0, 0.01, 0.0));
    let [v_planet, v_moon] = [DVec3::Y * 1.1, DVec3::new(-0.3, 1.1, 0.1)];
    bodies.add("star", 1.0, DVec3::ZERO, DVec3::ZERO);
    bodies.add("planet", 1e-3, planet, v_planet);
    bodies.add("moon", 1e-5, moon, v_moon);
    bodies.add("ship", 1e-12, moon + DVec3::Z * 1e-3, v_moon + DVec3::X * 0.095);
    bodies.add("far planet", 1e-4, DVec3::Y * -4.0, DVec3::X * 0.45);
    let law = HierarchicalGravity { g: 1.0, lightest, ..EVERYWHERE };
    let mut engine = bodies.engine::<P>(law, GaussRadau15::default(), 1e-3);
    let time = 6.0;
    engine.advance(time).unwrap();
    let (places, velocities) = (vectors(&engine, Position), vectors(&engine, Velocity));
    let things: [(&[usize], &[usize]); 5] =
        [(&[3], &[2]), (&[2, 3], &[1]), (&[1, 2, 3], &[0]), (&[4], &[0, 1, 2, 3]), (&[0, 1, 2, 3, 4], &[])];
    let off = things.map(|(outer, inner)| {
        let way = |of: &[DVec3]| {
            let inner = if inner.is_empty() { DVec3::ZERO } else { bodies.centre(of, inner) };
            bodies.centre(of, outer) - inner
        };
        // With nothing further in, all rows together go straight on.
        let both = outer.iter().chain(inner).map(|&row| bodies.masses[row]).sum();
        let parameter = if inner.is_empty() { 0.0 } else { both };
        let start = way(&bodies.places);
        let kepler = start + kepler_step(parameter, start, way(&bodies.velocities), time).position;
        (way(&places) - kepler).length() / kepler.length()
    });
    let told = off.map(|off| format!("{off:.0e}")).join(", ");
    println!("off, by distance, in {} with spheres from {lightest} kg on: {told}", P::NAME);
    let momentum =
        |of: &[DVec3]| of.iter().zip(&bodies.masses).map(|(velocity, &mass)| *velocity * mass).sum::<DVec3>();
    assert!((momentum(&velocities) - momentum(&bodies.velocities)).length() < 1e-17);
    off
}

#[test]
fn each_level_follows_its_ellipse() {
    for lightest in [0.0, 1e-9] {
        let [ship, moon, rest @ ..] = off_ellipses::<f64>(lightest);
        // The ship goes round 95 times at a distance that is a thousandth of its places: rounding, as more digits show.
        assert!(ship < 1e-8 && moon < 1e-10 && rest.iter().all(|off| *off < 1e-14));
        assert!(off_ellipses::<DoubleDouble>(lightest).iter().all(|off| *off < 1e-11));
    }
}

#[test]
fn years_of_the_solar_system_beside_all_pairs() {
    let bodies = Bodies::solar_system();
    let step = 3600.0;
    let mut hierarchical = bodies.engine::<f64>(EVERYWHERE, RungeKutta4, step);
    let mut pairs = bodies.engine::<f64>(Gravity { g: G, softening: 0.0 }, RungeKutta4, step);
    // The largest distance so far, in m, and by that from the attractor; and of one ellipse about the Sun.
    let mut most = vec![[0.0_f64; 3]; bodies.names.len()];
    for (years, expected) in [(1, AFTER_1), (10, AFTER_10)] {
        let end = (f64::from(years) * YEAR / step).round() as u64;
        while hierarchical.steps() < end {
            let steps = 22.min(end - hierarchical.steps());
            hierarchical.steps_of(steps, step).unwrap();
            pairs.steps_of(steps, step).unwrap();
            let [found, exact] = [&hierarchical, &pairs].map(|engine| vectors(engine, Position));
            for (row, most) in most.iter_mut().enumerate().skip(1) {
                let centre = if bodies.names[row] == "Moon" { bodies.row("Earth") } else { 0 };
                let way = |of: &[DVec3]| of[row] - of[centre];
                let parameter = G * (bodies.masses[row] + bodies.masses[centre]);
                let (start, time) = (way(&bodies.places), pairs.steps() as f64 * step);
                let ellipse = start + kepler_step(parameter, start, way(&bodies.velocities), time).position;
                let (off, alone) = ((way(&found) - way(&exact)).length(), (ellipse - way(&exact)).length());
                *most = [most[0].max(off), most[1].max(off / way(&exact).length()), most[2].max(alone)];
            }
        }
        println!("{years} years:      spheres  by distance   an ellipse about the attractor alone");
        for (row, [off, relative, alone]) in most.iter().enumerate().skip(1) {
            let name = &bodies.names[row];
            println!("{name:8} {:9.0} km {relative:9.1e} {:9.0} km", off / 1e3, alone / 1e3);
            let (_, expected) = expected.iter().find(|(other, _)| other == name).unwrap();
            assert!((off / 1e3 / expected - 1.0).abs() < 0.01, "{name}: {} km, not {expected} km", off / 1e3);
        }
    }
}

/// Largest distances in km from where attraction of all pairs has a body: from the Sun's place, the Moon from the Earth's.
const AFTER_1: [(&str, f64); 10] = [
    ("Mercury", 4986.0),
    ("Venus", 6397.0),
    ("Earth", 14_055.0),
    ("Moon", 152_124.0),
    ("Mars", 72_126.0),
    ("Jupiter", 6477.0),
    ("Saturn", 18_083.0),
    ("Uranus", 4237.0),
    ("Neptune", 360.0),
    ("Pluto", 469.0),
];
const AFTER_10: [(&str, f64); 10] = [
    ("Mercury", 16_290.0),
    ("Venus", 94_250.0),
    ("Earth", 101_208.0),
    ("Moon", 790_697.0),
    ("Mars", 544_691.0),
    ("Jupiter", 521_396.0),
    ("Saturn", 1_456_189.0),
    ("Uranus", 142_893.0),
    ("Neptune", 25_552.0),
    ("Pluto", 27_370.0),
];

/// Ships that leave the Earth at several speeds, across its sphere.
fn ships() -> Bodies {
    let mut bodies = Bodies::default();
    bodies.add("Sun", 1.988_4e30, DVec3::ZERO, DVec3::ZERO);
    let (earth, velocity) = (DVec3::X * 1.496e11, DVec3::Y * 29_780.0);
    bodies.add("Earth", 5.972e24, earth, velocity);
    for ship in 0..16 {
        let angle = 0.39 * f64::from(ship);
        let out = DVec3::new(angle.cos(), angle.sin(), 0.1);
        let speed = 3000.0 + 7.0 * f64::from(ship);
        bodies.add("ship", 1e5, earth + out * 7e8, velocity + out * speed);
    }
    bodies
}

#[test]
fn integrators_lose_their_order_where_a_sphere_is_crossed() {
    let bodies = ships();
    let law = HierarchicalGravity { lightest: 1e6, ..EVERYWHERE };
    let run = |time: f64, step: f64| {
        let mut engine = bodies.engine::<f64>(law, RungeKutta4, step);
        engine.steps_of((time / step).round() as u64, step).unwrap();
        vectors(&engine, Position)
    };
    // The root mean square, since what a step across a jump leaves depends on where in the step the jump is.
    let off = |a: &[DVec3], b: &[DVec3]| {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| (*a - *b).length_squared()).sum();
        (squares / a.len() as f64).sqrt()
    };
    // Within the sphere, and across it.
    for (time, steps, least, most) in [(40_000.0, [8000.0, 1600.0], 3.4, 4.2), (160_000.0, [1600.0, 80.0], 0.7, 1.3)] {
        let exact = run(time, 5.0);
        let [coarse, fine] = steps.map(|step| off(&run(time, step), &exact));
        let order = (coarse / fine).ln() / (steps[0] / steps[1]).ln();
        println!(
            "{time} s: {coarse:.1e} m in steps of {} s, {fine:.1e} m of {} s, order {order:.1}",
            steps[0], steps[1]
        );
        assert!((least..most).contains(&order), "{order}");
    }
}

#[test]
fn at_a_sphere_the_acceleration_jumps_by_what_is_left_out_on_both_sides() {
    let at = |distance: f64| {
        let mut bodies = ships();
        bodies.places[2] = bodies.places[1] + DVec3::X * distance;
        bodies.velocities.fill(DVec3::ZERO);
        let after = |mut engine: Engine<f64>| {
            engine.steps_of(1, 1.0).unwrap();
            vectors(&engine, Velocity)[2]
        };
        let spheres = after(bodies.engine(HierarchicalGravity { lightest: 1e6, ..EVERYWHERE }, ExplicitEuler, 1.0));
        spheres - after(bodies.engine(Gravity { g: G, softening: 0.0 }, ExplicitEuler, 1.0))
    };
    // 924.6e6 m from the Earth, away from the Sun.
    let (inside, outside) = (at(924.4e6), at(924.8e6));
    println!("off by {:.2e} m/s^2 inside, {:.2e} m/s^2 outside", inside.x, outside.x);
    // Inside the Sun's tide is left out, 2 GM r / R^3 in first order; outside the Earth's attraction, but for what its mass
    // in the Sun's place would do.
    let (sun, earth, r, distance) = (G * 1.988_4e30, G * 5.972e24, 924.6e6, 1.496e11_f64);
    assert!((inside.x / (-2.0 * sun * r / distance.powi(3)) - 1.0).abs() < 0.02, "{inside}");
    assert!((outside.x / (earth / (r * r)) - 1.0).abs() < 0.02, "{outside}");
}
