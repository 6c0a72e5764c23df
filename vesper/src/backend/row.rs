//! The loop of a row law: block by block, lanes first, then the rows that are left one by one.

use super::pointers::{
    AdvanceAll, AdvanceCoordinates, AdvanceMomenta, RateRule, Rows, RowsMut, Slots, StoreAll, StoreCoordinates,
    StoreMomenta, wants,
};
use super::{Compiled, Kernel};
use crate::law::{Declared, Mode, Part, RowFamily, RowLaw, Signature};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use core::marker::PhantomData;

/// One call of a row kernel.
pub(crate) struct RowCall<'a, P> {
    /// A pointer for every component: to the first row, or to the one number of a constant, or null.
    pub(crate) slots: &'a [*mut P],
    pub(crate) rows: usize,
    /// The states whose rates are wanted.
    pub(crate) part: Part,
    /// The step by which rates advance the states they point to; `None` stores the rates.
    pub(crate) advance: Option<P>,
}

/// A row law with its loop.
pub(crate) trait RowKernel<P>: Send + Sync {
    /// # Safety
    /// Every slot is null where its port is absent, or points to `rows` numbers (one for a constant) that are valid,
    /// and that nobody else touches where the port writes.
    unsafe fn run(&self, isa: Isa, call: &RowCall<'_, P>);
    /// The energy of the rows, where the law knows it.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64>;
}

/// Makes the loop of a row law.
pub fn row<P: Scalar, F: RowFamily>(law: &F) -> Compiled<P> {
    Compiled { signature: F::SIGNATURE, energy: F::ENERGY, kernel: Kernel::Row(Box::new(law.clone())) }
}

/// Whether a law gives rates; if not, all rules compile to the same loop, and one is enough.
const fn gives_rates(signature: &Signature) -> bool {
    let mut port = 0;
    while port < signature.ports.len() {
        if matches!(signature.ports[port].mode, Mode::Rates) {
            return true;
        }
        port += 1;
    }
    false
}

impl<P: Scalar, F: RowFamily> RowKernel<P> for F {
    unsafe fn run(&self, isa: Isa, call: &RowCall<'_, P>) {
        if const { !gives_rates(&F::SIGNATURE) } {
            return Task::<P, F, StoreAll>::run(self, isa, call);
        }
        match (call.part, call.advance.is_some()) {
            (Part::All, false) => Task::<P, F, StoreAll>::run(self, isa, call),
            (Part::Coordinates, false) => Task::<P, F, StoreCoordinates>::run(self, isa, call),
            (Part::Momenta, false) => Task::<P, F, StoreMomenta>::run(self, isa, call),
            (Part::All, true) => Task::<P, F, AdvanceAll>::run(self, isa, call),
            (Part::Coordinates, true) => Task::<P, F, AdvanceCoordinates>::run(self, isa, call),
            (Part::Momenta, true) => Task::<P, F, AdvanceMomenta>::run(self, isa, call),
        }
    }

    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64> {
        if !F::ENERGY {
            return None;
        }
        let slots = Slots::copied(call.slots);
        let law = self.kernel::<P>();
        let energy = (0..call.rows).map(|row| {
            // SAFETY: the caller promises the rows.
            let source = unsafe { Rows::<P>::new(&slots, row) };
            law.energy(<F::Kernel<P> as Declared<P>>::load(&source)).to_f64()
        });
        Some(energy.sum())
    }
}

struct Task<'a, P, F, Rule> {
    law: &'a F,
    call: &'a RowCall<'a, P>,
    rule: PhantomData<Rule>,
}

impl<'a, P: Scalar, F: RowFamily, Rule: RateRule> Task<'a, P, F, Rule> {
    fn run(law: &'a F, isa: Isa, call: &'a RowCall<'a, P>) {
        P::with_lanes(isa, Self { law, call, rule: PhantomData });
    }
}

impl<P: Scalar, F: RowFamily, Rule: RateRule> Task<'_, P, F, Rule> {
    #[inline(always)]
    fn step<R: Lanes<P>>(law: &F::Kernel<R>, slots: &Slots<P>, row: usize, step: R) {
        // SAFETY: `RowKernel::run` was promised the rows; all loads of a row come before its stores.
        let source = unsafe { Masked::<P, F, Rule>::new(slots, row) };
        let output = law.row(<F::Kernel<R> as Declared<R>>::load(&source));
        // SAFETY: as above.
        let mut sink = unsafe { RowsMut::<P, R, Rule>::new(slots, row, step) };
        <F::Kernel<R> as Declared<R>>::store(output, &mut sink);
    }
}

impl<P: Scalar, F: RowFamily, Rule: RateRule> WithLanes<P> for Task<'_, P, F, Rule> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let slots = Slots::copied(self.call.slots);
        let (rows, step) = (self.call.rows, self.call.advance.unwrap_or_default());
        let mut row = 0;
        if R::WIDTH > 1 && rows >= R::WIDTH {
            let law = self.law.kernel::<R>();
            let step = R::splat(step);
            while row + R::WIDTH <= rows {
                Self::step::<R>(&law, &slots, row, step);
                row += R::WIDTH;
            }
        }
        let law = self.law.kernel::<P>();
        while row < rows {
            Self::step::<P>(&law, &slots, row, step);
            row += 1;
        }
    }
}

/// [`Rows`] that only load what the wanted rates depend on.
struct Masked<'a, P, F, Rule> {
    rows: Rows<'a, P>,
    marker: PhantomData<(F, Rule)>,
}

impl<'a, P, F: RowFamily, Rule: RateRule> Masked<'a, P, F, Rule> {
    const MASK: u64 = wants(F::SIGNATURE.ports, Rule::PART);

    #[inline(always)]
    unsafe fn new(slots: &'a Slots<P>, row: usize) -> Self {
        // SAFETY: passed on to the caller.
        Masked { rows: unsafe { Rows::new(slots, row) }, marker: PhantomData }
    }
}

impl<P: Copy, R: Lanes<P>, F: RowFamily, Rule: RateRule> crate::law::Source<R> for Masked<'_, P, F, Rule> {
    #[inline(always)]
    fn wants(&self, port: usize) -> bool {
        port >= 64 || Self::MASK >> port & 1 == 1
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        crate::law::Source::<R>::has(&self.rows, slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        self.rows.component(slot)
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.rows.constant(slot)
    }
}
