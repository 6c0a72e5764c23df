use vesper::prelude::*;

/// Newton's law of universal gravitation between point masses, softened as by Plummer.
///
/// Equation: F_i = sum over j of G m_i m_j d / (|d|^2 + s^2)^(3/2), d = x_j - x_i; energy of a pair
/// -G m_i m_j / (|d|^2 + s^2)^(1/2).
///
/// Source: Newton, Principia (1687), III, prop. 7; the softened potential: Binney, Tremaine, Galactic Dynamics, 2nd ed.,
/// eq. 2.44a. G: CODATA 2022.
///
/// Limits: every pair is visited, n^2 work. Without softening singular where two rows meet; with it the force is that of
/// a Plummer sphere of radius s, too weak within a few s. Slow motion in weak fields; see `post_newtonian`. In f32 the
/// product G m_i m_j comes first and must stay below 3e38 N m^2: that of Sun and Earth is 8e44 N m^2, so take
/// `gravity_by_parameter`, or other units. Distances lie between 3e-13 m and 7e12 m, for their cubes.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), translation_invariant, antisymmetric, estimates)]
pub struct Gravity<R = f64> {
    /// Constant of gravitation.
    #[law(unit = "m^3 kg^-1 s^-2", default = 6.674_30e-11)]
    pub g: R,
    /// Softening length.
    #[law(unit = "m", default = 0.0)]
    pub softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Gravity<R> {
    fn pair(&self, i: GravityRow<R>, j: GravityRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared() + self.softening * self.softening;
        d * (self.g * i.mass * j.mass).over_root_cubed(r2)
    }

    fn energy(&self, i: GravityRow<R>, j: GravityRow<R>) -> R {
        let r2 = (j.position - i.position).length_squared() + self.softening * self.softening;
        -self.g * i.mass * j.mass / r2.sqrt()
    }

    fn inverse_square(&self, row: GravityRow<R>) -> InverseSquare<R> {
        InverseSquare { source: row.mass, response: self.g * row.mass, softening: self.softening }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn two_bodies_circle_each_other() {
        // Masses 3 and 1 at a distance of 1, G = 1: angular velocity 2 about the centre of mass.
        let bodies = Domain::new("bodies")
            .with(Position, [[-0.25, 0.0, 0.0], [0.75, 0.0, 0.0]])
            .with(Velocity, [[0.0, -0.5, 0.0], [0.0, 1.5, 0.0]])
            .with(Mass, [3.0, 1.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .law(Gravity { g: 1.0, softening: 0.0 })
            .law(Motion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        let (energy, silent) = engine.energy().unwrap();
        assert!((energy - (1.5 - 3.0)).abs() < 1e-15 && silent.is_empty());
        engine.advance(3.0).unwrap();
        let place = engine.state().get("bodies", Position, 1).unwrap();
        let exact = DVec3::new(6.0_f64.cos(), 6.0_f64.sin(), 0.0) * 0.75;
        assert!((place - exact).length() < 1e-11, "{place}");
    }

    #[test]
    fn softening_is_a_plummer_sphere() {
        let law = Gravity { g: 2.0, softening: 3.0 };
        let row = |x: f64, mass: f64| GravityRow { position: DVec3::new(x, 0.0, 0.0), mass };
        // |d| = 4: (16 + 9)^(3/2) = 125.
        assert_eq!(law.pair(row(0.0, 5.0), row(4.0, 7.0)), DVec3::X * (4.0 * (2.0 * 5.0 * 7.0 / 125.0)));
        assert_eq!(law.energy(row(0.0, 5.0), row(4.0, 7.0)), -2.0 * 5.0 * 7.0 / 5.0);
        assert_eq!(law.pair(row(1.0, 5.0), row(1.0, 7.0)), DVec3::ZERO);
    }

    #[test]
    fn the_product_of_the_masses_bounds_f32() {
        let law = Gravity::<f32> { g: 6.674_30e-11, softening: 0.0 };
        let force = |masses: [f32; 2], distance: f32| {
            let row = |x: f32, mass: f32| GravityRow::<f32> { position: Vec3::new(x, 0.0, 0.0), mass };
            law.pair(row(0.0, masses[0]), row(distance, masses[1])).x
        };
        // Sun and Earth are beyond it; 4e48 kg^2 are not.
        assert!(force([1.988e30, 5.972e24], 1.496e11).is_infinite());
        assert!((force([2e24, 2e24], 6.9e12) / 5.607_477e12 - 1.0).abs() < 1e-6);
        // The cube of the distance near its least, and beyond its largest.
        assert!((force([1.0, 1.0], 3e-13) / 7.415_889e14 - 1.0).abs() < 1e-6);
        assert_eq!(force([1.0, 1.0], 7.1e12), 0.0);
    }
}
