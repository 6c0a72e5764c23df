use crate::spheres::{Attraction, accelerations};
use vesper::prelude::*;

/// Gravitation by spheres of influence: each row goes round the one in whose sphere it is, and moves with it.
///
/// Equation: a tree of two-body problems. Row i is in the sphere of a heavier row c, which itself goes round p, where
/// |x_i - x_c| < (m_c / m_p)^(2/5) min(|x_c - x_p|, |x_i - x_p|). It goes round the row of the smallest such sphere that
/// lies in spheres which hold it too, or round the heaviest row. What goes round p is put in order by its distance. Each
/// thing there (a row with all that goes round it, of mass M, its centre of mass at X) and all that is further in, p
/// included (of mass M', at X'), attract each other: each row of the thing gets the acceleration
/// G M' d / (|d|^2 + s^2)^(3/2), d = X' - X, and each row further in -G M d / (|d|^2 + s^2)^(3/2). The force on a row is
/// its mass times the sum of what it gets so.
///
/// Source: the spheres: Laplace, Mecanique celeste IV (1805), book 9, ch. 2; Bate, Mueller, White, Fundamentals of
/// Astrodynamics (1971), ch. 7; Battin, An Introduction to the Mathematics and Methods of Astrodynamics (1987). The
/// two-body problems are those of Jacobi's coordinates: Wisdom, Holman, AJ 102 (1991) 1528.
///
/// Limits: a cheap model beside `gravity`, for n log n work: it leaves out what neighbours do to each other, and the tide
/// of what is further out. In ten years it is off by 16 000 km for Mercury, 100 000 km for the Earth, 1 500 000 km for
/// Saturn, and in one year by 150 000 km for the Moon, whose ellipse the Sun turns. Momentum and angular momentum are
/// kept; energy is, while the tree stays the same, but it is not told. The tree is found anew in every evaluation. Where
/// a row crosses a sphere, or comes to be further out than its neighbour, accelerations jump by what either side leaves
/// out, as in patched conics: steps go across, and the error of any integrator is of first order there. Adaptive ones
/// take short steps. A row of mass 0 is immovable, attracts nothing, and is not attracted: test particles have a small
/// mass, below `lightest`. Without softening singular where a row meets what it goes round. Rows of like masses (a
/// cluster) get a tree too, but no good one.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force))]
pub struct HierarchicalGravity<R = f64> {
    /// Constant of gravitation.
    #[law(unit = "m^3 kg^-1 s^-2", default = 6.674_30e-11)]
    pub g: R,
    /// Softening length.
    #[law(unit = "m", default = 0.0)]
    pub softening: R,
    /// Mass below which a row has no sphere, and does not attract others of that kind next to it.
    #[law(unit = "kg", default = 0.0)]
    pub lightest: R,
}

