//! C6, the mass spectrograph: particles that an electric field accelerates and a magnetic one sorts.

use super::{BODIES, Phase, Problem};
use crate::{ElectricForce, MagneticForce, Motion};
use core::f64::consts::PI;
use vesper::prelude::*;

/// Six particles start at rest at (0, -100, 0). An electric field (0, 0.5, 0) fills the box -50 <= x < 50, -100 <= y < 0; a
/// magnetic field (0, 0, 0.02) fills -1000 <= x < 1000, y >= 0. Each particle leaves the box at y = 0, runs half a circle
/// and comes back to y = 0 beyond the box, from where it goes straight on.
///
/// The fields jump at y = 0. Steps end there, since boxes say where they are; one that goes across feels the old field for up
/// to its whole length too long, an error of first order in the step, whatever the integrator's own order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrograph;

/// Where and when a particle comes back to y = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Time, in s.
    pub time: f64,
    /// Distance from the start along x, in m: twice the radius of the half circle.
    pub x: f64,
}

impl Spectrograph {
    /// Masses of the particles, in kg.
    pub const MASSES: [f64; 6] = [0.0002, 0.0002, 0.0002, 0.00041, 0.00024, 0.0003];
    /// Charges of the particles, in C.
    pub const CHARGES: [f64; 6] = [0.02, 0.012, 0.01, 0.02, 0.01, 0.01];
    const ELECTRIC: f64 = 0.5;
    const MAGNETIC: f64 = 0.02;
    const DEPTH: f64 = 100.0;

    /// Acceleration in the box, speed on leaving it, angular velocity and radius of the half circle.
    fn motion(row: usize) -> [f64; 4] {
        let per_mass = Self::CHARGES[row] / Self::MASSES[row];
        let acceleration = per_mass * Self::ELECTRIC;
        let speed = (2.0 * acceleration * Self::DEPTH).sqrt();
        let omega = per_mass * Self::MAGNETIC;
        [acceleration, speed, omega, speed / omega]
    }

    /// The six landings: v = sqrt(2 q E d / m), r = m v / (q B).
    pub fn landings(&self) -> [Landing; 6] {
        core::array::from_fn(|row| {
            let [acceleration, speed, omega, radius] = Self::motion(row);
            Landing { time: speed / acceleration + PI / omega, x: 2.0 * radius }
        })
    }
}

impl Problem for Spectrograph {
    fn name(&self) -> String {
        "mass_spectrograph".to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let everywhere = f64::INFINITY;
        let electric = FieldBox {
            min: [-50.0, -Self::DEPTH, -everywhere],
            max: [50.0, 0.0, everywhere],
            value: [0.0, Self::ELECTRIC, 0.0],
        };
        let magnetic = FieldBox {
            min: [-1000.0, 0.0, -everywhere],
            max: [1000.0, everywhere, everywhere],
            value: [0.0, 0.0, Self::MAGNETIC],
        };
        let bodies = Domain::new(BODIES)
            .with(Position, [[0.0, -Self::DEPTH, 0.0]; 6])
            .with(Velocity, [[0.0; 3]; 6])
            .with(Mass, Self::MASSES)
            .with(Charge, Self::CHARGES);
        builder
            .domain(bodies)
            .field(ElectricField, Boxes { boxes: vec![electric] })
            .field(MagneticField, Boxes { boxes: vec![magnetic] })
            .law(ElectricForce)
            .law(MagneticForce)
            .law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        let at = |row: usize| {
            let [acceleration, speed, omega, radius] = Self::motion(row);
            let (in_box, in_field) = (speed / acceleration, PI / omega);
            if time < in_box {
                let y = 0.5 * acceleration * time * time - Self::DEPTH;
                return Phase { position: DVec3::new(0.0, y, 0.0), velocity: DVec3::Y * (acceleration * time) };
            }
            let since = time - in_box;
            if since < in_field {
                let (sine, cosine) = (omega * since).sin_cos();
                let position = DVec3::new(radius * (1.0 - cosine), radius * sine, 0.0);
                return Phase { position, velocity: DVec3::new(speed * sine, speed * cosine, 0.0) };
            }
            let y = -speed * (since - in_field);
            Phase { position: DVec3::new(2.0 * radius, y, 0.0), velocity: DVec3::NEG_Y * speed }
        };
        Some((0..6).map(at).collect())
    }

    fn times(&self) -> Vec<f64> {
        vec![1.5, 3.0, 5.0, 6.5, 9.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_and_times_are_those_of_the_study() {
        let radii = [50.000, 64.550, 70.711, 71.589, 77.460, 86.603];
        #[allow(clippy::approx_constant, reason = "the third one is pi, rounded like the others")]
        let half_turns = [1.571, 2.618, 3.142, 3.220, 3.770, 4.712];
        for (row, landing) in Spectrograph.landings().into_iter().enumerate() {
            let [acceleration, speed, ..] = Spectrograph::motion(row);
            assert!((landing.x / 2.0 - radii[row]).abs() < 5e-4, "{landing:?}");
            assert!((landing.time - speed / acceleration - half_turns[row]).abs() < 5e-4, "{landing:?}");
            let place = Spectrograph.exact(landing.time).unwrap()[row].position;
            assert!((place - DVec3::X * landing.x).length() < 1e-12, "{place}");
        }
    }
}
