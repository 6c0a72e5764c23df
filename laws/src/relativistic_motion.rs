use vesper::prelude::*;

/// The second law of special relativity, exact, with momentum as the state.
///
/// Equation: p' = F, x' = p / (gamma m_0), gamma m_0 = sqrt(m_0^2 + p^2 / c^2); energy (gamma - 1) m_0 c^2.
///
/// Source: Landau, Lifshitz, The Classical Theory of Fields, 4th ed., eq. 9.1, 9.4 and 9.8.
///
/// Limits: no radiation, no retardation between the rows. A row of rest mass 0 is immovable, not a photon. Laws that read
/// the velocity, as `magnetic_force` does, need `relativistic_velocity` too. In f32 rest masses lie between 2e-19 kg and
/// 1e19 kg, for their squares: elementary particles need other units.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(momentum: Momentum, force: Force, rest_mass: RestMass),
    scene(speed_of_light: SpeedOfLight = 299_792_458.0),
    rates(
        position: Position from (momentum, rest_mass, speed_of_light),
        momentum: Momentum from (force, rest_mass)
    )
)]
pub struct RelativisticMotion;

#[kernel]
impl<R: Real> RowLaw<R> for RelativisticMotion {
    fn row(&self, body: RelativisticMotionRow<R>) -> RelativisticMotionOutput<R> {
        let immovable = body.rest_mass.equal(R::lit(0.0));
        let zero = R::Vec3::zero();
        let over_c = body.momentum / body.speed_of_light;
        let mass = (body.rest_mass * body.rest_mass + over_c.length_squared()).sqrt();
        RelativisticMotionOutput {
            position: R::select_vector(immovable, zero, body.momentum / mass),
            momentum: R::select_vector(immovable, zero, body.force),
        }
    }

    fn energy(&self, body: RelativisticMotionRow<R>) -> R {
        // (gamma - 1) m_0 c^2 = (gamma^2 - 1) m_0 c^2 / (gamma + 1) = p^2 / (m_0 + gamma m_0): no difference of nearly
        // equal numbers at low speed.
        let over_c = body.momentum / body.speed_of_light;
        let mass = (body.rest_mass * body.rest_mass + over_c.length_squared()).sqrt();
        let kinetic = body.momentum.length_squared() / (body.rest_mass + mass);
        R::select(body.rest_mass.equal(R::lit(0.0)), R::lit(0.0), kinetic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(force: f64) -> Engine<f64> {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]; 2])
            .with(Momentum, [[0.0; 3]; 2])
            .with(RestMass, [2.0, 0.0])
            .with(ExternalForce, [[force, 0.0, 0.0]; 2]);
        let engine = Engine::<f64>::builder().domain(bodies).constant(SpeedOfLight, [10.0]).law(RelativisticMotion);
        engine.integrator(RungeKutta4).step(1e-2).build().unwrap()
    }

    #[test]
    fn a_constant_force_gives_hyperbolic_motion() {
        let mut engine = pushed(8.0);
        engine.advance(5.0).unwrap();
        // p = F t; x = (m c^2 / F) (sqrt(1 + (F t / m c)^2) - 1) (Landau, Lifshitz, par. 20); here F t / m c = 2.
        let place = engine.state().get("bodies", Position, 0).unwrap().x;
        let exact = 25.0 * (5.0_f64.sqrt() - 1.0);
        assert!((place - exact).abs() < 1e-9, "{place}");
        assert!((engine.state().get("bodies", Momentum, 0).unwrap().x - 40.0).abs() < 1e-12);
        // The work of the force is the energy.
        assert!((engine.energy().unwrap().0 - 8.0 * exact).abs() < 1e-11);
        assert_eq!(engine.state().get("bodies", Position, 1).unwrap(), DVec3::ZERO, "rest mass 0 is immovable");
    }

    #[test]
    fn the_energy_of_slow_rows_is_not_rounded_away() {
        let row = RelativisticMotionRow {
            momentum: DVec3::new(3e-3, 0.0, 0.0),
            force: DVec3::ZERO,
            rest_mass: 3.0,
            speed_of_light: 299_792_458.0,
        };
        assert!((RelativisticMotion.energy(row) / 1.5e-6 - 1.0).abs() < 1e-15);
    }
}
