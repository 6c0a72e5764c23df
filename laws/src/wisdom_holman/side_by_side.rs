//! Kepler steps of several rows side by side, one in each lane, where steps are short.
//!
//! In: places, velocities and parameters in arrays, a time. Out: places and velocities after it, with what their rounding
//! lost. Never: a long step; a row that goes on by more than a sixth of a revolution is left to [`super::kepler_step()`].
//!
//! The same equation as there; the first guess is the series of X in the time, and each try is one of Danby's, of order 4.

use super::kepler_step::kepler_step;
use super::orbits::{LANES, Numbers, Orbits};
use vesper::prelude::*;
use vesper::real::{Lanes, WithLanes};

/// Rows go on by this time, in s.
pub(super) struct Drift<'a> {
    pub(super) orbits: &'a mut Orbits,
    pub(super) time: f64,
}

/// Tries, after which a row is left to the slow way.
const TRIES: usize = 4;
/// Changes of X, by X, after which no further try is needed: what is left is of fourth order in them, with a small factor.
const CLOSE: f64 = 2e-4;
/// The largest beta X^2 at which nine terms of the series do.
const SHORT: f64 = 1.5;

/// Factors of the series, from the last term on: -1 / ((n + 1) (n + 2)) for c2, and -1 / ((n + 2) (n + 3)) for c3.
const SECOND: [f64; 8] = factors(1);
const THIRD: [f64; 8] = factors(2);

const fn factors(from: u32) -> [f64; 8] {
    let mut factors = [0.0; 8];
    let mut k = 0;
    while k < 8 {
        let n = 2 * (8 - k as u32) + from;
        factors[k] = -1.0 / (n * (n + 1)) as f64;
        k += 1;
    }
    factors
}

/// G0 to G3 by the series.
#[inline(always)]
fn stumpff<R: Real>(z: R, beta: R, x: R) -> [R; 4] {
    let one = R::lit(1.0);
    let (mut c2, mut c3) = (one, one);
    for k in 0..8 {
        c2 = one + z * R::lit(SECOND[k]) * c2;
        c3 = one + z * R::lit(THIRD[k]) * c3;
    }
    let square = x * x;
    let g2 = R::lit(0.5) * square * c2;
    let g3 = R::lit(1.0 / 6.0) * square * x * c3;
    [one - beta * g2, x - beta * g3, g2, g3]
}

/// Adds with the rounding error of the last addition (Kahan).
#[inline(always)]
fn add<R: Lanes<f64>>(to: &mut [f64], errors: &mut [f64], change: R) {
    let before = R::from_lanes(|lane| to[lane]);
    let sum = change - R::from_lanes(|lane| errors[lane]);
    let after = before + sum;
    let lost = (after - before) - sum;
    for lane in 0..R::WIDTH {
        to[lane] = after.lane(lane);
        errors[lane] = lost.lane(lane);
    }
}

/// Reads neighbouring numbers.
#[inline(always)]
fn load<R: Lanes<f64>>(numbers: &[f64], at: usize) -> R {
    let numbers = &numbers[at..at + R::WIDTH];
    R::from_lanes(|lane| numbers[lane])
}

#[inline(always)]
fn vector<R: Lanes<f64>>([x, y, z]: &[Vec<f64>; 3], at: usize) -> R::Vec3 {
    R::Vec3::new(load(x, at), load(y, at), load(z, at))
}

/// Whether every lane is 1.
#[inline(always)]
fn are_all_one<R: Lanes<f64>>(lanes: R) -> bool {
    let mut all = true;
    for lane in 0..R::WIDTH {
        all &= lanes.lane(lane) == 1.0;
    }
    all
}

/// One row by the slow way: its changes.
#[inline(never)]
fn alone(orbits: &Orbits, row: usize, time: f64) -> [f64; 6] {
    let of = |numbers: &Numbers| DVec3::from_array([0, 1, 2].map(|k| numbers.sums[k][row]));
    let step = kepler_step(orbits.parameters[row], of(&orbits.position), of(&orbits.velocity), time);
    let ([x, y, z], [u, v, w]) = (step.position.to_array(), step.velocity.to_array());
    [x, y, z, u, v, w]
}

