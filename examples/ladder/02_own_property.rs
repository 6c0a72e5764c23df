//! A quantity that the framework has never heard of, with a unit, a law that gives its rate, and one that reads it.
//!
//! `cargo run --release --example own_property`

use vesper::prelude::*;

property! {
    /// Temperature of a body.
    pub Temperature: Scalar, "K";
    /// Heat that a body takes up per kelvin.
    pub HeatCapacity: Scalar, "J/K";
    /// Sum of all heat flows into a body.
    pub HeatFlow: Scalar, "W", sum;
}

/// Cooling by a medium around, after Newton: Q = -h (T - T0).
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(temperature: Temperature), adds(heat: HeatFlow))]
pub struct Cooling<R = f64> {
    /// Heat flow per kelvin of difference.
    #[law(unit = "W/K", default = 2.0)]
    pub h: R,
    /// Temperature of the medium.
    #[law(unit = "K", default = 293.15)]
    pub ambient: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Cooling<R> {
    fn row(&self, body: CoolingRow<R>) -> R {
        self.h * (self.ambient - body.temperature)
    }
}

/// Warming: T' = Q / C. A law gives the rate; integrating it is the integrator's work.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(heat: HeatFlow, capacity: HeatCapacity), rates(temperature: Temperature))]
pub struct Warming;

#[kernel]
impl<R: Real> RowLaw<R> for Warming {
    fn row(&self, body: WarmingRow<R>) -> R {
        body.heat / body.capacity
    }
}

fn main() -> Result<(), Faults> {
    let cups =
        || Domain::<f64>::new("cups").with(Temperature, [363.15, 293.15]).with_unit(HeatCapacity, "kJ/K", [0.84, 0.84]);

    // Leapfrog wants coordinates and momenta; a temperature is neither, and the builder says so.
    let refused = Engine::builder().domain(cups()).law(Cooling::default()).law(Warming).build();
    println!("refused: {}\n", refused.err().map_or(String::new(), |faults| faults.to_string()));

    let mut engine = Engine::builder()
        .domain(cups())
        .law(Cooling::default())
        .law(Warming)
        .integrator(RungeKutta4)
        .step(1.0)
        .build()?;
    engine.advance(600.0)?;

    let hot = engine.state().get("cups", Temperature, 0)?;
    let exact = 293.15 + 70.0 * (-2.0 * 600.0 / 840.0_f64).exp();
    println!("after 10 min: {hot:.6} K, exactly {exact:.6} K");
    assert!((hot - exact).abs() < 1e-9);
    assert!((engine.state().get("cups", Temperature, 1)? - 293.15).abs() < 1e-12);
    Ok(())
}
