//! What the pipeline asks of `device`, in a build without the feature `gpu`: all passes run on the host, and all numbers are there.

use super::bind::{Binder, Pass};
use super::plan::Placed;
use super::run::{Context, Runner};
use super::{Machine, Pipeline};
use crate::integrate::{Combination, Register};
use crate::law::Part;
use crate::real::Scalar;
use crate::registry::QuantityId;
use crate::state::State;
use core::convert::Infallible;
use core::marker::PhantomData;

/// No pass is on a device.
pub(crate) struct DevicePass<P>(Infallible, PhantomData<P>);

/// No columns are.
#[derive(Clone)]
pub(crate) struct Shared<P>(Infallible, PhantomData<P>);

/// None of them is touched.
pub(crate) type Touch = Infallible;

/// No device was opened.
pub(crate) type Opened = ();

impl<P: Scalar> DevicePass<P> {
    pub(super) fn run(&self, _: &Context<'_, P>) -> bool {
        match self.0 {}
    }

    pub(super) fn host(&self) -> &Pass<P> {
        match self.0 {}
    }

    pub(super) fn host_mut(&mut self) -> &mut Pass<P> {
        match self.0 {}
    }
}

pub(super) fn residency<P: Scalar>(Machine { device: (), .. }: &Machine) -> Option<Shared<P>> {
    None
}

impl<P: Scalar> Binder<'_, P> {
    pub(super) fn on_device(&self, host: Pass<P>, _: &[Placed]) -> (Pass<P>, Option<String>) {
        (host, None)
    }

    pub(super) fn touched(&self, _: &[Placed]) -> Vec<Touch> {
        Vec::new()
    }
}

impl<P: Scalar> Context<'_, P> {
    #[inline(always)]
    pub(super) fn bring(&self, _: &[Touch]) {}
}

impl<P: Scalar> Runner<'_, P> {
    #[inline(always)]
    pub(super) fn come_home(&self, _: bool) {}

    #[inline(always)]
    pub(super) fn linear_on_device(&mut self, _: &Combination<'_>) -> bool {
        false
    }

    #[inline(always)]
    pub(super) fn copy_on_device(&mut self, _: (Register, Register), _: Part) -> bool {
        false
    }
}

impl<P: Scalar> Pipeline<P> {
    pub(crate) fn come_home(&self, _: bool) {}

    #[inline(always)]
    pub(super) fn begin(&self) -> Option<Shared<P>> {
        None
    }

    pub(super) fn let_go(&mut self, _: &mut State<P>) {}

    pub(super) fn has_lost_device(&self) -> bool {
        false
    }

    pub(super) fn moves(&self, _: &State<P>) -> Vec<String> {
        Vec::new()
    }

    pub(crate) fn late(&self, _: QuantityId, _: u64, _: f64) -> Option<(u64, f64, Vec<Vec<P>>)> {
        None
    }

    pub(crate) fn has_unseen_loss(&self) -> bool {
        false
    }

    pub(super) fn loss(&self) -> Option<String> {
        None
    }
}
