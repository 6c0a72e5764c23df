//! Reversible RESPA, for laws of different pace: leapfrog with every law that is evaluated on each step, and, for laws that
//! are evaluated on every k-th, kicks of k steps' worth at both ends of k steps.
//!
//! Order 2 in the longest k h. Time-reversible, and symplectic where all frames are alike. One evaluation of the fast
//! laws per step; one of the slow ones, and one more of the fast ones, in k steps. For forces of which the costly part is
//! slow: many bodies with stiff links, near and far neighbours. The slow kicks must not beat in time with the fast motion: k
//! h below a half of its period (Biesiadecki, Skeel). A group of k steps ends with a frame, so that what the client sees
//! is complete: frames of a multiple of k steps cost the least, and frames of one step gain nothing. Any other
//! integrator of fixed steps keeps the force of the last evaluation instead, which is of order 1 and not reversible.
//!
//! Sources: Tuckerman, Berne, Martyna, J. Chem. Phys. 97 (1992) 1990; Grubmueller et al., Mol. Simul. 6 (1991) 121;
//! Biesiadecki, Skeel, J. Comput. Phys. 109 (1993) 318, for the resonance.

use super::{Integrator, Pace, Part, Register, Structure, System};
use crate::error::Fault;

/// Reversible RESPA: order 2, laws are evaluated as often as their `every` says.
#[derive(Clone, Debug, Default)]
pub struct Respa {
    /// The groups of steps that are under way, one for each pace; none at the end of a frame.
    groups: Vec<Group>,
    /// Whether the rates of the fast laws at this state are known.
    knows_fast: bool,
    /// The pace of which the rates at this state are known.
    knows: Option<u32>,
}

/// Steps between two kicks of laws of one pace.
#[derive(Clone, Copy, Debug)]
struct Group {
    pace: u32,
    /// Steps in all, and those that are left.
    steps: u64,
    left: u64,
}

/// The rates of the slow laws alone.
const SLOW: Register = Register::Work(0);
/// Those of the fast ones, while others are computed.
const FAST: Register = Register::Work(1);

impl Respa {
    /// Kicks by laws of this pace for a time, in s.
    fn kick(&mut self, system: &mut dyn System, pace: u32, time: f64) {
        if self.knows != Some(pace) {
            self.fast(system);
            system.copy(FAST, Register::Rates, Part::Momenta);
            system.evaluate_at_pace(Pace::With(pace));
            system.combine(SLOW, &[(1.0, Register::Rates), (-1.0, FAST)], Part::Momenta);
            system.copy(Register::Rates, FAST, Part::Momenta);
            self.knows = Some(pace);
        }
        system.axpy(Register::State, time, SLOW, Part::Momenta);
    }

    fn fast(&mut self, system: &mut dyn System) {
        if !core::mem::replace(&mut self.knows_fast, true) {
            system.evaluate_at_pace(Pace::Fast);
        }
    }
}

/// How many steps there are before a multiple of the pace, or before the end of the frame.
fn group(pace: u32, done: u64, ahead: u64) -> u64 {
    (u64::from(pace) - done % u64::from(pace)).min(ahead)
}

impl Integrator for Respa {
    fn name(&self) -> &'static str {
        "respa"
    }

    fn order(&self) -> u32 {
        2
    }

    fn steps_alike(&self) -> bool {
        true
    }

    fn work_vectors(&self) -> usize {
        2
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.separable(self.name())?;
        structure.without_jumps(self.name())
    }

    fn remark(&self, structure: &Structure) -> Option<String> {
        let law = structure.every.as_ref()?;
        Some(format!("{law} kicks for all of its steps at once; a frame is a multiple of them at best"))
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let (done, ahead) = (system.steps_done(), system.steps_ahead());
        if self.groups.is_empty() {
            for pace in system.paces() {
                let left = group(pace, done, ahead);
                self.kick(system, pace, 0.5 * step * left as f64);
                self.groups.push(Group { pace, steps: left, left });
            }
        }
        self.fast(system);
        system.axpy(Register::State, 0.5 * step, Register::Rates, Part::Momenta);
        let start = system.time();
        system.advance(&[(Part::Coordinates, step)]);
        system.set_time(start + step);
        (self.knows, self.knows_fast) = (None, false);
        self.fast(system);
        system.axpy(Register::State, 0.5 * step, Register::Rates, Part::Momenta);
        for number in 0..self.groups.len() {
            let Group { pace, steps, left } = self.groups[number];
            if left > 1 {
                self.groups[number].left -= 1;
                continue;
            }
            // Half of the kick that ends, and half of the one that begins, if the frame goes on.
            let next = if ahead > 1 { group(pace, done + 1, ahead - 1) } else { 0 };
            self.groups[number] = Group { pace, steps: next, left: next };
            self.kick(system, pace, 0.5 * step * (steps + next) as f64);
        }
        if ahead <= 1 {
            self.groups.clear();
        }
        Ok(())
    }

    fn restart(&mut self) {
        *self = Respa::default();
    }
}
