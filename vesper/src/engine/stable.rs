//! How long a step may be before an explicit integrator lets what should fade grow.
//!
//! In: an engine as it is. Out: [`StableStep`], for the state and time at hand. Never: a change of either.

use super::Engine;
use super::lent::with_runner;
use crate::error::Faults;
use crate::integrate::{StableStep, System, stable_step, stable_vectors};
use crate::law::Shape;
use crate::pipeline::{Runner, Tangent, Vectors};
use crate::real::{Scalar, compiled_here};
use crate::registry::Status;

impl<P: Scalar> Engine<P> {
    /// The longest step at which the integrator is stable at the state as it is, from the laws' own derivatives; `None` for an
    /// integrator that is stable at any step, or that chooses its own. An estimate: where thousands of rates are close to the
    /// largest one, that one is underestimated by some hundredths. Costs some tens of derivatives of all laws, each of some
    /// evaluations.
    ///
    /// # Errors
    /// Laws no longer fit the state, or the client borrows lent memory.
    pub fn stable_step(&mut self) -> Result<Option<StableStep>, Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>| -> Result<Option<StableStep>, Faults> {
            engine.longest_stable_step()
        })(self)
    }

    fn longest_stable_step(&mut self) -> Result<Option<StableStep>, Faults> {
        let Some(limits) = self.integrator.stable_limits(self.pipeline.structure.second_order) else { return Ok(None) };
        self.prepare()?;
        if self.pipeline.is_idle() {
            return Ok(Some(limits.longest(&[])));
        }
        let count = stable_vectors(self.pipeline.vectors.len());
        self.with_derivatives(count + 1, |runner| stable_step(runner, limits, count)).map(Some)
    }

    /// Runs `work` with derivatives of the laws and so many vectors.
    pub(super) fn with_derivatives<T>(
        &mut self,
        vectors: usize,
        work: impl FnOnce(&mut Runner<'_, P>) -> T,
    ) -> Result<T, Faults> {
        if self.pipeline.tangent.is_none() {
            self.pipeline.tangent = Some(Box::new(Tangent::new(&self.pipeline, &self.laws, &self.state)));
        }
        // What is looked at here is the host's.
        self.pipeline.come_home(true);
        self.pipeline.tell_loss()?;
        let residency = self.pipeline.residency.take();
        // Vectors of its own: those of the integrator, and what it remembers in them, stay as they are.
        let more = Vectors::new(&self.pipeline, &self.state, vectors, (false, false, false));
        let kept = core::mem::replace(&mut self.pipeline.vectors, more);
        let (time, step) = (self.time(), self.steps);
        let shared = (self.laws.as_slice(), self.chains.as_slice(), &self.machine);
        let found = with_runner(&mut self.pipeline, &self.state, shared, (time, step), |runner| {
            // Laws that are switched by what they left, as contact, are to be as in the next step.
            runner.hold();
            work(runner)
        });
        self.pipeline.vectors = kept;
        self.pipeline.residency = residency;
        if !self.integrator.needs_derivatives() {
            self.pipeline.tangent = None;
        }
        found
    }

    /// Rows, links and pairs that an evaluation of all laws goes through; for a column law as many as a pair law would: how
    /// much [`Engine::stable_step`] costs.
    pub fn terms(&self) -> u64 {
        let of = |(report, law): (&crate::registry::LawReport, &crate::pipeline::Listed<P>)| {
            let Status::Active { rows } = report.status else { return 0 };
            let rows = rows as u64;
            match law.entry.shape {
                Shape::Row | Shape::Link => rows,
                Shape::Pair | Shape::Column => rows.saturating_mul(rows),
            }
        };
        self.report().laws.iter().zip(&self.laws).map(of).fold(0, u64::saturating_add)
    }
}
