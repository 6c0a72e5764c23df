//! The longest step at which an explicit integrator is stable, from the laws' own derivatives.
//!
//! In: what a method allows for decay and for oscillation, and the rates at which a state decays and oscillates: eigenvalues of the
//! derivative of all rates at the state as it is. Out: a step. Never: a promise for other states: where stiffness comes later, as
//! with contact, the limit is another one there.
//!
//! The eigenvalues of largest magnitude are those of the derivative in a Krylov space from a vector that favours no direction, in
//! scales of the states that are balanced first: unlike units would hide the fast ones.
//!
//! Sources: Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., SIAM 2011, 6.2 (Arnoldi's method); Osborne, J. ACM 7
//! (1960) 338 (balancing); Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.2 (stability domains).

use super::hessenberg::eigenvalues;
use super::krylov::Arnoldi;
use super::{Register, System};
use crate::law::Part;

/// What a method allows: the longest step times a rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableLimits {
    /// For an oscillation without decay, in rad; 0 where it grows at any step.
    pub oscillation: f64,
    /// For decay without oscillation.
    pub decay: f64,
    /// Whether the rates of momenta are taken at other momenta than those of coordinates, as by methods that kick and drift: an
    /// oscillation that fades has then less room than the limits on both axes say.
    pub kicks: bool,
}

/// How long a step may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// The longest step at which nothing grows but what the laws let grow, in s; 0 where the method lets some oscillation grow at
    /// any step; infinite where nothing decays or oscillates.
    pub step: f64,
    /// The same, but for a method that lets every oscillation grow a little the step from which on it multiplies in each.
    pub usable: f64,
    /// The rate that limits it: decay, in 1/s, and angular frequency, in rad/s.
    pub rate: [f64; 2],
}

/// The part of the largest magnitude that counts as nothing.
const NOTHING: f64 = 1e-4;
/// The part of a rate that rounding makes.
const ROUNDED: f64 = 1e-6;
/// The part by which the step may still change when more vectors of the space say no more; it is looked at so often.
const SETTLED: f64 = 1e-4;
const LOOKS: usize = 5;
/// Rounds of balancing.
const ROUNDS: usize = 20;

impl StableLimits {
    /// The longest step `h` for one rate. For a fading oscillation x'' + 2 a x' + w^2 x = 0 between the limits O and D on the axes:
    /// of methods that evaluate all rates at one state the ellipse (h a / D)^2 + (h w')^2 / O^2 = 1, which is within a tenth; of those
    /// that kick (h w)^2 / O^2 + 2 h a / D = 1, which is exact for semi-implicit Euler, and short for leapfrog, with its predicted
    /// kick. Of two rates of decay that are close to each other each counts by itself, which allows the latter up to 2.4 times too
    /// much. The circle through 0 where an oscillation grows at any step.
    fn step(self, [decay, frequency]: [f64; 2]) -> f64 {
        let StableLimits { oscillation, decay: real, kicks } = self;
        let limit = if oscillation == 0.0 {
            real * decay / (decay * decay + frequency * frequency)
        } else if kicks && frequency > 0.0 {
            // The root above 0 of the quadratic equation, without cancellation.
            let (half, square) = (decay / real, (decay.hypot(frequency) / oscillation).powi(2));
            1.0 / (half + (half * half + square).sqrt())
        } else {
            1.0 / (decay / real).hypot(frequency / oscillation)
        };
        if limit.is_nan() { f64::INFINITY } else { limit }
    }

    /// The longest step for all rates.
    pub(crate) fn longest(self, rates: &[[f64; 2]]) -> StableStep {
        let none = StableStep { step: f64::INFINITY, usable: f64::INFINITY, rate: [0.0; 2] };
        let oscillation = if self.oscillation > 0.0 { self.oscillation } else { self.decay };
        let tolerant = StableLimits { oscillation, ..self };
        rates.iter().fold(none, |least, &rate| {
            let (step, usable) = (self.step(rate), tolerant.step(rate));
            let rate = if usable < least.usable { rate } else { least.rate };
            StableStep { step: step.min(least.step), usable: usable.min(least.usable), rate }
        })
    }
}

