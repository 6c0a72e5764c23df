//! Steps that are chosen by their errors: tolerances, and how the next step follows from the last error.

use super::{Register, System};
use crate::error::Fault;
use crate::law::Part;

/// What error a step may have.
///
/// The error of a row counts as a vector, against `absolute + relative * max(|y|, |h y'|)`, of the larger y of both ends
/// of the step: no component is held to a tolerance because it passes through zero, and rows of any magnitude get
/// their own (Press et al., Numerical Recipes, 3rd ed., eq. 17.2.10). The largest ratio of all rows decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The part of a row's magnitude that the error of a step may be.
    pub relative: f64,
    /// What is added to it, in the unit of each state.
    pub absolute: f64,
}

impl Tolerance {
    /// This part of each row's magnitude.
    pub const fn relative(relative: f64) -> Self {
        Tolerance { relative, absolute: 0.0 }
    }

    /// Whether the rounding errors of a state of this precision are more than a millionth of it: then it is worth to keep them.
    pub(super) fn comes_near(&self, epsilon: f64) -> bool {
        self.relative < 1e6 * epsilon
    }

    /// The largest ratio of an error to what is allowed; infinite where a number is none. `magnitude` makes one number of
    /// the errors.
    pub(super) fn excess<const N: usize>(
        &self,
        system: &mut dyn System,
        errors: [Register; N],
        magnitude: fn([f64; N]) -> f64,
        (start, slope, step): (Register, Register, f64),
    ) -> f64 {
        let relative = self.relative.max(4.0 * system.epsilon());
        let absolute = self.absolute;
        let mut vectors = [Register::State; 8];
        vectors[..N].copy_from_slice(&errors);
        vectors[N..N + 3].copy_from_slice(&[Register::State, start, slope]);
        let mut worst = 0.0;
        system.magnitudes(&vectors[..N + 3], Part::All, &mut |_, row| {
            let error = magnitude(core::array::from_fn(|k| row[k]));
            let allowed = absolute + relative * row[N].max(row[N + 1]).max(step * row[N + 2]);
            let ratio = if error == 0.0 { 0.0 } else { error / allowed };
            worst = if ratio.is_finite() { f64::max(worst, ratio) } else { f64::INFINITY };
        });
        worst
    }
}

/// The steps within a span.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// The step to try next, in s, where one is known.
    pub(super) next: Option<f64>,
    /// What the client gave to begin with.
    pub(super) first: Option<f64>,
    /// The ratio of the last accepted step's error to what was allowed.
    last: f64,
    /// The length of that step, in s; zero where there is none.
    before: f64,
}

impl Default for Steps {
    fn default() -> Self {
        Steps { next: None, first: None, last: 1e-4, before: 0.0 }
    }
}

/// A span that is covered by steps. Their sum is compensated (Kahan), so that the last one ends the span, and not a time
/// that is off by the roundings of thousands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    begin: f64,
    length: f64,
    done: f64,
    error: f64,
    /// Steps tried, and how far they had come when a round of them was last full.
    tried: u64,
    mark: f64,
}

/// Steps after which the pace is looked at.
const ROUND: u64 = 10_000;
/// Steps that nobody waits for: at a pace of more in a span the integrator gives up.
const MOST_STEPS: f64 = 1e9;

impl Span {
    /// From the system's time on.
    pub(super) fn new(system: &dyn System, length: f64) -> Self {
        Span { begin: system.time(), length, done: 0.0, error: 0.0, tried: 0, mark: 0.0 }
    }

    /// Whether nothing of it is covered yet.
    pub(super) fn is_untouched(&self) -> bool {
        self.done == 0.0
    }

    /// What is left, in s.
    pub(super) fn rest(&self) -> f64 {
        (self.length - self.done) + self.error
    }

    /// Cuts the next step: its length, and whether it is the last one. Refuses one that the time cannot tell from none,
    /// and a pace at which the span would take years: a law that jumps to and fro asks for steps of no length.
    pub(super) fn cut(&mut self, system: &dyn System, name: &str, next: f64) -> Result<(f64, bool), Fault> {
        if system.is_stopped() {
            return Err(Fault::Stopped { integrator: name.to_owned(), time: self.begin + self.done });
        }
        let (step, last) = Steps::cut(next, self.rest());
        let time = self.begin + self.done;
        if !(step > 0.0 && time + step > time) {
            return Err(Fault::StepTooShort { integrator: name.to_owned(), time, step });
        }
        self.tried += 1;
        if self.tried.is_multiple_of(ROUND) {
            if (self.done - self.mark) * MOST_STEPS < self.length * ROUND as f64 {
                let integrator = name.to_owned();
                return Err(Fault::TooManyTries { integrator, time, step, span: self.length, most: MOST_STEPS });
            }
            self.mark = self.done;
        }
        Ok((step, last))
    }

