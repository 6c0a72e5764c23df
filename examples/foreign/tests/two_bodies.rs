//! The foreign law under a whole engine, against closed forms of two bodies.

use foreign_gravity::Gravity;
use vesper::prelude::*;

/// Newton's second law, since this crate knows no other law crate.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, force: Force, mass: Mass),
      rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
struct Newton;

#[kernel]
impl<R: Real> RowLaw<R> for Newton {
    fn row(&self, body: NewtonRow<R>) -> NewtonOutput<R> {
        NewtonOutput { position: body.velocity, velocity: body.force / body.mass }
    }
}

const MASSES: [f64; 2] = [3.0, 1.0];
const DISTANCE: f64 = 2.0;

/// Angular speed of the circular orbit: omega^2 = G (m_1 + m_2) / (d^2 + e^2)^(3/2).
fn angular_speed(law: Gravity) -> f64 {
    let reach = DISTANCE * DISTANCE + law.softening * law.softening;
    (law.g * (MASSES[0] + MASSES[1]) / (reach * reach.sqrt())).sqrt()
}

/// Both bodies on the circle, the centre of mass at rest at the origin, after turning by `angle`.
fn places(angle: f64) -> [[f64; 3]; 2] {
    let total = MASSES[0] + MASSES[1];
    [-MASSES[1] / total, MASSES[0] / total].map(|share| {
        let radius = share * DISTANCE;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    })
}

fn engine(law: Gravity, steps_per_turn: f64) -> Result<Engine<f64>, Faults> {
    let omega = angular_speed(law);
    let speeds = places(0.0).map(|[x, ..]| [0.0, x * omega, 0.0]);
    let bodies = Domain::new("bodies").with(Position, places(0.0)).with(Velocity, speeds).with(Mass, MASSES);
    let step = std::f64::consts::TAU / omega / steps_per_turn;
    Engine::builder().domain(bodies).law(law).law(Newton).integrator(RungeKutta4).step(step).strict().build()
}

/// The largest distance of a body from its place on the circle after `turns`.
fn error_after(law: Gravity, turns: f64, steps_per_turn: f64) -> Result<f64, Faults> {
    let mut engine = engine(law, steps_per_turn)?;
    engine.advance(turns * std::f64::consts::TAU / angular_speed(law))?;
    let mut error: f64 = 0.0;
    for (row, place) in places(turns * std::f64::consts::TAU).into_iter().enumerate() {
        error = error.max((engine.state().get("bodies", Position, row)? - DVec3::from_array(place)).length());
    }
    Ok(error)
}

#[test]
fn a_circular_orbit_is_a_circle() -> Result<(), Faults> {
    let error = error_after(Gravity { g: 1.0, softening: 0.0 }, 1.25, 2000.0)?;
    assert!(error < 1e-10, "{error:e} m off after a turn and a quarter");
    Ok(())
}

#[test]
fn softening_slows_the_orbit_as_plummer_says() -> Result<(), Faults> {
    let error = error_after(Gravity { g: 1.0, softening: 0.5 }, 1.25, 2000.0)?;
    assert!(error < 1e-10, "{error:e} m off after a turn and a quarter");
    Ok(())
}

#[test]
fn the_error_falls_with_the_fourth_power_of_the_step() -> Result<(), Faults> {
    let law = Gravity { g: 1.0, softening: 0.0 };
    let (coarse, fine) = (error_after(law, 1.0, 100.0)?, error_after(law, 1.0, 200.0)?);
    let order = (coarse / fine).log2();
    assert!((3.9..4.3).contains(&order), "order {order}: {coarse:e} m, then {fine:e} m");
    Ok(())
}

#[test]
fn one_file_under_forty_lines() {
    let source = include_str!("../src/lib.rs");
    assert!(source.lines().count() < 40);
    assert!(!source.contains("unsafe") && !source.contains("macro_rules"));
}
