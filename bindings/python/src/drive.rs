//! Takes many steps in pieces, with a look at Python between.
//!
//! In: how many steps. Out: pieces of them, one after the other, until all are taken, or Python has a signal, or a piece failed.
//! Never: a piece whose length decides what comes out of a call that goes well, unless it is the same in every run.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use vesper_c::session::Session;

/// A piece that took less is followed by a longer one.
const SHORT: Duration = Duration::from_millis(5);
/// A piece that took more is followed by a shorter one.
const LONG: Duration = Duration::from_millis(50);
/// Steps in a piece where laws of Python run: an exception undoes no more, and a law that only sets what is observed is evaluated
/// once for each piece.
const WITH_PYTHON: u64 = 16;
/// Longest frame, in steps, that is divided; what is longer is a fault of the session's.
const MOST: f64 = 1e15;

/// How many steps are taken at once.
#[derive(Debug)]
pub(crate) struct Pace {
    piece: AtomicU64,
    /// Whether pieces always have this length: where one begins integrators begin anew, since nobody knows who wrote into lent memory,
    /// and an origin may move.
    fixed: bool,
    /// What a frame is divided into, in s.
    step: Option<f64>,
}

impl Pace {
    /// Of an engine with so many lent numbers, and laws of Python or none.
    pub(crate) fn new(session: &Session, lent: usize, python: bool) -> Self {
        let by_size = |numbers: usize| (1_u64 << 20) / numbers.max(1) as u64;
        let piece = match (python, lent, session.moving_origin()) {
            (true, ..) => Some(WITH_PYTHON),
            (_, 0, None) => None,
            (_, 0, Some(_)) => Some(256),
            (_, lent, _) => Some(by_size(lent).clamp(16, 4096)),
        };
        Pace { piece: AtomicU64::new(piece.unwrap_or(1)), fixed: piece.is_some(), step: session.fixed_step() }
    }

    /// Takes `count` steps: calls `take` for each piece, with how many steps were taken before it, and how many it takes.
    #[inline]
    pub(crate) fn steps(
        &self,
        py: Python<'_>,
        count: u64,
        mut take: impl FnMut(u64, u64) -> PyResult<()>,
    ) -> PyResult<()> {
        // What most calls are, without a look at a clock. Python looks for signals itself when it comes back.
        if count <= 1 {
            return take(0, count);
        }
        let mut done = 0;
        loop {
            let most = self.piece.load(Ordering::Relaxed);
            let taken = most.min(count - done);
            let from = Instant::now();
            take(done, taken)?;
            self.took(taken, most, from.elapsed());
            done += taken;
            if done == count {
                return Ok(());
            }
            py.check_signals()?;
        }
    }

    /// Goes on by a frame of `frame` s: calls `take` for each piece of it, with its length in s.
    #[inline]
    pub(crate) fn frame(&self, py: Python<'_>, frame: f64, mut take: impl FnMut(f64) -> PyResult<()>) -> PyResult<()> {
        let Some(step) = self.step else { return take(frame) };
        // All pieces but the last are whole steps; a frame that is a multiple of the step but for rounding is that many.
        let steps = (frame / step * (1.0 - 1e-9)).ceil();
        let count = if steps < MOST { steps as u64 } else { 1 };
        self.steps(py, count, |done, taken| {
            let last = done + taken >= count;
            take(if last { frame - done as f64 * step } else { taken as f64 * step })
        })
    }

    fn took(&self, taken: u64, most: u64, time: Duration) {
        if self.fixed {
            return;
        }
        if time > LONG {
            let fewer = taken as f64 * (LONG.as_secs_f64() / time.as_secs_f64());
            self.piece.store((fewer as u64).max(1), Ordering::Relaxed);
        } else if taken == most && time < SHORT {
            self.piece.store(most.saturating_mul(2), Ordering::Relaxed);
        }
    }
}