impl WithLanes<f64> for Drift<'_> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<f64>>(self) {
        let Drift { orbits, time } = self;
        let t = R::lit(time);
        let mut at = 0;
        while at < orbits.rows {
            let position = vector::<R>(&orbits.position.sums, at);
            let velocity = vector::<R>(&orbits.velocity.sums, at);
            let mu = load::<R>(&orbits.parameters, at);
            let start = position.length();
            let inverse = R::lit(1.0) / start;
            let beta = R::lit(2.0) * mu * inverse - velocity.length_squared();
            let eta = position.dot(velocity);
            let zeta = mu - beta * start;
            // X = u - a u^2 + (2 a^2 - b) u^3.
            let u = t * inverse;
            let a = R::lit(0.5) * eta * inverse;
            let b = R::lit(1.0 / 6.0) * zeta * inverse;
            let mut x = u * (R::lit(1.0) - u * (a - u * (R::lit(2.0) * a * a - b)));
            let mut g;
            let mut distance;
            let mut all;
            let mut tries = 0;
            loop {
                let z = beta * x * x;
                g = stumpff(z, beta, x);
                let excess = start * x + eta * g[2] + zeta * g[3] - t;
                distance = start + eta * g[1] + zeta * g[2];
                let bend = R::lit(0.5) * (eta * g[0] + zeta * g[1]);
                let twist = R::lit(1.0 / 6.0) * (zeta * g[0] - eta * beta * g[1]);
                let mut step = -excess / distance;
                step = -excess / (distance + step * bend);
                step = -excess / (distance + step * (bend + step * twist));
                let near = step.abs().less_or_equal(R::lit(CLOSE) * x.abs());
                let good = R::select(near & z.abs().less(R::lit(SHORT)), R::lit(1.0), R::lit(0.0));
                tries += 1;
                all = are_all_one(good);
                if all || tries == TRIES {
                    // The functions there, from their derivatives here.
                    let (half, third) = (R::lit(0.5) * step, R::lit(1.0 / 3.0) * step);
                    let [g0, g1, g2, g3] = g;
                    let bent = g0 - third * beta * g1;
                    g = [
                        g0 - step * beta * (g1 + half * bent),
                        g1 + step * (g0 - half * beta * (g1 + third * g0)),
                        g2 + step * (g1 + half * bent),
                        g3 + step * (g2 + half * (g1 + third * g0)),
                    ];
                    distance = start + eta * g[1] + zeta * g[2];
                    break;
                }
                x += step;
            }
            let pull = mu * inverse;
            let (f, by_velocity) = (-pull * g[2], t - mu * g[3]);
            let farther = R::lit(1.0) / distance;
            let (f_rate, rate) = (-pull * g[1] * farther, -mu * g[2] * farther);
            let mut moved = position * f + velocity * by_velocity;
            let mut turned = position * f_rate + velocity * rate;
            if !all {
                let mut exact = [[0.0; LANES]; 6];
                for lane in 0..R::WIDTH.min(orbits.rows - at) {
                    for (number, change) in exact.iter_mut().zip(alone(orbits, at + lane, time)) {
                        number[lane] = change;
                    }
                }
                let [x, y, z, u, v, w] = &exact;
                moved = R::Vec3::new(load(x, 0), load(y, 0), load(z, 0));
                turned = R::Vec3::new(load(u, 0), load(v, 0), load(w, 0));
            }
            let range = at..at + R::WIDTH;
            let each = [(&mut orbits.position, moved), (&mut orbits.velocity, turned)];
            for (numbers, change) in each {
                let Numbers { sums: [x, y, z], errors: [ex, ey, ez] } = numbers;
                add(&mut x[range.clone()], &mut ex[range.clone()], change.x());
                add(&mut y[range.clone()], &mut ey[range.clone()], change.y());
                add(&mut z[range.clone()], &mut ez[range.clone()], change.z());
            }
            at += R::WIDTH;
        }
    }
}
