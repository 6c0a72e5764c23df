//! Two bodies on an ellipse.

use super::{BODIES, Phase, Problem};
use crate::{Gravity, Motion};
use vesper::prelude::*;

/// Two bodies of masses 3/4 and 1/4 with G = 1 on an ellipse of semi-major axis 1 about their centre of mass, so that a
/// revolution takes 2 pi; at time 0 they are nearest to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kepler {
    /// Eccentricity, from 0 (a circle) up to, but not including, 1.
    pub eccentricity: f64,
}

const SHARES: [f64; 2] = [-0.25, 0.75];

impl Kepler {
    /// Row 1 relative to row 0. Murray, Dermott, Solar System Dynamics, eq. 2.41 and 2.52.
    fn relative(&self, time: f64) -> (DVec3, DVec3) {
        let e = self.eccentricity;
        let across = (1.0 - e * e).sqrt();
        let (sine, cosine) = eccentric_anomaly(time, e).sin_cos();
        let rate = 1.0 / (1.0 - e * cosine);
        (DVec3::new(cosine - e, across * sine, 0.0), DVec3::new(-sine * rate, across * cosine * rate, 0.0))
    }
}

/// Solves Kepler's equation E - e sin E = M by Newton's method, from M + e or M - e: the root is between that and M.
fn eccentric_anomaly(mean: f64, e: f64) -> f64 {
    let mean = mean % core::f64::consts::TAU;
    let mut anomaly = if mean.sin() < 0.0 { mean - e } else { mean + e };
    for _ in 0..50 {
        let step = (anomaly - e * anomaly.sin() - mean) / (1.0 - e * anomaly.cos());
        anomaly -= step;
        if step.abs() < 1e-16 * anomaly.abs().max(1.0) {
            break;
        }
    }
    anomaly
}

impl Problem for Kepler {
    fn name(&self) -> String {
        format!("kepler_e{}", self.eccentricity)
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let (apart, moving) = self.relative(0.0);
        let bodies = Domain::new(BODIES)
            .with(Position, SHARES.map(|share| apart * share))
            .with(Velocity, SHARES.map(|share| moving * share))
            .with(Mass, [0.75, 0.25]);
        builder.domain(bodies).law(Gravity { g: 1.0, softening: 0.0 }).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        let (apart, moving) = self.relative(time);
        Some(SHARES.map(|share| Phase { position: apart * share, velocity: moving * share }).to_vec())
    }

    fn times(&self) -> Vec<f64> {
        [0.3, 1.0, 10.0].map(|revolutions| revolutions * core::f64::consts::TAU).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_anomaly_solves_keplers_equation() {
        for e in [0.0, 0.3, 0.9, 0.99] {
            for k in 0..100 {
                let mean = f64::from(k) * 0.0628;
                let anomaly = eccentric_anomaly(mean, e);
                assert!((anomaly - e * anomaly.sin() - mean).abs() < 1e-14, "e = {e}, M = {mean}");
            }
        }
    }

    #[test]
    fn the_ellipse_has_its_energy_everywhere() {
        let orbit = Kepler { eccentricity: 0.6 };
        for time in [0.0, 0.1, 1.0, 3.0, 100.0] {
            let (apart, moving) = orbit.relative(time);
            assert!((0.5 * moving.length_squared() - 1.0 / apart.length() + 0.5).abs() < 1e-13, "at {time}");
        }
    }
}
