use vesper::prelude::*;

/// Weight in a field of gravity that is a function of position and time.
///
/// Equation: F = m g(x, t).
///
/// Source: Binney, Tremaine, Galactic Dynamics, 2nd ed., sec. 2.1: force is mass times the field.
///
/// Limits: the bodies do not act back on what makes the field, so momentum is not conserved. The energy is unknown,
/// because a function need not have a potential. A field that jumps costs an error of first order in the step.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), fields(field: GravityField), adds(force: Force))]
pub struct FieldGravity;

#[kernel]
impl<R: Real> RowLaw<R> for FieldGravity {
    fn row(&self, body: FieldGravityRow<R>) -> R::Vec3 {
        body.field * body.mass
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_linear_field_makes_an_oscillator() {
        // g = -4 x: angular frequency 2, so x = cos 2t whatever the mass.
        let bodies = Domain::new("bodies")
            .with(Position, [[1.0, 0.0, 0.0]; 2])
            .with(Velocity, [[0.0; 3]; 2])
            .with(Mass, [0.5, 70.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .field(GravityField, |position: DVec3, _time: f64| position * -4.0)
            .law(FieldGravity)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(2.0).unwrap();
        for row in 0..2 {
            let place = engine.state().get("bodies", Position, row).unwrap();
            assert!((place - DVec3::new(4.0_f64.cos(), 0.0, 0.0)).length() < 1e-11, "{place}");
        }
    }

    #[test]
    fn the_time_reaches_the_field() {
        // g = 6 t: x = t^3, which Runge-Kutta 4 takes without error but for rounding.
        let bodies = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [3.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .field(GravityField, |_position: DVec3, time: f64| DVec3::X * (6.0 * time))
            .law(FieldGravity)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(0.125)
            .build()
            .unwrap();
        engine.advance(2.0).unwrap();
        let x = engine.state().get("bodies", Position, 0).unwrap().x;
        assert!((x - 8.0).abs() < 1e-13, "{x}");
    }
}
