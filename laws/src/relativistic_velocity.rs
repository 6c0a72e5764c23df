use vesper::prelude::*;

/// Velocity of rows whose state is the momentum, for laws that read a velocity.
///
/// Equation: v = p / sqrt(m_0^2 + p^2 / c^2).
///
/// Source: Landau, Lifshitz, The Classical Theory of Fields, 4th ed., eq. 9.1 and 9.8.
///
/// Limits: exact. A row of rest mass 0 is immovable: its velocity is 0. The velocity must not be given by the client.
/// In f32 rest masses as in `relativistic_motion`.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(momentum: Momentum, rest_mass: RestMass),
    scene(speed_of_light: SpeedOfLight = 299_792_458.0),
    sets(velocity: Velocity)
)]
pub struct RelativisticVelocity;

#[kernel]
impl<R: Real> RowLaw<R> for RelativisticVelocity {
    fn row(&self, body: RelativisticVelocityRow<R>) -> R::Vec3 {
        let over_c = body.momentum / body.speed_of_light;
        let mass = (body.rest_mass * body.rest_mass + over_c.length_squared()).sqrt();
        R::select_vector(body.rest_mass.equal(R::lit(0.0)), R::Vec3::zero(), body.momentum / mass)
    }

    fn energy(&self, _body: RelativisticVelocityRow<R>) -> R {
        R::lit(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MagneticForce, RelativisticMotion};

    #[test]
    fn a_fast_charge_gyrates_slower_by_gamma() {
        // v = 4/5 c: gamma = 5/3, p = gamma m_0 v = 8; with q B / m_0 = 5 the angular frequency is 3.
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]])
            .with(Momentum, [[8.0, 0.0, 0.0]])
            .with(RestMass, [2.0])
            .with(Charge, [2.0]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .constant(SpeedOfLight, [3.0])
            .field(MagneticField, Uniform { value: [0.0, 0.0, 5.0] })
            .law(RelativisticVelocity)
            .law(MagneticForce)
            .law(RelativisticMotion)
            .integrator(RungeKutta4)
            .step(1e-3)
            .build()
            .unwrap();
        engine.advance(2.0).unwrap();
        let momentum = engine.state().get("bodies", Momentum, 0).unwrap();
        assert!((momentum - DVec3::new(6.0_f64.cos(), -6.0_f64.sin(), 0.0) * 8.0).length() < 1e-10, "{momentum}");
        let place = engine.state().get("bodies", Position, 0).unwrap();
        let radius = 2.4 / 3.0;
        let exact = DVec3::new(6.0_f64.sin(), 6.0_f64.cos() - 1.0, 0.0) * radius;
        assert!((place - exact).length() < 1e-10, "{place}");
    }
}
