use vesper::prelude::*;

/// Newton's second law: a force changes the velocity, the velocity changes the position.
///
/// Equation: x' = v, v' = F / m; energy m v^2 / 2.
///
/// Source: Newton, Principia (1687), law II; Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., eq. 1.1 and 1.5.
///
/// Limits: a row of mass 0 is immovable: both rates are 0, whatever its velocity. Constant mass and speeds far below
/// that of light; for others see `relativistic_mass` and `relativistic_motion`.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(velocity: Velocity, force: Force, mass: Mass),
    rates(position: Position from (velocity, mass), velocity: Velocity from (force, mass)),
    second_order
)]
pub struct Motion;

#[kernel]
impl<R: Real> RowLaw<R> for Motion {
    fn row(&self, body: MotionRow<R>) -> MotionOutput<R> {
        // Selected, not branched: force / 0 is computed in the lanes of immovable rows too, and thrown away.
        let immovable = body.mass.equal(R::lit(0.0));
        let zero = R::Vec3::zero();
        MotionOutput {
            position: R::select_vector(immovable, zero, body.velocity),
            velocity: R::select_vector(immovable, zero, body.force / body.mass),
        }
    }

    fn energy(&self, body: MotionRow<R>) -> R {
        R::lit(0.5) * body.mass * body.velocity.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UniformGravity;

    #[test]
    fn a_constant_force_gives_a_parabola_and_mass_zero_stays() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]; 2])
            .with(Velocity, [[3.0, 0.0, 1.0]; 2])
            .with(ExternalForce, [[4.0, -2.0, 0.0]; 2])
            .with(Mass, [2.0, 0.0]);
        let mut engine = Engine::<f64>::builder().domain(bodies).law(Motion).step(0.25).build().unwrap();
        engine.advance(2.0).unwrap();
        // x + v t + F t^2 / (2 m), which leapfrog takes without error; the numbers are exact in binary.
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::new(10.0, -2.0, 2.0));
        assert_eq!(engine.state().get("bodies", Velocity, 0).unwrap(), DVec3::new(7.0, -2.0, 1.0));
        assert_eq!(engine.state().get("bodies", Position, 1).unwrap(), DVec3::ZERO);
        assert_eq!(engine.state().get("bodies", Velocity, 1).unwrap(), DVec3::new(3.0, 0.0, 1.0));
        assert_eq!(engine.energy().unwrap(), (54.0, vec![]));
    }

    #[test]
    fn an_immovable_row_feels_no_weight_either() {
        let bodies =
            Domain::new("bodies").with(Position, [[1.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [0.0]);
        let mut engine = Engine::<f32>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -9.81]])
            .law(UniformGravity)
            .law(Motion)
            .step(0.125)
            .build()
            .unwrap();
        engine.advance(1.0).unwrap();
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), Vec3::ONE);
    }
}
