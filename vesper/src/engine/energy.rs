//! The energy of a state, as far as its laws know theirs.
//!
//! In: an engine. Out: a sum, and who is missing in it. Never: a law of physics; laws say their energies themselves.

use super::Engine;
use super::lent::with_runner;
use crate::error::Faults;
use crate::pipeline::Key;
use crate::real::{Scalar, compiled_here};
use crate::registry::Status;

impl<P: Scalar> Engine<P> {
    /// The sum of the energies of all active laws that know theirs, in J; and the active laws that do not. A law whose
    /// result nobody needs is not among them.
    ///
    /// # Errors
    /// Laws no longer fit the state, or the client borrows lent memory.
    pub fn energy(&mut self) -> Result<(f64, Vec<String>), Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>| -> Result<(f64, Vec<String>), Faults> {
            engine.sum_of_energies()
        })(self)
    }

    fn sum_of_energies(&mut self) -> Result<(f64, Vec<String>), Faults> {
        self.prepare()?;
        let silent = self
            .report()
            .laws
            .iter()
            .zip(&self.laws)
            .filter(|(report, law)| matches!(report.status, Status::Active { .. }) && !law.compiled.knows_energy())
            .map(|(report, _)| report.label.clone())
            .collect();
        let (time, step) = (self.time(), self.steps);
        let energy = with_runner(
            &mut self.pipeline,
            &self.state,
            (&self.laws, &self.chains, &self.machine),
            (time, step),
            |runner| runner.run(Key::Energy),
        )?;
        Ok((energy, silent))
    }
}