#[kernel]
impl<P: Precision> ColumnLaw<P> for HierarchicalGravity<P> {
    fn columns(&self, mut rows: HierarchicalGravityColumns<'_, P>) {
        let zero = P::lit(0.0);
        let mut bodies: Vec<(P, usize)> = Vec::with_capacity(rows.mass.len());
        for row in 0..rows.mass.len() {
            let mass = rows.mass.get(row);
            if mass > zero {
                bodies.push((mass, row));
            } else if mass != zero {
                // Below 0, or no number: it shows in the force, which is no number either.
                let none = mass.sqrt();
                rows.force.add(row, P::Vec3::new(none, none, none));
            }
        }
        // Heaviest first, of equal ones the first row. All are numbers here.
        bodies.sort_by(|(a, _), (b, _)| b.partial_cmp(a).unwrap_or(core::cmp::Ordering::Equal));
        let attractors = bodies.partition_point(|(mass, _)| *mass >= self.lightest);
        let places: Vec<P::Vec3> = bodies.iter().map(|(_, row)| rows.position.get(*row)).collect();
        let masses: Vec<P> = bodies.iter().map(|(mass, _)| *mass).collect();
        let attraction = Attraction { g: self.g, softening: self.softening };
        let accelerations = accelerations::<P>(&places, &masses, attractors, attraction);
        for ((mass, row), acceleration) in bodies.into_iter().zip(accelerations) {
            rows.force.add(row, acceleration * mass);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gravity, Motion};

    /// The forces on rows.
    fn forces<P: Precision>(law: impl Listing, places: &[[f64; 3]], masses: &[f64]) -> Vec<DVec3> {
        let bodies = Domain::new("bodies")
            .with(Position, places)
            .with(Velocity, vec![[0.0; 3]; places.len()])
            .with(Mass, masses);
        let builder = Engine::<P>::builder().domain(bodies).law(law).observe("bodies", Force);
        let mut engine = builder.integrator(SemiImplicitEuler).step(1.0).build().unwrap();
        // A law that gives no numbers is traced at the end of a step, and the forces are still there.
        let _ = engine.steps_of(1, 1.0);
        engine.state().numbers("bodies", Force).unwrap().chunks_exact(3).map(DVec3::from_slice).collect()
    }

    const LAW: HierarchicalGravity = HierarchicalGravity { g: 1.0, softening: 0.0, lightest: 0.0 };

    /// A star, planets, moons, and light rows everywhere.
    fn many() -> (Vec<[f64; 3]>, Vec<f64>) {
        let mut number = 1_u64;
        let mut next = move || {
            // Knuth's linear congruential generator (MMIX), its upper bits.
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (number >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut places, mut masses) = (vec![[0.0, 0.0, 0.0]], vec![1.0]);
        for planet in 1..6 {
            let [distance, mass] = [f64::from(planet), 1e-3 / f64::from(planet)];
            let at = (DVec3::new(next(), next(), next())).normalize() * distance;
            places.push(at.to_array());
            masses.push(mass);
            for moon in 1..5 {
                let near = (DVec3::new(next(), next(), next())).normalize() * (f64::from(moon) * 0.01 * distance);
                places.push((at + near).to_array());
                masses.push(mass * 1e-4);
            }
        }
        for light in 0..300 {
            places.push([next(), next(), next()].map(|along| 12.0 * along));
            masses.push(1e-9 * f64::from(1 + light % 3));
        }
        (places, masses)
    }

    #[test]
    fn two_rows_attract_each_other_as_newton_says() {
        let places = [[0.0, 1.0, 0.0], [4.0, 1.0, 0.0]];
        for masses in [[5.0, 7.0], [7.0, 5.0], [3.0, 3.0], [1.0, 0.0], [0.0, 0.0]] {
            let law = HierarchicalGravity { softening: 3.0, ..LAW };
            let found = forces::<f64>(law, &places, &masses);
            let newton = forces::<f64>(Gravity { g: 1.0, softening: 3.0 }, &places, &masses);
            assert!(found.iter().zip(&newton).all(|(a, b)| (*a - *b).length() < 1e-15), "{found:?} {newton:?}");
        }
        assert_eq!(forces::<f64>(LAW, &[[1.0; 3]], &[2.0]), [DVec3::ZERO]);
    }

    #[test]
    fn momentum_and_angular_momentum_are_kept() {
        let (places, masses) = many();
        // All have spheres; moons do; planets do; the star does.
        for lightest in [0.0, 1e-8, 1e-5, 1e-2] {
            let found = forces::<f64>(HierarchicalGravity { lightest, ..LAW }, &places, &masses);
            let sum: DVec3 = found.iter().sum();
            let torque: DVec3 = places.iter().zip(&found).map(|(at, force)| DVec3::from_array(*at).cross(*force)).sum();
            let all: f64 = found.iter().map(|force| force.length()).sum();
            assert!(found.iter().all(|force| force.length() > 0.0));
            assert!(sum.length() < 1e-15 * all && torque.length() < 1e-14 * all, "{lightest}: {sum} {torque} {all}");
        }
    }

    #[test]
    fn rows_without_spheres_hardly_differ() {
        let (places, masses) = many();
        let with = forces::<f64>(LAW, &places, &masses);
        let without = forces::<f64>(HierarchicalGravity { lightest: 1e-8, ..LAW }, &places, &masses);
        for (row, (a, b)) in with.iter().zip(&without).enumerate() {
            assert!((*a - *b).length() < 1e-5 * a.length(), "{row}: {a} {b}");
        }
    }

    #[test]
    fn where_a_row_meets_its_attractor_it_is_singular_and_softened_it_is_not() {
        let (places, masses) = ([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [1.0, 1e-3, 1e-6]);
        assert!(forces::<f64>(LAW, &places, &masses)[2].is_nan());
        let softened = forces::<f64>(HierarchicalGravity { softening: 1e-3, ..LAW }, &places, &masses);
        assert!((softened[2] * 1e6 - softened[1] * 1e3).length() < 1e-9, "{softened:?}");
        assert!(forces::<f64>(LAW, &[[0.0; 3]; 2], &[1.0, 1.0])[0].is_nan());
    }

    #[test]
    fn sun_and_earth_fit_into_f32() {
        let (places, masses) = ([[0.0; 3], [1.496e11, 0.0, 0.0], [4.5e12, 0.0, 0.0]], [1.988e30, 5.972e24, 1.024e26]);
        let law = HierarchicalGravity { g: 6.674_30e-11, softening: 0.0, lightest: 0.0 };
        let (single, double) = (forces::<f32>(law, &places, &masses), forces::<f64>(law, &places, &masses));
        assert!(single.iter().zip(&double).all(|(a, b)| (*a - *b).length() < 1e-6 * b.length()), "{single:?} {double:?}");
    }

    #[test]
    fn a_mass_below_zero_is_a_fault_and_mass_zero_stays() {
        let bodies = |masses: [f64; 3]| {
            let bodies = Domain::new("bodies")
                .with(Position, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
                .with(Velocity, [[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]])
                .with(Mass, masses);
            let builder = Engine::<f64>::builder().domain(bodies).law(LAW).law(Motion).step(0.1);
            let mut engine = builder.build().unwrap();
            let ran = engine.steps_of(3, 0.1);
            (ran.is_ok(), engine.state().get("bodies", Position, 2).unwrap())
        };
        assert_eq!(bodies([1.0, 1e-3, 0.0]), (true, DVec3::Y * 2.0));
        assert!(!bodies([1.0, 1e-3, -1.0]).0);
    }
}
