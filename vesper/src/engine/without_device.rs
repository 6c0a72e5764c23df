//! What an engine asks of `device`, in a build without the feature `gpu`: laws run on the host.

use super::Engine;
use crate::error::Faults;
use crate::integrate::Integrator;
use crate::pipeline::{FusedChain, Listed, Machine, Opened, Pipeline, Settings};
use crate::real::Scalar;
use crate::state::State;

pub(super) fn device<P: Scalar>(_: &[Listed<P>]) -> Opened {}

pub(super) fn calibrated<P: Scalar>(
    pipeline: Pipeline<P>,
    _: (&mut [Listed<P>], &[FusedChain<P>], &mut Machine),
    _: (&mut State<P>, &mut dyn Integrator),
    _: (&[(String, String)], Settings, Option<f64>),
) -> Result<(Pipeline<P>, Vec<String>), Faults> {
    Ok((pipeline, Vec::new()))
}

impl<P: Scalar> Engine<P> {
    pub(super) fn foresee(&mut self) {}

    #[inline(always)]
    pub(super) fn look_after_device(&mut self) -> Result<(), Faults> {
        Ok(())
    }
}
