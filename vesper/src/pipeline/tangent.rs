//! The program of derivatives: how all rates change as the state moves along a direction.
//!
//! In: the plan of an evaluation of all rates, with a direction in the space of states. Out: `Tangent`, which runs the
//! same laws in the same order, each over dual numbers: every quantity that a law computes has here an array of values and one
//! of derivatives, and states have the direction for theirs. Exact for row, pair and link laws and for stock fields. Column
//! laws, laws made at run time, and fields that are closures have no body over duals: central differences (`difference`).
//! Switches and regions are held as they are, and so is what laws look back at. Never: a column that an evaluation writes, a
//! rate of [`super::Vectors`], lanes, threads.
//!
//! It is made only for integrators that ask ([`crate::integrate::Integrator::needs_derivatives`]) and for
//! [`crate::engine::Engine::stable_step`].

mod bind;
mod difference;

use super::bind::Base;
use super::run::Context;
use super::switches::{Phase, RegionsAt};
use crate::backend::{DualReach, Kernel, Reach, TangentCall};
use crate::column::Aligned;
use crate::real::{Dual, Scalar, Vector};
use difference::Difference;

/// Where a component is: its values may be the client's, its derivatives are this program's own.
#[derive(Clone, Copy, Debug)]
struct Place<P> {
    value: Base<P>,
    stride: usize,
    index: *const u32,
    derivative: Reach<P>,
}

impl<P: Scalar> Place<P> {
    const NONE: Self = Place {
        value: Base::Owned(core::ptr::null_mut()),
        stride: 0,
        index: core::ptr::null(),
        derivative: Reach::NONE,
    };

    fn resolve(&self, lent: &[*mut P]) -> DualReach<P> {
        let value = Reach { start: self.value.resolve(lent), stride: self.stride, index: self.index };
        DualReach { value, derivative: self.derivative }
    }
}

/// One operation.
enum Step<P: Scalar> {
    /// A sum begins: from zero, or from the values of another quantity.
    Start { to: Vec<Place<P>>, from: Vec<Place<P>>, rows: usize },
    /// A field is sampled, and differentiated, at the place of every row.
    Sample { field: usize, at: Vec<Place<P>>, to: Vec<Place<P>>, rows: usize, regions: Option<RegionsAt<P>> },
    /// A law runs over duals.
    Law { law: usize, slots: Vec<Place<P>>, rows: usize, ends: (*const u32, usize) },
    /// A column law runs some times over numbers.
    Difference(Difference<P>),
}

/// The program of derivatives of a pipeline.
pub(crate) struct Tangent<P: Scalar> {
    steps: Vec<Step<P>>,
    /// The direction, and the derivatives of the rates, laid out as the vectors of the pipeline.
    along: Aligned<P>,
    rates: Aligned<P>,
    /// Where the components of the law at hand are.
    resolved: Vec<DualReach<P>>,
    /// Keeps what the places point to.
    _arrays: Vec<Aligned<P>>,
    _indices: Vec<Vec<u32>>,
}

impl<P: Scalar> Tangent<P> {
    /// The direction, to fill before a run.
    pub(crate) fn along(&mut self) -> &mut [P] {
        self.along.as_mut_slice()
    }

    /// The derivatives of the rates, after a run.
    pub(crate) fn rates(&self) -> &[P] {
        self.rates.as_slice()
    }

    /// Runs the laws over duals.
    ///
    /// # Safety
    /// The state has the layout that the program was tied to, and nobody else touches it.
    pub(crate) unsafe fn run(&mut self, context: &Context<'_, P>) {
        let resolved = &mut self.resolved;
        for step in &mut self.steps {
            match step {
                Step::Start { to, from, rows } => {
                    for (number, to) in to.iter().enumerate() {
                        let (to, from) =
                            (to.resolve(context.lent), from.get(number).map(|from| from.resolve(context.lent)));
                        for row in 0..*rows {
                            // SAFETY: a sum has a number for every row, and so has what it starts from.
                            unsafe {
                                to.store(row, from.map_or(Dual::constant(P::default()), |from| from.load(row)));
                            }
                        }
                    }
                }
                Step::Sample { field, at, to, rows, regions } => {
                    let regions = regions.filter(|_| context.phase != Phase::Free);
                    let [at, to] = [at, to].map(|places| [0, 1, 2].map(|c| places[c].resolve(context.lent)));
                    for row in 0..*rows {
                        // SAFETY: as above.
                        unsafe { sample(context, *field, (row, regions), at, to) };
                    }
                }
                Step::Law { law, slots, rows, ends } => {
                    resolved.clear();
                    resolved.extend(slots.iter().map(|place| place.resolve(context.lent)));
                    // SAFETY: the links of the layout that the program was tied to, or none.
                    let ends = if ends.1 == 0 { &[] } else { unsafe { core::slice::from_raw_parts(ends.0, ends.1) } };
                    let call = TangentCall { slots: resolved, rows: *rows, ends };
                    // SAFETY: the places reach the rows; what is written is this program's own.
                    unsafe {
                        match &context.laws[*law].compiled.kernel {
                            Kernel::Row(kernel) => kernel.tangent(&call),
                            Kernel::Pair(kernel) => kernel.tangent(&call),
                            Kernel::Link(kernel) => kernel.tangent(&call),
                            Kernel::Column(_) => {}
                        }
                    }
                }
                // SAFETY: passed on to the caller.
                Step::Difference(difference) => unsafe { difference.run(context) },
            }
        }
    }
}

/// Samples a field at one row, and its derivative along the row's own.
///
/// # Safety
/// The row has all numbers.
unsafe fn sample<P: Scalar>(
    context: &Context<'_, P>,
    field: usize,
    (row, regions): (usize, Option<RegionsAt<P>>),
    at: [DualReach<P>; 3],
    to: [DualReach<P>; 3],
) {
    let field = &context.fields[field].1;
    // SAFETY: passed on to the caller.
    let [x, y, z] = at.map(|at| unsafe { at.load(row) });
    let place = P::Vec3::new(x.value, y.value, z.value);
    let along = P::Vec3::new(x.derivative, y.derivative, z.derivative);
    // SAFETY: as above.
    let region = regions.map_or_else(|| field.region(place), |regions| unsafe { regions.held(row) });
    let value = field.sample_in(region, place, context.time);
    let change = field.derivative(region, place, along, context.time);
    let results = [(value.x(), change.x()), (value.y(), change.y()), (value.z(), change.z())];
    for (to, (value, change)) in to.into_iter().zip(results) {
        // SAFETY: as above.
        unsafe { to.store(row, Dual::new(value, change)) };
    }
}
