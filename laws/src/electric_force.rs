use vesper::prelude::*;

/// Force of an electric field on charges.
///
/// Equation: F = q E(x, t).
///
/// Source: Jackson, Classical Electrodynamics, 3rd ed., eq. 1.1.
///
/// Limits: the charges do not act back on the field. The energy is unknown, because a function need not have a potential.
/// A field that jumps, as at the edge of a box, costs an error of first order in the step, whatever the integrator.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(charge: Charge), fields(field: ElectricField), adds(force: Force))]
pub struct ElectricForce;

#[kernel]
impl<R: Real> RowLaw<R> for ElectricForce {
    fn row(&self, body: ElectricForceRow<R>) -> R::Vec3 {
        body.field * body.charge
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_uniform_field_accelerates_charges_only() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]; 3])
            .with(Velocity, [[0.0; 3]; 3])
            .with(Mass, [2.0; 3])
            .subset(Charge, [0, 2], [4.0, -4.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .field(ElectricField, Uniform { value: [0.0, 0.5, 0.0] })
            .law(ElectricForce)
            .law(Motion)
            .step(0.25)
            .build()
            .unwrap();
        engine.advance(3.0).unwrap();
        // q E t^2 / (2 m) = 4.5, exactly: leapfrog has no error under a constant force.
        let y: Vec<f64> = engine.state().values("bodies", Position).unwrap().iter().map(|place| place.y).collect();
        assert_eq!(y, [4.5, 0.0, -4.5]);
    }
}
