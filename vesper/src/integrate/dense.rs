//! The state within a step: dense output, for frames that are shorter than the steps which the tolerance allows.
//!
//! In: a place in the step, the weights of its rates. Out: the weights of the rates at that place. Never: a state.
//!
//! y(t + s h) = y + s (F0 + (1 - s) (F1 + s (F2 + (1 - s) (F3 + s (F4 + ..))))), with F0 the change in the step, F1 and F2 such
//! that the rates at both ends are right, and further terms by a table (Hairer, Norsett, Wanner, Solving Ordinary Differential
//! Equations I, 2nd ed. (1993), II.6, eq. 6.13 to 6.15 and their codes dopri5 and dop853).

use super::embedded::STAGES;

/// What a method needs besides its stages.
pub(super) struct Dense {
    /// Stages behind the rates at the end of the step: when, and how far along the rates of those before.
    pub(super) further: &'static [(f64, &'static [f64])],
    /// The weights of all rates in F3 and on.
    pub(super) terms: &'static [&'static [f64]],
}

/// A step that goes beyond the end of the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    /// The time at its beginning, in s.
    pub(super) begin: f64,
    /// Its length, in s.
    pub(super) step: f64,
    /// Whether the further stages are known.
    pub(super) ready: bool,
}

impl Ahead {
    pub(super) fn end(&self) -> f64 {
        self.begin + self.step
    }
}

impl Dense {
    /// The weights of the rates at this share of a step that has these weights at its end; `last` is the number of the rates
    /// there.
    pub(super) fn weights(&self, share: f64, whole: &[f64], last: usize) -> [f64; STAGES] {
        let rest = 1.0 - share;
        core::array::from_fn(|stage| {
            let weight = whole.get(stage).copied().unwrap_or(0.0);
            let [first, end] = [stage == 0, stage == last].map(|is| f64::from(u8::from(is)));
            let further = self.terms.iter().enumerate().rev().fold(0.0, |sum, (number, term)| {
                term.get(stage).copied().unwrap_or(0.0) + sum * if number % 2 == 0 { share } else { rest }
            });
            let bent = 2.0 * weight - end - first + rest * further;
            share * (weight + rest * (first - weight + share * bent))
        })
    }
}