    /// A step of this length, which is known to be one that can be taken: its length, and whether it is the last one.
    pub(super) fn part(&self, step: f64) -> (f64, bool) {
        (step, step >= self.rest())
    }

    /// A step is done. The time.
    pub(super) fn add(&mut self, step: f64, last: bool) -> f64 {
        if last {
            (self.done, self.error) = (self.length, 0.0);
        } else {
            let step = step - self.error;
            let done = self.done + step;
            self.error = (done - self.done) - step;
            self.done = done;
        }
        self.begin + self.done
    }
}

/// What a controller makes of an error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    /// The order by which the error estimate shrinks with the step, and one more.
    pub(super) order: i32,
    /// The share of the last error (Hairer, Norsett, Wanner, II.4: 0.04 for order 5, 0 for order 8).
    pub(super) beta: f64,
    /// The factors by which a step may shrink and grow.
    pub(super) limits: [f64; 2],
    /// Whether the change from the last step to this one is taken to go on, where that asks for a shorter one (Hairer, Wanner,
    /// Solving Ordinary Differential Equations II, 2nd ed. (1996), eq. IV.8.25): steps that have to shrink time and again, as on
    /// the way to a close encounter, are then not tried in vain.
    pub(super) foresees: bool,
}

impl Steps {
    /// Cuts the rest of a span: the step, and whether it is the last one. Two steps of like length end a span, not a long
    /// and a tiny one.
    pub(super) fn cut(next: f64, rest: f64) -> (f64, bool) {
        if next >= rest * (1.0 - 1e-12) {
            (rest, true)
        } else if 2.0 * next > rest {
            (0.5 * rest, false)
        } else {
            (next, false)
        }
    }

    /// The first step: what was given, or a share of the time in which a row's rate would change it by itself, smaller for
    /// a tighter tolerance. `rates` are those of the state.
    pub(super) fn begin(
        &mut self,
        system: &mut dyn System,
        rates: Register,
        (order, relative): (i32, f64),
        span: f64,
    ) -> f64 {
        if let Some(step) = self.next.or(self.first) {
            return step;
        }
        let mut shortest = f64::INFINITY;
        system.magnitudes(&[Register::State, rates], Part::All, &mut |_, row| {
            if row[0] > 0.0 && row[1] > 0.0 {
                shortest = shortest.min(row[0] / row[1]);
            }
        });
        let step = 0.5 * shortest * relative.max(1e-16).powf(1.0 / f64::from(order));
        if step.is_finite() && step > 0.0 { step.min(span) } else { 1e-3 * span }
    }

    /// Takes note of an error, as a ratio to what is allowed. Whether the step stands; the next one is known afterwards.
    ///
    /// Proportional-integral control (Gustafsson, ACM TOMS 17 (1991) 533; Hairer, Wanner, Solving Ordinary Differential
    /// Equations II, IV.2).
    pub(super) fn judge(&mut self, control: &Control, step: f64, error: f64) -> bool {
        let [shrink, grow] = control.limits;
        let order = f64::from(control.order);
        let safe = 0.9;
        if error <= 1.0 {
            let exponent = 1.0 / order - 0.75 * control.beta;
            let mut factor = safe * error.max(1e-16).powf(-exponent) * self.last.powf(control.beta);
            if control.foresees && self.before > 0.0 {
                let error = error.max(1e-4);
                factor = factor.min(safe * step / self.before * (self.last / (error * error)).powf(1.0 / order));
            }
            (self.last, self.before) = (error.max(1e-4), step);
            self.next = Some(step * factor.clamp(shrink, grow));
            return true;
        }
        let factor = if error.is_finite() { safe * error.powf(-1.0 / order) } else { shrink };
        self.next = Some(step * factor.clamp(shrink, 1.0));
        false
    }

    pub(super) fn restart(&mut self) {
        *self = Steps { first: self.first, ..Steps::default() };
    }

    pub(super) fn memory(&self) -> [f64; 3] {
        [self.next.unwrap_or(0.0), self.last, self.before]
    }

    pub(super) fn set_memory(&mut self, memory: &[f64]) {
        if let &[next, last, before] = memory {
            (self.next, self.last, self.before) = ((next > 0.0).then_some(next), last, before);
        }
    }
}
