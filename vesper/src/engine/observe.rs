//! Looks at one more property while the engine runs.
//!
//! In: a column's name. Out: the column, computed and kept from now on. Never: a step.

use super::Engine;
use crate::domain::AsProperty;
use crate::error::Faults;
use crate::real::{Scalar, compiled_here};

impl<P: Scalar> Engine<P> {
    /// Looks at a property, as [`Builder::observe`](super::Builder::observe) does from the start: what it needs is computed at
    /// once, and after each frame. Integrators begin anew.
    ///
    /// # Errors
    /// No law computes it, laws no longer fit the state, or the client borrows lent memory; nothing more is looked at then.
    pub fn observe_also(&mut self, domain: &str, property: impl AsProperty) -> Result<(), Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>, domain: &str, property: &str| -> Result<(), Faults> {
            engine.look_at(domain, property)
        })(self, domain, property.info().name)
    }

    fn look_at(&mut self, domain: &str, property: &str) -> Result<(), Faults> {
        if self.observe.iter().any(|(on, what)| on == domain && what == property) {
            return Ok(());
        }
        self.observe.push((domain.to_owned(), property.to_owned()));
        self.stale = true;
        self.quiet = f64::NAN;
        let done = self.prepare().and_then(|()| self.observe());
        if done.is_err() {
            self.observe.pop();
            self.stale = true;
        }
        done
    }
}
