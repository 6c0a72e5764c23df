use vesper::prelude::*;

/// The potential of Henon and Heiles, a yardstick for orbits that are regular here and chaotic there.
///
/// Equation: V = k (x^2 + y^2) / 2 + l (x^2 y - y^3 / 3), F = -grad V; nothing along z; energy V.
///
/// Source: Henon, Heiles, AJ 69 (1964) 73, where k = l = 1.
///
/// Limits: for k = l = 1 orbits are bound below an energy of 1/6, and leave through one of three gaps above.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
pub struct HenonHeiles<R = f64> {
    /// Stiffness of the quadratic part.
    #[law(unit = "N/m", default = 1.0)]
    pub stiffness: R,
    /// Strength of the cubic part.
    #[law(unit = "N/m^2", default = 1.0)]
    pub cubic: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for HenonHeiles<R> {
    fn row(&self, body: HenonHeilesRow<R>) -> R::Vec3 {
        let (x, y) = (body.position.x(), body.position.y());
        let along_x = -(self.stiffness + R::lit(2.0) * self.cubic * y) * x;
        let along_y = self.cubic * (y * y - x * x) - self.stiffness * y;
        R::Vec3::new(along_x, along_y, R::lit(0.0))
    }

    fn energy(&self, body: HenonHeilesRow<R>) -> R {
        let (x, y) = (body.position.x(), body.position.y());
        let quadratic = R::lit(0.5) * self.stiffness * (x * x + y * y);
        quadratic + self.cubic * y * (x * x - y * y / R::lit(3.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_the_slope_of_the_energy_and_saddles_are_at_rest() {
        let law = HenonHeiles { stiffness: 1.5, cubic: 0.75 };
        let at = |x: f64, y: f64| HenonHeilesRow { position: DVec3::new(x, y, 0.3) };
        let (x, y, h) = (0.4, -0.2, 1e-6);
        let force: DVec3 = law.row(at(x, y));
        let slope = |dx: f64, dy: f64| -> f64 {
            (law.energy(at(x - dx, y - dy)) - law.energy(at(x + dx, y + dy))) / (2.0 * h)
        };
        assert!((force - DVec3::new(slope(h, 0.0), slope(0.0, h), 0.0)).length() < 1e-9);
        // The saddle (0, 1), of energy 1/6, for k = l = 1.
        let saddle = HenonHeilesRow { position: DVec3::Y };
        let law = HenonHeiles { stiffness: 1.0, cubic: 1.0 };
        assert_eq!(RowLaw::<f64>::row(&law, saddle), DVec3::ZERO);
        assert!((RowLaw::<f64>::energy(&law, saddle) - 1.0 / 6.0).abs() < 1e-16);
    }
}
