use vesper::prelude::*;

/// Contact with an immovable plane: a stiff, damped spring where a row has sunk in, and friction against sliding.
///
/// Equation: with the gap g = n . x - d below 0, F_n = -k g - c (n . v) along n, F_t = -mu |F_n| v_t / |v_t| across, v_t the
/// velocity along the plane; no force above. Energy k g^2 / 2 where g < 0.
///
/// Source: Cundall, Strack, Geotechnique 29 (1979) 47.
///
/// Limits: rows are points. The force is not kept from pulling: a row that leaves fast is held back by c. It jumps at the
/// touch where c is above 0, and where sliding ends; a step across such a jump is of first order at best, and friction at
/// rest trembles by mu F_n h / m. The step must resolve sqrt(k / m).
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, velocity: Velocity), adds(force: Force))]
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
}

#[kernel]
impl<R: Real> RowLaw<R> for ContactPlane<R> {
    fn row(&self, body: ContactPlaneRow<R>) -> R::Vec3 {
        let zero = R::lit(0.0);
        let gap = self.normal.dot(body.position) - self.offset;
        let leaving = self.normal.dot(body.velocity);
        let pressure = -self.stiffness * gap - self.damping * leaving;
        let sliding = body.velocity - self.normal * leaving;
        let speed = sliding.length();
        let against = R::select(speed.equal(zero), zero, -self.friction * pressure.abs() / speed);
        let force = self.normal * pressure + sliding * against;
        R::select_vector(gap.less(zero), force, R::Vec3::zero())
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
        let law = ContactPlane { normal: DVec3::X, offset: 2.0, stiffness: 50.0, damping: 3.0, friction: 0.5 };
        let at = |x: f64, velocity: DVec3| ContactPlaneRow { position: DVec3::new(x, 9.0, -4.0), velocity };
        let moving = DVec3::new(-1.0, 3.0, 4.0);
        assert_eq!(RowLaw::<f64>::row(&law, at(2.0, moving)), DVec3::ZERO);
        // 0.1 deep, sinking by 1: 5 + 3 along the normal, 4 against the sliding of 5.
        let force: DVec3 = law.row(at(1.9, moving));
        assert!((force - DVec3::new(8.0, -2.4, -3.2)).length() < 1e-13, "{force}");
        let resting: DVec3 = law.row(at(1.9, DVec3::ZERO));
        assert!((resting - DVec3::X * 5.0).length() < 1e-13, "nothing slides: {resting}");
        assert!((RowLaw::<f64>::energy(&law, at(1.9, moving)) - 0.25).abs() < 1e-14);
    }

    #[test]
    fn a_body_rests_where_its_weight_is_borne() {
        let bodies =
            Domain::new("bodies").with(Position, [[0.0, 0.0, 0.01]]).with(Velocity, [[0.0; 3]]).with(Mass, [2.0]);
        let floor =
            ContactPlane { normal: DVec3::Z, offset: 0.0, stiffness: 2000.0, damping: 40.0, friction: 0.0 };
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
