use vesper::prelude::*;

/// Coulomb's law between point charges at rest, softened as by Plummer.
///
/// Equation: F_i = -sum over j of k q_i q_j d / (|d|^2 + s^2)^(3/2), d = x_j - x_i; energy of a pair
/// k q_i q_j / (|d|^2 + s^2)^(1/2).
///
/// Source: Jackson, Classical Electrodynamics, 3rd ed., eq. 1.2. k = 1 / (4 pi epsilon_0): CODATA 2022.
///
/// Limits: every pair of charged rows is visited; where only a subset of the rows has charges, only those. Slow charges:
/// no magnetic part, no retardation, no radiation. Opposite charges without softening are singular where they meet.
/// In f32 distances lie between 3e-13 m and 7e12 m, for their cubes.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, charge: Charge), adds(force: Force), translation_invariant, antisymmetric, estimates)]
pub struct Coulomb<R = f64> {
    /// Coulomb's constant.
    #[law(unit = "N m^2/C^2", default = 8.987_551_786_2e9)]
    pub k: R,
    /// Softening length.
    #[law(unit = "m", default = 0.0)]
    pub softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Coulomb<R> {
    fn pair(&self, i: CoulombRow<R>, j: CoulombRow<R>) -> R::Vec3 {
        let d = i.position - j.position;
        let r2 = d.length_squared() + self.softening * self.softening;
        d * (self.k * i.charge * j.charge).over_root_cubed(r2)
    }

    fn energy(&self, i: CoulombRow<R>, j: CoulombRow<R>) -> R {
        let r2 = (i.position - j.position).length_squared() + self.softening * self.softening;
        self.k * i.charge * j.charge / r2.sqrt()
    }

    fn inverse_square(&self, row: CoulombRow<R>) -> InverseSquare<R> {
        InverseSquare { source: row.charge, response: -self.k * row.charge, softening: self.softening }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn the_constant_is_that_of_codata() {
        let epsilon_0 = 8.854_187_818_8e-12;
        let k = 1.0 / (4.0 * core::f64::consts::PI * epsilon_0);
        assert!((Coulomb::default().k / k - 1.0).abs() < 1e-11);
    }

    #[test]
    fn equal_charges_fly_apart_to_their_speed_at_infinity() {
        // Two of mass 2 at a distance of 1 with k q^2 = 2: from the energy, 2 m v^2 / 2 = 2 (1 - 1 / r).
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3]; 3])
            .with(Mass, [2.0; 3])
            .subset(Charge, [2, 0], [2.0, 1.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .law(Coulomb { k: 1.0, softening: 0.0 })
            .law(Motion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(10.0).unwrap();
        let at = |row| engine.state().get("bodies", Position, row).unwrap();
        let speed = engine.state().get("bodies", Velocity, 2).unwrap().x;
        let distance = at(2).x - at(0).x;
        assert!((speed - (1.0 - 1.0 / distance).sqrt()).abs() < 1e-11, "{speed} at {distance}");
        assert_eq!(at(1), DVec3::ZERO, "a row without charge feels nothing");
    }

    #[test]
    fn opposite_charges_attract() {
        let row = |x: f64, charge| CoulombRow { position: DVec3::new(x, 0.0, 0.0), charge };
        let law = Coulomb { k: 2.0, softening: 3.0 };
        assert_eq!(law.pair(row(0.0, 5.0), row(4.0, -7.0)), DVec3::X * (4.0 * 70.0 / 125.0));
        assert_eq!(law.energy(row(0.0, 5.0), row(4.0, -7.0)), -14.0);
    }
}
