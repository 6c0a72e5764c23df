//! Laws that were compiled elsewhere may fail: then they are switched off, and the client is told.
//!
//! In: the laws of an engine, after they ran. Out: a fault for each that failed, once. Never: a step that is taken back: it was taken
//! without the law, from where it failed on.

use super::Engine;
use crate::error::{Fault, Faults};
use crate::pipeline::Listed;
use crate::real::Scalar;
use crate::registry::Status;

/// Why a law could not be made.
pub(super) fn not_made<P: Scalar>(listed: &Listed<P>) -> Option<Fault> {
    let reason = listed.compiled.foreign.as_ref()?.failure()?;
    Some(Fault::LawNotMade { law: listed.entry.label().to_owned(), reason })
}

/// Why a law is not called any more.
pub(super) fn failed<P: Scalar>(listed: &Listed<P>) -> Option<Fault> {
    let reason = listed.compiled.foreign.as_ref()?.failure()?;
    Some(Fault::LawFailed { law: listed.entry.label().to_owned(), reason })
}

impl<P: Scalar> Engine<P> {
    /// Switches off what failed, and says so behind what else went wrong.
    pub(super) fn with_failures(&mut self, done: Result<(), Faults>) -> Result<(), Faults> {
        let mut faults = Vec::new();
        let reports = self.pipeline.registry.report.laws.iter_mut();
        for (listed, report) in self.laws.iter_mut().zip(reports).filter(|(listed, _)| listed.entry.failed.is_none()) {
            let Some(fault) = failed(listed) else { continue };
            let reason = listed.compiled.foreign.as_ref().and_then(|foreign| foreign.failure()).unwrap_or_default();
            (listed.entry.options.enabled, listed.entry.failed) = (false, Some(reason.clone()));
            report.status = Status::Failed { reason };
            log::error!("{fault}");
            faults.push(fault);
        }
        if faults.is_empty() {
            return done;
        }
        self.stale = true;
        self.quiet = f64::NAN;
        match done {
            Ok(()) => Faults::unless_empty(faults, ()),
            Err(more) => Err(more.after(faults)),
        }
    }
}
