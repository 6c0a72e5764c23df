//! A row on its way about a centre: Kepler's problem, solved for any orbit and any time.
//!
//! In: a gravitational parameter, a place and a velocity relative to the centre, a time. Out: by how much both change. Never:
//! a loop that may not end, or an orbit that it refuses.
//!
//! Universal variables: with beta = 2 mu / r0 - v0^2, eta = x0 . v0, zeta = mu - beta r0 and the functions G_n(X) = X^n
//! c_n(beta X^2) of Stumpff, the time is t = r0 X + eta G2 + zeta G3, and dt/dX = r = r0 + eta G1 + zeta G2 is never
//! negative, so that there is one X, and an interval about it can be halved where the steps of Laguerre and Conway leave it.
//!
//! Sources: Stumpff, Himmelsmechanik I (1959), chapter V; Danby, Fundamentals of Celestial Mechanics, 2nd ed. (1988), 6.9; Conway,
//! Celest. Mech. 39 (1986) 199; Rein, Tamayo, MNRAS 452 (2015) 376, for the changes as differences.

use core::f64::consts::TAU;
use vesper::prelude::*;

/// Changes of place and velocity in a time, relative to a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeplerStep {
    /// Of the place, in m.
    pub position: DVec3,
    /// Of the velocity, in m/s.
    pub velocity: DVec3,
}

/// Tries after which the interval is halved: the fast steps do not lead there.
const FAST: u32 = 24;
/// Tries that halve any interval to nothing.
const MOST: u32 = 200;
/// Up to this magnitude of beta X^2 the functions are series.
const SERIES: f64 = 4.0;

/// By how much place and velocity change in `time`, in s, which may be negative, about a centre of this gravitational
/// parameter, in m^3/s^2: exact but for rounding, on ellipses, parabolas and hyperbolas.
///
/// A place at the centre has no orbit: the changes are then NaN. A parameter of 0 has a straight line.
pub fn kepler_step(parameter: f64, position: DVec3, velocity: DVec3, time: f64) -> KeplerStep {
    if parameter == 0.0 || time == 0.0 {
        return KeplerStep { position: velocity * time, velocity: DVec3::ZERO };
    }
    let start = position.length();
    let orbit = Orbit {
        start,
        beta: 2.0 * parameter / start - velocity.length_squared(),
        eta: position.dot(velocity),
        zeta: parameter - start * (2.0 * parameter / start - velocity.length_squared()),
    };
    let time = orbit.within_a_revolution(parameter, time);
    let g = orbit.solve(parameter, time);
    let distance = orbit.distance(&g);
    let along = parameter * g[3];
    // Where the step is short, the time is exact and the rest small; where it is long, a difference of large numbers.
    let by_velocity = if along.abs() < 0.5 * time.abs() { time - along } else { start * g[1] + orbit.eta * g[2] };
    KeplerStep {
        position: position * (-parameter * g[2] / start) + velocity * by_velocity,
        velocity: position * (-parameter * g[1] / (start * distance)) + velocity * (-parameter * g[2] / distance),
    }
}

/// What the time depends on, besides X.
#[derive(Clone, Copy, Debug)]
struct Orbit {
    /// The distance at the beginning.
    start: f64,
    beta: f64,
    eta: f64,
    zeta: f64,
}

impl Orbit {
    /// The time without whole revolutions.
    fn within_a_revolution(&self, parameter: f64, time: f64) -> f64 {
        if self.beta <= 0.0 {
            return time;
        }
        let period = TAU * parameter / (self.beta * self.beta.sqrt());
        let revolutions = (time / period).round();
        if revolutions == 0.0 || !revolutions.is_finite() { time } else { (-revolutions).mul_add(period, time) }
    }

    fn distance(&self, g: &[f64; 4]) -> f64 {
        self.start + self.eta * g[1] + self.zeta * g[2]
    }

