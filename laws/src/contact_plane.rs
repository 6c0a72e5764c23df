use vesper::prelude::*;

property! {
    /// Height of a row above a plane; in contact below 0.
    pub Gap: Scalar, "m", switch;
    /// Direction in which a row slides along a plane; 0 at rest.
    pub SlidingDirection: Vector, "1", switch;
    /// Velocity in that direction; at rest, what a row's speed has above that of rest: below 0 where it rests.
    pub Sliding: Scalar, "m/s", switch;
}

/// Contact with an immovable plane: a stiff, damped spring where a row has sunk in, and friction against sliding.
///
/// Equation: with the gap g = n . x - d below 0, F_n = -k g - c (n . v) along n, F_t = -mu |F_n| v_t / |v_t| across, v_t the
/// velocity along the plane; no force above. Energy k g^2 / 2 where g < 0.
///
/// Source: Cundall, Strack, Geotechnique 29 (1979) 47.
///
/// Limits: rows are points. The force is not kept from pulling: a row that leaves fast is held back by c. The touch and the
/// end of sliding are switches: steps end there. A row at rest stays so while its speed is below `resting_speed`; what pulls it
/// along the plane is not held against, so that on a slope it creeps at such speeds. The step must resolve sqrt(k / m).
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(position: Position, velocity: Velocity, previous height: Gap, previous course: SlidingDirection),
    sets(gap: Gap, direction: SlidingDirection, sliding: Sliding),
    adds(force: Force)
)]
pub struct ContactPlane<R: Real = f64> {
    /// Unit vector out of the plane.
    #[law(unit = "1", default = [0.0, 0.0, 1.0])]
    pub normal: R::Vec3,
    /// Distance of the plane from the origin, along the normal.
    #[law(unit = "m", default = 0.0)]
    pub offset: R,
    /// Force per depth.
    #[law(unit = "N/m")]
    pub stiffness: R,
    /// Force per velocity of sinking in.
    #[law(unit = "N s/m", default = 0.0)]
    pub damping: R,
    /// Coefficient of friction.
    #[law(unit = "1", default = 0.0)]
    pub friction: R,
    /// Speed along the plane up to which a row at rest stays so.
    #[law(unit = "m/s", default = 1e-6)]
    pub resting_speed: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for ContactPlane<R> {
    fn row(&self, body: ContactPlaneRow<R>) -> ContactPlaneOutput<R> {
        let (zero, none) = (R::lit(0.0), R::Vec3::zero());
        let gap = self.normal.dot(body.position) - self.offset;
        let leaving = self.normal.dot(body.velocity);
        let pressure = -self.stiffness * gap - self.damping * leaving;
        let along = body.velocity - self.normal * leaving;
        let speed = along.length();
        let way = along / R::select(speed.equal(zero), R::lit(1.0), speed);

        // Beyond the end of sliding the force goes on as before it, until the switch turns: a step there stays smooth. And so
        // it does just before, where the direction of what is left of the velocity is that of rounding errors.
        let onward = along.dot(body.course);
        let rests = body.course.length_squared().equal(zero);
        let fast = speed - self.resting_speed;
        let against = R::select_vector(onward.less(zero), -way, way);
        let against = R::select_vector(fast.less(zero), body.course, against);
        let against = R::select_vector(rests, none, against);
        let force = self.normal * pressure - against * (self.friction * pressure.abs());

        let starts = R::select_vector(fast.less(zero), none, way);
        let goes_on = R::select_vector(onward.less(zero), none, way);
        let smooth = self.friction.equal(zero);
        ContactPlaneOutput {
            gap,
            direction: R::select_vector(smooth, none, R::select_vector(rests, starts, goes_on)),
            sliding: R::select(smooth, R::lit(1.0), R::select(rests, fast, onward)),
            force: R::select_vector(body.height.less(zero), force, none),
        }
    }

    fn energy(&self, body: ContactPlaneRow<R>) -> R {
        let depth = (self.offset - self.normal.dot(body.position)).max(R::lit(0.0));
        R::lit(0.5) * self.stiffness * depth * depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, UniformGravity};

    #[test]
    fn nothing_above_and_a_push_below() {
        let law = ContactPlane {
            normal: DVec3::X,
            offset: 2.0,
            stiffness: 50.0,
            damping: 3.0,
            friction: 0.5,
            resting_speed: 1e-6,
        };
        // Held in contact or not, and sliding along y and z or at rest.
        let held = |x: f64, velocity: DVec3, height: f64, course: DVec3| ContactPlaneRow {
            position: DVec3::new(x, 9.0, -4.0),
            velocity,
            height,
            course,
        };
        let (moving, course) = (DVec3::new(-1.0, 3.0, 4.0), DVec3::new(0.0, 0.6, 0.8));
        let at = |x: f64, velocity: DVec3| held(x, velocity, x - 2.0, course);
        assert_eq!(RowLaw::<f64>::row(&law, at(2.0, moving)).force, DVec3::ZERO);
        // 0.1 deep, sinking by 1: 5 + 3 along the normal, 4 against the sliding of 5.
        let force: DVec3 = law.row(at(1.9, moving)).force;
        assert!((force - DVec3::new(8.0, -2.4, -3.2)).length() < 1e-13, "{force}");
        let resting: DVec3 = law.row(held(1.9, DVec3::ZERO, -0.1, DVec3::ZERO)).force;
        assert!((resting - DVec3::X * 5.0).length() < 1e-13, "nothing slides: {resting}");
        // What is held decides, and not where the row is; a row that slides back is still pushed on.
        let above: DVec3 = law.row(held(2.1, DVec3::ZERO, -0.1, DVec3::ZERO)).force;
        assert!((above + DVec3::X * 5.0).length() < 1e-13, "{above}");
        let back = law.row(held(1.9, DVec3::new(0.0, -3.0, -4.0), -0.1, course));
        assert!((back.force - DVec3::new(5.0, -1.5, -2.0)).length() < 1e-13, "{}", back.force);
        assert_eq!((back.direction, back.sliding), (DVec3::ZERO, -5.0));
        assert!((RowLaw::<f64>::energy(&law, at(1.9, moving)) - 0.25).abs() < 1e-14);
    }

    #[test]
    fn a_body_rests_where_its_weight_is_borne() {
        let bodies =
            Domain::new("bodies").with(Position, [[0.0, 0.0, 0.01]]).with(Velocity, [[0.0; 3]]).with(Mass, [2.0]);
        let floor =
            ContactPlane { normal: DVec3::Z, offset: 0.0, stiffness: 2000.0, damping: 40.0, friction: 0.0, resting_speed: 1e-6 };
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(GravityAcceleration, [[0.0, 0.0, -10.0]])
            .law(UniformGravity)
            .law(floor)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(5.0).unwrap();
        let place = engine.state().get("bodies", Position, 0).unwrap();
        assert!((place.z + 0.01).abs() < 1e-12, "{place}");
    }
}
