//! Steps that end where a law or a field jumps.
//!
//! In: a system that holds its switches, and steps that were tried. Out: the length at which the first one turns, to
//! rounding; the step is then taken once more, to there. No interpolation: what is true at the end of a step is true of the
//! state that the integrator goes on from. Never: a step of its own, but for integrators of fixed steps, by `split`.
//!
//! Sources: Shampine, Gladwell, Brankin, ACM TOMS 17 (1991) 11, on cases that are held; Dowell, Jarratt, BIT 11 (1971) 168, for
//! the Illinois method.

use super::{Integrator, System};
use crate::error::Fault;

/// A jump that is looked for, within a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Jump {
    /// The longest step after which nothing had turned, and the shortest one after which something had.
    low: f64,
    high: f64,
    /// Lengths that need not be told apart.
    least: f64,
    /// How often an end has stayed while the other one moved.
    stayed: [i32; 2],
    tries: u32,
}

/// What a look at the end of a step finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Found {
    /// Nothing has turned: the step stands.
    Nothing,
    /// The step is to be taken again, so long.
    Closer(f64),
    /// The step ends where something has just turned.
    Here,
}

/// Tries after which the bracket is halved: straight lines do not lead there.
const STRAIGHT: u32 = 30;
/// Tries that halve any bracket to nothing.
const MOST: u32 = 100;

impl Jump {
    /// Whether one is being looked for.
    pub(crate) fn is_near(&self) -> bool {
        self.tries > 0
    }

    /// Looks at the state at the end of a step of this length.
    pub(crate) fn look(&mut self, system: &mut dyn System, length: f64) -> Found {
        let turned = system.turned();
        if !turned && self.tries == 0 {
            return Found::Nothing;
        }
        if self.tries == 0 {
            self.least = 2.0 * f64::EPSILON * length;
        }
        self.tries += 1;
        if turned {
            self.high = length;
            self.stayed = [self.stayed[0] + 1, 0];
        } else {
            self.low = length;
            self.stayed = [0, self.stayed[1] + 1];
        }
        let width = self.high - self.low;
        let least = self.least;
        // Wide enough for a place within, a little off both ends, however these are rounded.
        if width <= 4.0 * least || self.tries > MOST {
            // The end at which something had turned, where a step that is taken again may show nothing: an iteration begins
            // from somewhere else, and comes to the last digits that it is asked for, not to all.
            return if turned || length >= self.high { Found::Here } else { Found::Closer(self.high) };
        }
        // An end that stays counts for half as much each time, so that the other one does not creep up to it.
        let weight = |stayed: i32| if stayed > 1 { 0.5f64.powi(stayed - 1) } else { 1.0 };
        let share = if self.tries > STRAIGHT { 0.5 } else { system.share(self.stayed.map(weight)) };
        Found::Closer((self.low + share * width).clamp(self.low + least, self.high - least))
    }
}

/// Takes a step of an integrator of fixed steps, in as many parts as it has jumps, and one more. `again` keeps the state, and
/// brings it back.
pub(crate) fn split<S: System>(
    integrator: &mut dyn Integrator,
    system: &mut S,
    step: f64,
    mut again: impl FnMut(&mut S, Again),
) -> Result<(), Fault> {
    let begin = system.time();
    if !system.hold() {
        return integrator.step(system, step);
    }
    let mut done = 0.0;
    let mut parts = 0;
    loop {
        let (time, mut length) = (begin + done, step - done);
        again(system, Again::Keep);
        let mut jump = Jump::default();
        let found = loop {
            integrator.step(system, length)?;
            integrator.finish(system)?;
            match jump.look(system, length) {
                Found::Closer(next) => {
                    again(system, Again::Restore);
                    system.set_time(time);
                    integrator.restart();
                    length = next;
                }
                found => break found,
            }
        };
        done += length;
        if found == Found::Here {
            system.turn();
            integrator.restart();
        }
        parts += 1;
        // A switch that turns to and fro: the rest of the step is taken across it.
        if parts > MOST_PARTS && step > done {
            return integrator.step(system, step - done);
        }
        if done >= step * (1.0 - 1e-14) {
            return Ok(());
        }
    }
}

/// Jumps in one step that are told apart.
const MOST_PARTS: u32 = 64;

/// What is to be done with the state before a step that may be taken again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Again {
    /// It is kept.
    Keep,
    /// It is brought back.
    Restore,
}