/// Vectors of the space: at most, at least, and numbers of all of them together between.
const BASIS: usize = 60;
const LEAST: usize = 12;
const NUMBERS: usize = 1 << 24;

/// How many vectors an estimate takes of so many numbers each.
pub(crate) fn vectors(numbers: usize) -> usize {
    (NUMBERS / numbers.max(1)).clamp(LEAST, BASIS)
}

/// The longest stable step at the state as it is, by so many of the work vectors, and one more.
pub(crate) fn stable_step(system: &mut dyn System, limits: StableLimits, vectors: usize) -> StableStep {
    let scales = balanced(system);
    let weights = scales.iter().map(|scale| 1.0 / (scale * scale)).collect();
    let arnoldi = Arnoldi::new(0, Part::All, weights);
    system.scatter(Register::Work(0), &scales);
    let norm = arnoldi.norm(system, Register::Work(0));
    let mut found = limits.longest(&[]);
    if norm == 0.0 {
        return found;
    }
    arnoldi.begin(system, norm);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for number in 0..vectors {
        system.derivative(Register::Work(number + 1), Register::Work(number));
        columns.push(arnoldi.extend(system, number));
        let whole = columns[number][number + 1] == 0.0;
        if !columns[number].iter().all(|share| share.is_finite()) {
            return found;
        }
        if whole || (number + 1).is_multiple_of(LOOKS) || number + 1 == vectors {
            let before = found.usable;
            found = limits.longest(&rates(&columns));
            if whole || before.is_finite() && (found.usable - before).abs() <= SETTLED * before {
                break;
            }
        }
    }
    found
}

/// Decay and frequency of each eigenvalue; those that grow have no decay.
fn rates(columns: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let sizes = columns.iter().map(|column| column.iter().map(|share| share * share).sum::<f64>().sqrt());
    let largest = sizes.fold(0.0, f64::max);
    let eigenvalues = eigenvalues(columns).into_iter().filter(|[re, im]| re.hypot(*im) > NOTHING * largest);
    let rate = |[re, im]: [f64; 2]| {
        let least = ROUNDED * re.hypot(im);
        [-re, im.abs()].map(|part| if part > least { part } else { 0.0 })
    };
    eigenvalues.map(rate).collect()
}

/// For each state a scale, so that what it does to the others is of the size of what they do to it.
fn balanced(system: &mut dyn System) -> Vec<f64> {
    let [along, change] = [0, 1].map(Register::Work);
    let mut states = 0;
    system.magnitudes(&[change], Part::All, &mut |state, _| states = states.max(state + 1));
    let sizes = |system: &mut dyn System, of: Register| {
        let mut squares = vec![0.0; states];
        system.magnitudes(&[of], Part::All, &mut |state, rows| squares[state] += rows[0] * rows[0]);
        squares.into_iter().map(f64::sqrt).collect::<Vec<f64>>()
    };
    // How large the change of each state is, per change of another one.
    let mut effects: Vec<Vec<f64>> = Vec::new();
    for cause in 0..states {
        let scales: Vec<f64> = (0..states).map(|state| f64::from(u8::from(state == cause))).collect();
        system.scatter(along, &scales);
        system.derivative(change, along);
        let by = sizes(system, along)[cause];
        effects.push(sizes(system, change).into_iter().map(|size| if by > 0.0 { size / by } else { 0.0 }).collect());
    }
    let mut scales = vec![1.0; states];
    for _ in 0..ROUNDS {
        for state in 0..states {
            let others = || (0..states).filter(|other| *other != state);
            let given: f64 = others().map(|other| effects[state][other] * scales[state] / scales[other]).sum();
            let taken: f64 = others().map(|other| effects[other][state] * scales[other] / scales[state]).sum();
            let ratio = (taken / given).sqrt();
            if given > 0.0 && taken > 0.0 && ratio.is_finite() {
                scales[state] *= ratio;
            }
        }
    }
    scales
}