    /// The functions at the X that belongs to the time.
    fn solve(&self, parameter: f64, time: f64) -> [f64; 4] {
        let excess = |x: f64, g: &[f64; 4]| self.start * x + self.eta * g[2] + self.zeta * g[3] - time;
        // The sign of X is that of the time; an ellipse is round after 2 pi.
        let mut guess = if self.beta > 0.0 { time * self.beta / parameter } else { time / self.start };
        let mut outer = if self.beta > 0.0 { (TAU / self.beta.sqrt()).copysign(time) } else { guess };
        if self.beta <= 0.0 {
            // Far out X grows like the logarithm of the time, so that the first guess may be beyond all numbers.
            let most = 300.0 / (-self.beta).sqrt();
            outer = if outer.abs() < most { outer } else { most.copysign(time) };
            for _ in 0..MOST {
                if excess(outer, &stumpff(self.beta, outer)) * time.signum() >= 0.0 {
                    break;
                }
                outer *= 2.0;
            }
            // Along a parabola through its pericentre the time is zeta X^3 / 6.
            let cube = (6.0 * time / self.zeta).cbrt();
            guess = if self.zeta > 0.0 && cube.abs() < guess.abs() { cube } else { guess };
        }
        let (mut low, mut high) = if time > 0.0 { (0.0, outer) } else { (outer, 0.0) };
        let mut x = if guess > low && guess < high { guess } else { 0.5 * (low + high) };
        let mut g = stumpff(self.beta, x);
        for tries in 0..MOST {
            let value = excess(x, &g);
            if value > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let slope = self.distance(&g);
            let bend = self.eta * g[0] + self.zeta * g[1];
            // Laguerre's step for a polynomial of degree 5, as Conway takes it.
            let root = (16.0 * slope * slope - 20.0 * value * bend).abs().sqrt();
            let step = -5.0 * value / (slope + root);
            let mut next = x + step;
            if step.abs() <= f64::EPSILON * x.abs() {
                // Within rounding: the last small change is in the functions at once.
                return shifted(self.beta, &g, step);
            }
            if !(next > low && next < high) || tries > FAST {
                next = 0.5 * (low + high);
                if next <= low || next >= high || next.is_nan() {
                    break;
                }
            }
            let change = next - x;
            // So near that the functions follow from their derivatives, without the roundings of new ones.
            if change.abs() < 1e-5 * x.abs() && change == step {
                let near = shifted(self.beta, &g, change);
                let last = -excess(next, &near) / self.distance(&near);
                return shifted(self.beta, &near, last);
            }
            x = next;
            g = stumpff(self.beta, x);
        }
        g
    }
}

/// The functions a little further on: G0' = -beta G1, and each other's derivative is the one before.
fn shifted(beta: f64, g: &[f64; 4], by: f64) -> [f64; 4] {
    let [g0, g1, g2, g3] = *g;
    let (half, third) = (0.5 * by, by / 3.0);
    [
        g0 - by * beta * (g1 + half * (g0 - third * beta * g1)),
        g1 + by * (g0 - half * beta * (g1 + third * g0)),
        g2 + by * (g1 + half * (g0 - third * beta * g1)),
        g3 + by * (g2 + half * (g1 + third * g0)),
    ]
}

/// G0 to G3 at X.
fn stumpff(beta: f64, x: f64) -> [f64; 4] {
    let z = beta * x * x;
    if z.abs() < SERIES {
        // c2 and c3, from the last term that counts.
        let (mut c2, mut c3) = (1.0, 1.0);
        for k in (1..14).rev() {
            let n = f64::from(2 * k);
            c2 = 1.0 - z * c2 / ((n + 1.0) * (n + 2.0));
            c3 = 1.0 - z * c3 / ((n + 2.0) * (n + 3.0));
        }
        let (g2, g3) = (0.5 * x * x * c2, x * x * x * c3 / 6.0);
        return [1.0 - beta * g2, x - beta * g3, g2, g3];
    }
    let root = beta.abs().sqrt();
    let angle = root * x;
    if beta > 0.0 {
        let (half, whole) = ((0.5 * angle).sin(), angle.sin_cos());
        let g1 = whole.0 / root;
        [whole.1, g1, 2.0 * half * half / beta, (x - g1) / beta]
    } else {
        let half = (0.5 * angle).sinh();
        let g1 = angle.sinh() / root;
        [angle.cosh(), g1, -2.0 * half * half / beta, (x - g1) / beta]
    }
}
