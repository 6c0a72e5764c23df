//! One mass on a spring whose other end is fixed.

use super::{BODIES, Phase, Problem};
use crate::{Damper, Motion, Spring};
use vesper::prelude::*;

/// A mass on a spring along x, damped or not; row 0 is the fixed end, row 1 the mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// The mass, in kg.
    pub mass: f64,
    /// Stiffness of the spring, in N/m.
    pub stiffness: f64,
    /// Damping along the spring, in N s/m.
    pub damping: f64,
    /// Rest length of the spring, in m; above the displacement, for the ends must not meet.
    pub rest_length: f64,
    /// Displacement at time 0, in m.
    pub displacement: f64,
    /// Speed of the displacement at time 0, in m/s.
    pub speed: f64,
}

impl Default for Oscillator {
    /// Angular frequency 1, no damping, pulled out by 1.
    fn default() -> Self {
        Oscillator { mass: 1.0, stiffness: 1.0, damping: 0.0, rest_length: 4.0, displacement: 1.0, speed: 0.0 }
    }
}

impl Problem for Oscillator {
    fn name(&self) -> String {
        "oscillator".to_owned()
    }

    fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
        let bodies = Domain::new(BODIES)
            .with(Position, [[0.0; 3], [self.rest_length + self.displacement, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3], [self.speed, 0.0, 0.0]])
            .with(Mass, [0.0, self.mass]);
        let springs = Domain::new("springs")
            .link(Ends, BODIES, [[0, 1]])
            .with(Stiffness, [self.stiffness])
            .with(RestLength, [self.rest_length]);
        // Without damping the property is left out, and the damper dormant: it costs leapfrog an evaluation per step.
        let springs = if self.damping == 0.0 { springs } else { springs.with(Damping, [self.damping]) };
        builder.domain(bodies).domain(springs).law(Spring).law(Damper).law(Motion)
    }

    fn exact(&self, time: f64) -> Option<Vec<Phase>> {
        let (square, decay) = (self.stiffness / self.mass, self.damping / (2.0 * self.mass));
        let (out, speed) = damped_oscillation(square, decay, (self.displacement, self.speed), time);
        let fixed = Phase { position: DVec3::ZERO, velocity: DVec3::ZERO };
        let moving = Phase { position: DVec3::X * (self.rest_length + out), velocity: DVec3::X * speed };
        Some(vec![fixed, moving])
    }

    fn times(&self) -> Vec<f64> {
        let period = core::f64::consts::TAU * (self.mass / self.stiffness).sqrt();
        vec![0.25 * period, period, 10.0 * period]
    }
}

/// Solves x'' + 2 decay x' + square x = 0 from (x, x') at time 0: x and x' at `time`. Landau, Lifshitz, Mechanics, par. 25.
pub fn damped_oscillation(square: f64, decay: f64, (x, v): (f64, f64), time: f64) -> (f64, f64) {
    let split = square - decay * decay;
    let fade = (-decay * time).exp();
    // x = x0 C + (v0 + decay x0) S with C = e^(-decay t) cos(omega t), S = e^(-decay t) sin(omega t) / omega: circular,
    // hyperbolic, or at the border. From S' = C - decay S and C' = -split S - decay C follows
    // x' = v0 C - (square x0 + decay v0) S.
    let (c, s) = if split > 0.0 {
        let omega = split.sqrt();
        (fade * (omega * time).cos(), fade * (omega * time).sin() / omega)
    } else if split < 0.0 {
        // The slower exponential alone before the sum: apart, e^(-decay t) is 0 where cosh is infinite. Its rate is
        // kappa - decay without the cancellation.
        let kappa = (-split).sqrt();
        let slow = if decay > 0.0 { (-square / (kappa + decay) * time).exp() } else { ((kappa - decay) * time).exp() };
        let less = (-2.0 * kappa * time).exp_m1();
        (slow * (1.0 + 0.5 * less), -0.5 * slow * less / kappa)
    } else {
        (fade, fade * time)
    };
    (x * c + (v + decay * x) * s, v * c - (square * x + decay * v) * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_solves_its_equation() {
        let start = (0.7, -0.4);
        for (square, decay) in [(4.0, 0.0), (4.0, 0.5), (4.0, 2.0), (4.0, 5.0)] {
            let at = |time| damped_oscillation(square, decay, start, time);
            assert!((at(0.0).0 - start.0).abs() < 1e-15 && (at(0.0).1 - start.1).abs() < 1e-15);
            let h = 1e-4;
            let (x, v) = at(0.8);
            let rate = |f: fn((f64, f64)) -> f64| (f(at(0.8 + h)) - f(at(0.8 - h))) / (2.0 * h);
            assert!((rate(|state| state.0) - v).abs() < 1e-6);
            assert!((rate(|state| state.1) + 2.0 * decay * v + square * x).abs() < 1e-6);
        }
    }

    #[test]
    fn an_overdamped_mass_creeps_back_however_long_it_takes() {
        // Long after the faster exponential, A e^(-slow t) with A = (v + fast x) / (fast - slow).
        let (square, decay) = (1.0_f64, 10.0_f64);
        let fast = decay + (decay * decay - square).sqrt();
        let slow = square / fast;
        for time in [10.0, 100.0, 1000.0] {
            let (x, v) = damped_oscillation(square, decay, (0.7, -0.4), time);
            let exact = (fast * 0.7 - 0.4) / (fast - slow) * (-slow * time).exp();
            assert!((x / exact - 1.0).abs() < 1e-13, "{x} at {time}");
            assert!((v / (-slow * exact) - 1.0).abs() < 1e-11, "{v} at {time}");
        }
        assert_eq!(damped_oscillation(square, decay, (0.7, -0.4), 1e5), (0.0, 0.0));
    }
}
