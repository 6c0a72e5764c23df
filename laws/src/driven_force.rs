use vesper::prelude::*;

property! {
    /// Amplitude of a force that swings in time.
    pub DrivingAmplitude: Vector, "N";
}

/// A force that swings in time, the same wherever its row is.
///
/// Equation: F = A cos(w t + phi); it has no energy, since it depends on the time.
///
/// Source: Landau, Lifshitz, Mechanics, 3rd ed., eq. 22.3.
///
/// Limits: one frequency and phase for all rows; list it twice, under two labels, for two. The step must resolve w.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(amplitude: DrivingAmplitude), scene(time: Time), adds(force: Force))]
pub struct DrivenForce<R = f64> {
    /// Angular frequency.
    #[law(unit = "rad/s")]
    pub angular_frequency: R,
    /// Phase at time 0.
    #[law(unit = "rad", default = 0.0)]
    pub phase: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for DrivenForce<R> {
    fn row(&self, body: DrivenForceRow<R>) -> R::Vec3 {
        body.amplitude * (self.angular_frequency * body.time + self.phase).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    #[test]
    fn a_free_mass_swings_with_it() {
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3]; 2])
            .with(Velocity, [[0.0; 3]; 2])
            .with(Mass, [2.0, 2.0])
            .subset(DrivingAmplitude, [1], [[0.0, 36.0, 0.0]]);
        let drive = DrivenForce { angular_frequency: 3.0, phase: 0.25 };
        let builder = Engine::<f64>::builder().domain(bodies).law(drive).law(Motion);
        let mut engine = builder.integrator(GaussRadau15::default()).build().unwrap();
        engine.advance(2.0).unwrap();
        // y'' = 18 cos(3 t + p): y = 2 (cos p - cos(3 t + p)) - 6 t sin p.
        let y = 2.0 * (0.25_f64.cos() - 6.25_f64.cos()) - 12.0 * 0.25_f64.sin();
        let place = engine.state().get("bodies", Position, 1).unwrap();
        assert!((place - DVec3::Y * y).length() < 1e-13, "{place} instead of {y}");
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::ZERO, "only the subset is driven");
    }
}
