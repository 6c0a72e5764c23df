//! Steps of explicit methods with an embedded error: as long as the tolerance allows, ended where a law jumps.
//!
//! In: a scheme, which tries a step of a given length and says what error it has. Out: a span that is covered. Never: a table.
//!
//! A frame that is shorter than half of the step which the tolerance allows does not cut it where the scheme has a dense
//! output: the step is taken whole, frames within it get that output, and the next step goes on from its end. Longer frames
//! end with a step.

use super::adaptive::{Control, Span, Steps};
use super::dense::Ahead;
use super::jump::{Found, Jump};
use super::{Register, System, Terms, Tolerance};
use crate::error::Fault;
use crate::law::Part;

/// The state at the beginning of the step.
pub(super) const START: Register = Register::Work(0);

/// The rates of a stage.
pub(super) const fn slope(stage: usize) -> Register {
    Register::Work(1 + stage)
}

/// The most stages of a table.
pub(super) const STAGES: usize = 17;
/// Steps that are so many times as long as the frame go beyond its end.
const BEYOND: f64 = 2.0;

/// A method of two orders, whose difference is an error.
pub(super) trait Scheme {
    /// Its name in scenes.
    fn name(&self) -> &'static str;
    /// What becomes of an error.
    fn control(&self) -> &Control;
    /// The last stage's rates, where it is at the end of the step, so that it is the first one of the next.
    fn last_slope(&self) -> Option<Register>;
    /// Where the end of a step that goes beyond the frame is kept; none without a dense output.
    fn end(&self) -> Option<Register>;
    /// From the start, and the rates there, leaves the rates of all stages in the slopes, and the state at the end of the step
    /// as a trial.
    fn try_step(&self, system: &mut dyn System, time: f64, step: f64);
    /// The error of the step that was just tried, as a part of what the tolerance allows.
    fn excess(&self, system: &mut dyn System, tolerance: &Tolerance, step: f64) -> f64;
    /// Takes the state from the start to the end of the step that was just tried.
    fn take(&self, system: &mut dyn System, step: f64);
}

/// What such a method remembers from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    pub(super) steps: Steps,
    /// Whether the rates of the state are in the first slope.
    holds_first: bool,
    /// The step that the frame is in, where it ends behind it.
    pub(super) ahead: Option<Ahead>,
}

impl Progress {
    /// Covers a span by steps within the tolerance.
    pub(super) fn cover(
        &mut self,
        (scheme, tolerance): (&impl Scheme, &Tolerance),
        system: &mut dyn System,
        length: f64,
    ) -> Result<(), Fault> {
        let end = system.time() + length;
        let mut length = length;
        if let Some(ahead) = self.ahead {
            if end <= ahead.end() {
                system.set_time(end);
                return Ok(());
            }
            length = end - ahead.end();
            self.go_on(scheme, system, ahead);
        }
        let control = scheme.control();
        let mut span = Span::new(system, length);
        let holds = system.hold();
        let (mut jump, mut closer) = (Jump::default(), None);
        while span.rest() > 0.0 {
            if !self.holds_first {
                system.evaluate_to(slope(0), Part::All);
                self.holds_first = true;
            }
            let next = self.steps.begin(system, slope(0), (control.order, tolerance.relative), length);
            let beyond = scheme.end().is_some() && !holds && span.is_untouched() && next >= BEYOND * span.rest();
            let (step, last) = match closer.take() {
                Some(step) => span.part(step),
                None if beyond => (next, true),
                None => span.cut(system, scheme.name(), next)?,
            };
            system.copy(START, Register::State, Part::All);
            let time = system.time();
            scheme.try_step(system, time, step);
            // Where a jump is near, a longer step was good enough already.
            let accepted = jump.is_near() || {
                let error = scheme.excess(system, tolerance, step);
                self.steps.judge(control, step, error)
            };
            let mut landed = false;
            if accepted && holds {
                system.set_time(time + step);
                match jump.look(system, step) {
                    Found::Nothing => {}
                    Found::Closer(length) => closer = Some(length),
                    Found::Here => landed = true,
                }
            }
            let accepted = accepted && closer.is_none();
            system.count_step(accepted);
            system.copy(Register::State, START, Part::All);
            if !accepted {
                system.set_time(time);
                continue;
            }
            scheme.take(system, step);
            if let (Some(to), true) = (scheme.end(), beyond) {
                system.copy(to, Register::State, Part::All);
                self.ahead = Some(Ahead { begin: time, step, ready: false });
                system.set_time(end);
                return Ok(());
            }
            self.holds_first = false;
            if let (Some(last), false) = (scheme.last_slope(), landed) {
                system.copy(slope(0), last, Part::All);
                self.holds_first = true;
            }
            // A step cut short to end the span says little about the next one.
            if last && step < 0.9 * next {
                self.steps.next = self.steps.next.map(|known| known.max(next));
            }
            system.set_time(span.add(step, last));
            if landed {
                system.turn();
                jump = Jump::default();
            } else if holds {
                system.hold();
            }
        }
        Ok(())
    }

    /// Puts the state at the end of the step that the last frame was in.
    fn go_on(&mut self, scheme: &impl Scheme, system: &mut dyn System, ahead: Ahead) {
        self.ahead = None;
        if let Some(end) = scheme.end() {
            system.copy(Register::State, end, Part::All);
        }
        system.set_time(ahead.end());
        self.holds_first = false;
        if let Some(last) = scheme.last_slope() {
            system.copy(slope(0), last, Part::All);
            self.holds_first = true;
        }
    }

    pub(super) fn restart(&mut self) {
        self.steps.restart();
        (self.holds_first, self.ahead) = (false, None);
    }

    pub(super) fn memory(&self) -> Vec<f64> {
        let [next, last, before] = self.steps.memory();
        let ahead = self.ahead.map(|ahead| [ahead.begin, ahead.step, f64::from(u8::from(ahead.ready))]);
        [&[next, last, before, f64::from(u8::from(self.holds_first))][..], ahead.as_slice().as_flattened()].concat()
    }

    pub(super) fn set_memory(&mut self, memory: &[f64]) {
        self.restart();
        if let [next, last, before, holds, ahead @ ..] = memory {
            self.steps.set_memory(&[*next, *last, *before]);
            self.holds_first = *holds == 1.0;
            if let [begin, step, ready] = *ahead {
                self.ahead = Some(Ahead { begin, step, ready: ready == 1.0 });
            }
        }
    }
}

/// The slopes by a row of a table, times the step.
pub(super) const fn slopes(weights: &[f64], step: f64) -> Terms<'_> {
    Terms::weighted(1, weights, step)
}
