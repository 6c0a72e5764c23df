use vesper::prelude::*;

/// Relativistic inertia by a mass that grows with the speed, for `motion` to divide the force by.
///
/// Equation: m = m_0 / sqrt(1 - v^2 / c^2); with `motion` its energy makes the kinetic one up to (gamma - 1) m_0 c^2.
///
/// Source: Landau, Lifshitz, The Classical Theory of Fields, 4th ed., eq. 9.1 and 9.2: the mass of a force across the
/// velocity.
///
/// Limits: exact for forces across the velocity, as magnetic ones are. A force along it meets gamma^3 m_0 (ibid., eq. 9.3),
/// which this mass is not: the speed approaches c too late, and can pass it in one step, which ends the run with a number
/// that is none. For the exact law see `relativistic_motion`. Rest mass 0 stays immovable.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(rest_mass: RestMass, velocity: Velocity),
    scene(speed_of_light: SpeedOfLight = 299_792_458.0),
    sets(mass: Mass)
)]
pub struct RelativisticMass;

/// gamma = 1 / sqrt(1 - v^2 / c^2).
#[inline(always)]
fn gamma<R: Real>(body: &RelativisticMassRow<R>) -> R {
    let beta = body.velocity / body.speed_of_light;
    (R::lit(1.0) - beta.length_squared()).rsqrt()
}

#[kernel]
impl<R: Real> RowLaw<R> for RelativisticMass {
    fn row(&self, body: RelativisticMassRow<R>) -> R {
        body.rest_mass * gamma(&body)
    }

    fn energy(&self, body: RelativisticMassRow<R>) -> R {
        // (gamma - 1) m_0 c^2 - gamma m_0 v^2 / 2, of which `motion` tells the second term; with gamma^2 beta^2 =
        // gamma^2 - 1 it is m_0 v^2 gamma (gamma - 1) / (2 (gamma + 1)), and gamma - 1 = gamma^2 beta^2 / (gamma + 1):
        // no difference of nearly equal numbers.
        let gamma = gamma(&body);
        let beta2 = (body.velocity / body.speed_of_light).length_squared();
        let over = gamma / (gamma + R::lit(1.0));
        R::lit(0.5) * body.rest_mass * body.velocity.length_squared() * gamma * over * over * beta2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MagneticForce, Motion};

    #[test]
    fn a_fast_charge_gyrates_slower_by_gamma() {
        // v = 3/5 c: gamma = 5/4, so with q B / m_0 = 5 the angular frequency is 4.
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Velocity, [[6.0, 0.0, 0.0]])
            .with(RestMass, [2.0])
            .with(Charge, [2.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [10.0])
            .field(MagneticField, Uniform { value: [0.0, 0.0, 5.0] })
            .law(RelativisticMass)
            .law(MagneticForce)
            .law(Motion)
            .integrator(RungeKutta4)
            .step(5e-4)
            .build()
            .unwrap();
        let (energy, _) = engine.energy().unwrap();
        assert!((energy - 0.25 * 2.0 * 100.0).abs() < 1e-12, "{energy}");
        engine.advance(2.0).unwrap();
        let velocity = engine.state().get("bodies", Velocity, 0).unwrap();
        let exact = DVec3::new(8.0_f64.cos(), -8.0_f64.sin(), 0.0) * 6.0;
        assert!((velocity - exact).length() < 1e-10, "{velocity}");
    }

    #[test]
    fn slow_rows_have_their_rest_mass_and_half_of_m_v_squared() {
        let row = RelativisticMassRow { rest_mass: 3.0, velocity: DVec3::X, speed_of_light: 1e9 };
        assert_eq!(RelativisticMass.row(row), 3.0);
        // 3/8 m v^4 / c^2, less the 1/4 of it that `motion` tells; by (gamma - 1) c^2 it would be rounding noise.
        assert!((RelativisticMass.energy(row) / (3.0 / 8.0 * 1e-18) - 1.0).abs() < 1e-15);
    }
}
