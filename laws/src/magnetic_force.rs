use vesper::prelude::*;

/// Force of a magnetic field on moving charges.
///
/// Equation: F = q v x B(x, t); it does no work, so its energy is 0.
///
/// Source: Griffiths, Introduction to Electrodynamics, 4th ed., eq. 5.1.
///
/// Limits: the charges do not act back on the field, and do not radiate. The step must resolve the gyration, of angular
/// frequency q B / m; semi-implicit Euler lets the speed grow by (q B h / m)^2 / 2 of itself per step. `boris` and its kin
/// turn the velocity by q B instead of adding the force, and keep the speed.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, charge: Charge), fields(field: MagneticField), adds(force: Force, turn: Turn))]
pub struct MagneticForce;

#[kernel]
impl<R: Real> RowLaw<R> for MagneticForce {
    fn row(&self, body: MagneticForceRow<R>) -> MagneticForceOutput<R> {
        MagneticForceOutput { force: body.velocity.cross(body.field) * body.charge, turn: body.field * body.charge }
    }

    fn energy(&self, _body: MagneticForceRow<R>) -> R {
        R::lit(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_charge_gyrates_clockwise_and_drifts_along_the_field() {
        // q B / m = 4, v = 2 across and 3 along: radius 1/2 about (0, -1/2).
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[2.0, 0.0, 3.0]])
            .with(Mass, [0.5])
            .with(Charge, [1.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .field(MagneticField, Uniform { value: [0.0, 0.0, 2.0] })
            .law(MagneticForce)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(5e-4)
            .build()
            .unwrap();
        engine.advance(2.0).unwrap();
        let place = engine.state().get("bodies", Position, 0).unwrap();
        let exact = DVec3::new(0.5 * 8.0_f64.sin(), 0.5 * (8.0_f64.cos() - 1.0), 6.0);
        assert!((place - exact).length() < 1e-11, "{place}");
        let (energy, silent) = engine.energy().unwrap();
        assert!((energy - 0.25 * 13.0).abs() < 1e-11 && silent.is_empty());
    }
}
