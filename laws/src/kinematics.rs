use vesper::prelude::*;

/// Motion of rows whose laws give accelerations instead of forces, as in celestial mechanics.
///
/// Equation: x' = v, v' = a; energy GM v^2 / 2, which is the kinetic energy times G.
///
/// Source: Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., eq. 1.1 and 1.6.
///
/// Limits: no row is immovable. The energy is in units of G: J m^3 kg^-1 s^-2, consistent with `gravity_by_parameter`,
/// so its drift means what that of an energy does; without `standard_gravitational_parameter` it is 0 throughout.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(velocity: Velocity, acceleration: Acceleration),
    reads(parameter: StandardGravitationalParameter, optional),
    rates(position: Position from (velocity), velocity: Velocity from (acceleration)),
    second_order
)]
pub struct Kinematics;

#[kernel]
impl<R: Real> RowLaw<R> for Kinematics {
    fn row(&self, body: KinematicsRow<R>) -> KinematicsOutput<R> {
        KinematicsOutput { position: body.velocity, velocity: body.acceleration }
    }

    fn energy(&self, body: KinematicsRow<R>) -> R {
        let parameter = body.parameter.unwrap_or(R::lit(0.0));
        R::lit(0.5) * parameter * body.velocity.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_acceleration_gives_a_parabola() {
        /// Free fall, as an acceleration.
        #[derive(Law, Clone, Copy, Debug)]
        #[law(scene(gravity: GravityAcceleration), adds(acceleration: Acceleration))]
        struct Fall;
        #[kernel]
        impl<R: Real> RowLaw<R> for Fall {
            fn row(&self, body: FallRow<R>) -> R::Vec3 {
                body.gravity
            }
        }
        let bodies = Domain::new("bodies").with(Position, [[0.0, 0.0, 1.0]]).with(Velocity, [[1.0, 0.0, 4.0]]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -8.0]])
            .law(Fall)
            .law(Kinematics)
            .step(0.25)
            .build()
            .unwrap();
        engine.advance(1.0).unwrap();
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(engine.state().get("bodies", Velocity, 0).unwrap(), DVec3::new(1.0, 0.0, -4.0));
    }

    #[test]
    fn energy_is_by_parameter() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[3.0, 0.0, 4.0]])
            .with(StandardGravitationalParameter, [2.0]);
        let mut engine = Engine::<f64>::builder().domain(bodies).law(Kinematics).step(1.0).build().unwrap();
        assert_eq!(engine.energy().unwrap(), (25.0, vec![]));
    }
}
