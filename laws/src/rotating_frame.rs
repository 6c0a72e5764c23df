use vesper::prelude::*;

/// Forces of inertia in a frame that turns at a constant rate about an axis through the origin.
///
/// Equation: F = -2 m w x v - m w x (w x x); energy -m |w x x|^2 / 2, of the centrifugal force; that of Coriolis does no
/// work. With the energies of the other laws it sums to the Jacobi constant times m.
///
/// Source: Landau, Lifshitz, Mechanics, 3rd ed., eq. 39.9, with a constant angular velocity.
///
/// Limits: constant angular velocity, no acceleration of the origin. The force depends on the velocity: symplectic
/// integrators refuse it, leapfrog takes a second evaluation per step, `boris` turns by 2 m w.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, velocity: Velocity, mass: Mass), adds(force: Force, turn: Turn))]
pub struct RotatingFrame<R: Real = f64> {
    /// Angular velocity of the frame.
    #[law(unit = "rad/s")]
    pub angular_velocity: R::Vec3,
}

#[kernel]
impl<R: Real> RowLaw<R> for RotatingFrame<R> {
    fn row(&self, body: RotatingFrameRow<R>) -> RotatingFrameOutput<R> {
        let turning = self.angular_velocity.cross(body.position);
        let acceleration = self.angular_velocity.cross(body.velocity * R::lit(2.0) + turning);
        RotatingFrameOutput {
            force: acceleration * -body.mass,
            turn: self.angular_velocity * (R::lit(2.0) * body.mass),
        }
    }

    fn energy(&self, body: RotatingFrameRow<R>) -> R {
        R::lit(-0.5) * body.mass * self.angular_velocity.cross(body.position).length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn what_flies_straight_outside_spirals_inside() {
        // At rest in the inertial frame at (3, 0, 0), seen from a frame that turns about z at 0.5 rad/s.
        let bodies = Domain::new("bodies")
            .with(Position, [[3.0, 0.0, 0.0]])
            .with(Velocity, [[1.0, -1.5, 0.25]])
            .with(Mass, [2.0]);
        let frame = RotatingFrame { angular_velocity: DVec3::Z * 0.5 };
        let builder = Engine::<f64>::builder().domain(bodies).law(frame).law(Motion);
        let mut engine = builder.integrator(GaussRadau15::default()).build().unwrap();
        let before = engine.energy().unwrap().0;
        engine.advance(4.0).unwrap();
        // Outside: x = 3 + t, y = 0, z = t / 4; turned back by 2 rad.
        let (sine, cosine) = 2.0_f64.sin_cos();
        let place = engine.state().get("bodies", Position, 0).unwrap();
        assert!((place - DVec3::new(7.0 * cosine, -7.0 * sine, 1.0)).length() < 1e-13, "{place}");
        let (after, silent) = engine.energy().unwrap();
        assert!((after - before).abs() < 1e-13 && silent.is_empty());
    }
}
