//! An integrator of your own: it asks for rates and moves the state; which laws there are it never learns.
//!
//! `cargo run --release --example own_integrator`

use vesper::prelude::*;
use vesper_laws::{Gravity, Motion};

/// Ralston's method: order 2, two evaluations per step, the smallest error bound of its kind.
///
/// Source: Ralston, Math. Comp. 16 (1962) 431.
#[derive(Debug)]
struct Ralston;

impl Integrator for Ralston {
    fn name(&self) -> &'static str {
        "ralston"
    }
    fn order(&self) -> u32 {
        2
    }
    fn work_vectors(&self) -> usize {
        2
    }
    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let (start, first) = (Register::Work(0), Register::Work(1));
        let time = system.time();
        system.copy(start, Register::State, Part::All);
        system.evaluate(Part::All);
        system.copy(first, Register::Rates, Part::All);
        system.axpy(Register::State, 2.0 / 3.0 * step, first, Part::All);
        system.set_time(time + 2.0 / 3.0 * step);
        system.evaluate(Part::All);
        system.copy(Register::State, start, Part::All);
        system.axpy(Register::State, 0.25 * step, first, Part::All);
        system.axpy(Register::State, 0.75 * step, Register::Rates, Part::All);
        system.set_time(time + step);
        Ok(())
    }
}

/// The error after one turn of a circular orbit of radius 1 m and period 2 pi s.
fn error(steps: u32) -> Result<f64, Faults> {
    let pair = Domain::new("bodies")
        .with(Position, [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
        .with(Velocity, [[0.0, -0.5, 0.0], [0.0, 0.5, 0.0]])
        .with(Mass, [0.5, 0.5]);
    let step = core::f64::consts::TAU / f64::from(steps);
    let mut engine = Engine::<f64>::builder()
        .domain(pair)
        .law(Gravity { g: 1.0, softening: 0.0 })
        .law(Motion)
        .integrator(Ralston)
        .step(step)
        .build()?;
    engine.advance(core::f64::consts::TAU)?;
    Ok((engine.state().get("bodies", Position, 1)? - DVec3::new(0.5, 0.0, 0.0)).length())
}

fn main() -> Result<(), Faults> {
    let (coarse, fine) = (error(2000)?, error(4000)?);
    let order = (coarse / fine).log2();
    println!("error {coarse:.3e} with 2000 steps, {fine:.3e} with 4000: order {order:.3}");
    assert!((order - 2.0).abs() < 0.05);
    Ok(())
}
