//! Which steps a run takes, and which of them end a frame or lie before a date.
//!
//! In: the times of `[engine]`, and where the engine stands. Out: numbers of steps. Never: a sum of frames; every number
//! is computed from the start, so that a long run, and one that was resumed, has its frames where a short one has them.
//!
//! A run covers its end exactly. Where the end is no multiple of the step, the last step is shorter; a checkpoint is
//! taken before it, so that whoever goes on goes on with whole steps.

use vesper::prelude::*;

use crate::assemble::integrators::is_adaptive;
use crate::fault::{SceneFault, Spanned, number};
use crate::scene::Scene;

/// Frames of a run by an adaptive integrator whose scene does not say their length.
pub(crate) const ADAPTIVE_FRAMES: f64 = 200.0;

/// Beyond this a count of steps is no longer exact in f64.
const MOST_STEPS: f64 = 1e15;

/// The times of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Time at step `since`, from which the engine counts, in s.
    origin: f64,
    since: u64,
    /// Fixed step, in s; a frame, where the integrator chooses its own.
    pub step: f64,
    /// Start of the scene, in s: frames and dates count from here.
    pub start: f64,
    frame: f64,
    /// End, in s.
    pub end: f64,
}

impl Course {
    /// The course of `scene`, whose start is at time `start`.
    ///
    /// # Errors
    /// The scene says no step, or no end, or an end that cannot be reached.
    pub fn new(scene: &Scene, start: f64) -> Result<Self, Vec<SceneFault>> {
        let engine = &scene.engine;
        let mut faults = Vec::new();
        let mut missing = |text: &str, help: &str| {
            faults.push(SceneFault { help: Some(help.to_owned()), ..scene.fault_of_file(text) });
        };
        let adaptive = engine.integrator.as_ref().is_some_and(|choice| is_adaptive(&choice.name.value));
        let step = engine.step.as_ref().or(engine.frame.as_ref());
        if step.is_none() && !adaptive {
            missing("the scene has no step", "write `step = ..` into [engine], or run with --step S");
        }
        if engine.end.is_none() {
            missing("the scene has no end", "write `end = ..` into [engine], or run with --end S");
        }
        let Some(end) = &engine.end else { return Err(faults) };
        let shown = Spanned { value: (end.value - start) / ADAPTIVE_FRAMES, span: end.span };
        let step = match (step, &engine.frame) {
            // Its own steps are within the frames.
            (_, Some(frame)) if adaptive => frame,
            _ if adaptive => &shown,
            (Some(step), _) => step,
            (None, _) => return Err(faults),
        };
        let frame = engine.frame.as_ref().map_or(step.value, |frame| frame.value);
        if end.value < start {
            let text = format!("the end, {} s, is before the start, {} s", number(end.value), number(start));
            return Err(vec![scene.fault(end.span, text, None)]);
        }
        if (end.value - start) / step.value.min(frame) > MOST_STEPS {
            let span = step.span;
            let (way, step) = (number(end.value - start), number(step.value.min(frame)));
            let text = format!("{way} s in steps of {step} s are too many to count");
            return Err(vec![scene.fault(span, text, None)]);
        }
        Ok(Self { origin: start, since: 0, step: step.value, start, frame, end: end.value })
    }

    /// The same course for an engine that goes on from a checkpoint.
    #[must_use]
    pub fn resumed(self, checkpoint: &Checkpoint) -> Self {
        let (origin, since, step) = checkpoint.clock;
        match step == self.step {
            true => Self { origin, since, ..self },
            // Another step from here on, or a checkpoint from before the first step.
            false => Self { origin: checkpoint.time, since: checkpoint.steps, ..self },
        }
    }

    /// The number of the last step that ends at `time` or before, and what is left, in s: 0 where it ends there.
    pub fn steps_at(&self, time: f64) -> (u64, f64) {
        let exact = ((time - self.origin) / self.step).max(0.0);
        // A time that is a multiple of the step but for rounding is that many steps.
        let slack = 1e-9 + 1e-14 * exact;
        let whole = (exact + slack).floor();
        let rest = exact - whole;
        (self.since + whole as u64, if rest > slack { rest * self.step } else { 0.0 })
    }

    /// Whole steps of the run, and the length of a shorter last one.
    pub fn last(&self) -> (u64, f64) {
        self.steps_at(self.end)
    }

    /// The step with which frame `number` ends; that of the whole run for later frames.
    pub fn frame_end(&self, number: u64) -> u64 {
        let time = self.start + number as f64 * self.frame;
        if time >= self.end { self.last().0 } else { self.steps_at(time).0 }
    }

    /// Number of frames; the last one may be shorter.
    pub fn frames(&self) -> u64 {
        let exact = (self.end - self.start) / self.frame;
        (exact - 1e-9 - 1e-14 * exact).ceil().max(0.0) as u64
    }

    /// The first frame that ends after step `step`.
    pub fn frame_after(&self, step: u64) -> u64 {
        let time = self.origin + (step as f64 - self.since as f64) * self.step;
        let mut number = ((time - self.start) / self.frame).floor().max(0.0) as u64;
        while number < self.frames() && self.frame_end(number) <= step {
            number += 1;
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn course(engine: &str) -> Result<Course, Vec<SceneFault>> {
        Course::new(&Scene::from_text("a.toml", &format!("[engine]\n{engine}"), Path::new(""), &[]).unwrap(), 0.0)
    }

    #[test]
    fn whole_steps_and_a_shorter_last_one() {
        let at = |text: &str| course(text).unwrap();
        assert_eq!(at("step = 0.1\nend = 0.3").last(), (3, 0.0));
        assert_eq!(at("step = 0.1\nend = 1e6").last(), (10_000_000, 0.0));
        assert_eq!(at("step = 3600\nend = 347241600").last(), (96_456, 0.0));
        let (steps, rest) = at("step = 0.3\nend = 1").last();
        assert!(steps == 3 && (rest - 0.1).abs() < 1e-15, "{rest}");
        assert_eq!(at("step = 2\nend = 1").last(), (0, 1.0));
        assert_eq!(at("step = 2\nend = 0").last(), (0, 0.0));
    }

    #[test]
    fn frames_end_with_whole_steps() {
        let of = course("step = 0.3\nframe = 1\nend = 3.5").unwrap();
        assert_eq!(of.frames(), 4);
        assert_eq!((0..=5).map(|frame| of.frame_end(frame)).collect::<Vec<_>>(), [0, 3, 6, 10, 11, 11]);
        assert_eq!((of.frame_after(0), of.frame_after(3), of.frame_after(5), of.frame_after(10)), (1, 2, 2, 4));
        // Without a step, frames are steps; without a frame, steps are frames.
        assert_eq!(course("frame = 0.5\nend = 2").unwrap().last(), (4, 0.0));
        assert_eq!(course("step = 0.5\nend = 2").unwrap().frames(), 4);
        assert_eq!(course("step = 0.1\nend = 0.3").unwrap().frames(), 3);
    }

    #[test]
    fn what_is_missing_is_said() {
        let texts = |text: &str| course(text).unwrap_err().into_iter().map(|fault| fault.text).collect::<Vec<_>>();
        assert_eq!(texts("threads = 1"), ["the scene has no step", "the scene has no end"]);
        assert_eq!(texts("step = 1e-9\nend = 1e9"), ["1e9 s in steps of 1e-9 s are too many to count"]);
    }
}
