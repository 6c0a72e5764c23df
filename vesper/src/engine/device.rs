//! Engines with laws on a graphics processor.
//!
//! In: laws that ask for one. Out: the device, what was moved to it and back, and a fault where it is gone with numbers that only it had.
//! Never: a move.

mod calibrate;
#[cfg(test)]
mod trials;

pub(super) use calibrate::calibrated;

use super::{Engine, blow_up};
use crate::backend::gpu::{Device, Transfers};
use crate::error::Faults;
use crate::pipeline::{Listed, Opened};
use crate::real::Scalar;
use crate::registry::Backend;
use std::sync::Arc;

#[cfg(test)]
thread_local! {
    /// The device that engines of this thread get.
    static GIVEN: core::cell::RefCell<Option<Arc<Device>>> = const { core::cell::RefCell::new(None) };
}

/// The graphics processor, where a law asks for one.
pub(super) fn device<P: Scalar>(laws: &[Listed<P>]) -> Opened {
    let asks = laws.iter().any(|law| matches!(law.entry.options.backend, Backend::Gpu | Backend::Fastest));
    #[cfg(test)]
    if let Some(device) = GIVEN.with_borrow(Clone::clone).filter(|_| asks) {
        return Some(Ok(device));
    }
    asks.then(|| {
        Device::open().map(Arc::new).map_err(|error| {
            log::warn!("{error}: its laws run on the host");
            error.to_string()
        })
    })
}

impl<P: Scalar> Engine<P> {
    /// What was moved to and from the graphics processor, counted from zero when the engine is built, and again whenever a law is switched, or
    /// a row or a column added or removed. Only with the feature `gpu`.
    pub fn transfers(&self) -> Transfers {
        self.pipeline.transfers()
    }

    /// Foresees what frames will move, for `explain`.
    pub(super) fn foresee(&mut self) {
        // An origin that moves follows the rows where they are.
        let follows = self.state.origin.is_some();
        self.pipeline.foresight = if follows { None } else { self.pipeline.foresee(&mut *self.integrator) };
    }

    /// Numbers that have come back from a device are looked at, and a loss of some is told.
    pub(super) fn look_after_device(&mut self) -> Result<(), Faults> {
        if self.pipeline.residency.is_none() {
            return Ok(());
        }
        if self.pipeline.look_for_loss() {
            // Its vectors were there.
            self.integrator.restart();
        }
        self.pipeline.tell_loss()?;
        // Of another layout nothing is known yet.
        if !self.pipeline.have_returned() || self.pipeline.layout != self.state.layout() {
            return Ok(());
        }
        blow_up::check(&self.pipeline, &self.state, self.machine.isa, (self.steps, self.time()))
    }
}
