//! The loop of a row law: block by block, lanes first, then the rows that are left one by one.

#[cfg(feature = "gpu")]
use super::gpu::Trace;
use super::pointers::{
    AdvanceAll, AdvanceCoordinates, AdvanceMomenta, KickDrift, RateRule, Rows, RowsMut, Slots, StoreAll,
    StoreCoordinates, StoreFirst, StoreMomenta, slot_count, slots_at, wants,
};
use super::tangent::{self, TangentCall};
use super::within::Within;
use super::{Compiled, Kernel};
use crate::law::{Declared, Mode, Part, Place, RowFamily, RowLaw, Signature, Sink, Source};
use crate::property::Role;
use crate::real::{Isa, Lanes, Scalar, WithLanes, prefetch};
use core::marker::PhantomData;
use std::sync::Arc;

/// One call of a row kernel, laid out as in C: a module that was compiled apart is given it as it is.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct RowCall<'a, P> {
    /// A pointer for every component: to the first row, or to the one number of a constant, or null.
    pub(crate) slots: Pointers<'a, P>,
    /// One bit for each slot of a field that is the same in all rows: it has `MAX_WIDTH` equal numbers.
    pub(crate) uniform: u64,
    pub(crate) rows: usize,
    /// The states whose rates are wanted.
    pub(crate) part: Part,
    /// The step by which rates advance the states they point to; none stores the rates.
    pub(crate) advance: Maybe<P>,
    /// The step by which coordinates advance after the momenta, in the same loop.
    pub(crate) drift: Maybe<P>,
    /// Whether the sums of a law without rates begin with it: its shares are stored, whatever is there.
    pub(crate) first: bool,
    /// Memory that later calls will want: as many numbers as there are rows.
    pub(crate) ahead: [*const P; AHEAD],
}

/// A slice of pointers, laid out as in C.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Pointers<'a, P> {
    start: *const *mut P,
    count: usize,
    marker: PhantomData<&'a [*mut P]>,
}

impl<'a, P> From<&'a [*mut P]> for Pointers<'a, P> {
    #[inline(always)]
    fn from(slice: &'a [*mut P]) -> Self {
        Pointers { start: slice.as_ptr(), count: slice.len(), marker: PhantomData }
    }
}

impl<P> core::ops::Deref for Pointers<'_, P> {
    type Target = [*mut P];
    #[inline(always)]
    fn deref(&self) -> &[*mut P] {
        // SAFETY: it was made from a slice, which lives as long.
        unsafe { core::slice::from_raw_parts(self.start, self.count) }
    }
}

/// A number or none, laid out as in C.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Maybe<P> {
    value: P,
    there: bool,
}

impl<P: Default> From<Option<P>> for Maybe<P> {
    #[inline(always)]
    fn from(option: Option<P>) -> Self {
        Maybe { there: option.is_some(), value: option.unwrap_or_default() }
    }
}

impl<P: Copy> Maybe<P> {
    #[inline(always)]
    pub(crate) fn get(self) -> Option<P> {
        self.there.then_some(self.value)
    }
}

/// Bytes of a cache line.
const LINE: usize = 64;

/// Columns of which a call fetches the rows of a later call.
pub(crate) const AHEAD: usize = 2;

/// A row law with its loop.
pub(crate) trait RowKernel<P>: Send + Sync {
    /// Whether calls may be of some rows, so that threads share the work.
    fn splits(&self) -> bool {
        true
    }
    /// # Safety
    /// Every slot is null where its port is absent, or points to `rows` numbers (one for a constant) that are valid, with
    /// room behind them ([`crate::column::whole`]), and that nobody else touches where the port writes, nor that room: of the
    /// calls of one pass only the last one ends between multiples of the lanes.
    unsafe fn run(&self, isa: Isa, call: &RowCall<'_, P>);
    /// Runs the body over dual numbers.
    ///
    /// # Safety
    /// The call keeps its promises.
    unsafe fn tangent(&self, call: &TangentCall<'_, P>);
    /// The energy of the rows, where the law knows it.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64>;
    /// What a host that was compiled apart calls for this kernel, where it may.
    #[cfg(feature = "modules")]
    fn entry(&self) -> Option<super::RowFunction> {
        None
    }
    /// The body, recorded, where those components are there whose bits are set; none of a body that is not generic in its numbers.
    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace>;
}

/// Makes the loop of a row law.
pub fn row<P: Scalar, F: RowFamily>(law: &F) -> Compiled<P> {
    const { super::says_nothing_of_pairs(&F::SIGNATURE) };
    Compiled {
        signature: F::SIGNATURE,
        energy: F::ENERGY,
        parameters: law.parameters(),
        foreign: None,
        kernel: Kernel::Row(Arc::new(law.clone())),
    }
}

/// Which loops a law needs: where two rules would give the same, one is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Gives {
    /// No rates.
    Values,
    /// Nothing but rates of coordinates, or nothing but rates of momenta: there is no part of them to leave out.
    OneRole,
    /// Anything else.
    Mixed,
}

const fn gives(signature: &Signature) -> Gives {
    let (mut values, mut coordinates, mut momenta) = (false, false, false);
    let mut port = 0;
    while port < signature.ports.len() {
        let declared = &signature.ports[port];
        match (declared.mode, declared.property.role) {
            (Mode::Reads | Mode::Previous, _) => {}
            (Mode::Rates, Role::Coordinate) => coordinates = true,
            (Mode::Rates, _) => momenta = true,
            (Mode::Adds | Mode::Sets | Mode::Amends, _) => values = true,
        }
        port += 1;
    }
    match (values, coordinates, momenta) {
        (_, false, false) => Gives::Values,
        (false, true, false) | (false, false, true) => Gives::OneRole,
        _ => Gives::Mixed,
    }
}

impl<P: Scalar, F: RowFamily> RowKernel<P> for F {
    unsafe fn run(&self, isa: Isa, call: &RowCall<'_, P>) {
        let advance = call.advance.there;
        let run: unsafe fn(&F, Isa, &RowCall<'_, P>) = if const { matches!(gives(&F::SIGNATURE), Gives::Values) } {
            if call.first { run::<P, F, StoreFirst> } else { run::<P, F, StoreAll> }
        } else if const { matches!(gives(&F::SIGNATURE), Gives::OneRole) } {
            if advance { run::<P, F, AdvanceAll> } else { run::<P, F, StoreAll> }
        } else if call.drift.there {
            run::<P, F, KickDrift>
        } else {
            match (call.part, advance) {
                (Part::All, false) => run::<P, F, StoreAll>,
                (Part::Coordinates, false) => run::<P, F, StoreCoordinates>,
                (Part::Momenta, false) => run::<P, F, StoreMomenta>,
                (Part::All, true) => run::<P, F, AdvanceAll>,
                (Part::Coordinates, true) => run::<P, F, AdvanceCoordinates>,
                (Part::Momenta, true) => run::<P, F, AdvanceMomenta>,
            }
        };
        // SAFETY: the caller promises the same.
        unsafe { run(self, isa, call) }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe { tangent::rows(self, call) }
    }

    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64> {
        if !F::ENERGY {
            return None;
        }
        // SAFETY: the caller promises the slots.
        let slots = unsafe { Slots::copied(&call.slots, count::<F>(), constants::<F>(), call.uniform) };
        let law = self.kernel::<P>();
        let energy = (0..call.rows).map(|row| {
            // SAFETY: the caller promises the rows.
            let source = Within::<_, F>::new(unsafe { Rows::<P>::new(&slots, row) });
            law.energy(<F::Kernel<P> as Declared<P>>::load(&source)).to_f64()
        });
        Some(energy.sum())
    }

    #[cfg(feature = "modules")]
    fn entry(&self) -> Option<super::RowFunction> {
        super::entry::row_function::<P, F>()
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, there: u64) -> Option<Trace> {
        Some(super::gpu::row(self, there))
    }
}

/// How many slots there are.
const fn count<F: RowFamily>() -> usize {
    const { slot_count(F::SIGNATURE.ports) }
}

/// The slots of constants of the scene, one bit each.
const fn constants<F: RowFamily>() -> u64 {
    const { slots_at(F::SIGNATURE.ports, Place::Scene) }
}

/// The slots of fields, one bit each.
const fn fields<F: RowFamily>() -> u64 {
    const { slots_at(F::SIGNATURE.ports, Place::Field) }
}

/// Runs the loop that is made for the fields as they are: those that are uniform are loaded before it.
///
/// # Safety
/// As for [`RowKernel::run`].
unsafe fn run<P: Scalar, F: RowFamily, Rule: RateRule>(law: &F, isa: Isa, call: &RowCall<'_, P>) {
    // Decided before the loops are made: a law without fields gets no second ones.
    if const { fields::<F>() != 0 } && call.uniform == fields::<F>() {
        // SAFETY: the caller promises the same.
        return P::with_lanes(isa, unsafe { Task::<P, F, Rule, true>::new(law, call) });
    }
    // SAFETY: the caller promises the same.
    P::with_lanes(isa, unsafe { Task::<P, F, Rule, false>::new(law, call) });
}

/// The work of one call. `UNIFORM`: all fields of the law are.
struct Task<'a, P, F, Rule, const UNIFORM: bool> {
    law: &'a F,
    call: &'a RowCall<'a, P>,
    rule: PhantomData<Rule>,
}

impl<P: Scalar, F: RowFamily, Rule: RateRule, const UNIFORM: bool> Task<'_, P, F, Rule, UNIFORM> {
    /// # Safety
    /// As for [`RowKernel::run`], as long as it lives. Rows that its functions are given are rows of the call.
    unsafe fn new<'a>(law: &'a F, call: &'a RowCall<'a, P>) -> Task<'a, P, F, Rule, UNIFORM> {
        Task { law, call, rule: PhantomData }
    }

    #[inline(always)]
    fn step<R: Lanes<P>>(law: &F::Kernel<R>, slots: &Slots<P>, row: usize, [step, drift]: [R; 2]) {
        Self::part::<R, Rule>(law, slots, row, step);
        if Rule::DRIFT {
            Self::part::<R, AdvanceCoordinates>(law, slots, row, drift);
        }
    }

    #[inline(always)]
    fn part<R: Lanes<P>, Part: RateRule>(law: &F::Kernel<R>, slots: &Slots<P>, row: usize, step: R) {
        // SAFETY: `Task::new` was promised the rows; all loads of a row come before its stores.
        let (rows, sink) = unsafe { (Rows::new(slots, row), RowsMut::<P, R, Part>::new(slots, row, step)) };
        Self::body::<R, Part>(law, rows, sink);
    }

    #[inline(always)]
    fn body<R: Lanes<P>, Part: RateRule>(law: &F::Kernel<R>, rows: impl Source<R>, sink: impl Sink<R>) {
        let source = Within::<_, F>::new(Masked::<_, F, Part, UNIFORM>::new(rows));
        let output = law.row(<F::Kernel<R> as Declared<R>>::load(&source));
        <F::Kernel<R> as Declared<R>>::store(output, &mut Within::<_, F>::new(sink));
    }
}

impl<P: Scalar, F: RowFamily, Rule: RateRule, const UNIFORM: bool> WithLanes<P> for Task<'_, P, F, Rule, UNIFORM> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: `Task::new` was promised the slots.
        let slots = unsafe {
            let fields = if UNIFORM { fields::<F>() } else { 0 };
            Slots::copied(&self.call.slots, count::<F>(), constants::<F>() | fields, self.call.uniform)
        };
        let rows = self.call.rows;
        let steps = [self.call.advance, self.call.drift].map(|step| step.get().unwrap_or_default());
        let mut row = 0;
        let wide = rows - rows % R::WIDTH;
        if R::WIDTH > 1 && wide > 0 {
            let law = self.law.kernel::<R>();
            let steps = steps.map(R::splat);
            let ahead = self.call.ahead;
            // Two sets at a time where a cache line holds two: with one, a short body waits for the loop itself and for
            // the asking ahead, once too often for each line.
            if const { 2 * size_of::<R>() == LINE } {
                let pairs = rows - rows % (2 * R::WIDTH);
                while row != pairs {
                    ahead.iter().for_each(|from| prefetch(from.wrapping_add(row)));
                    Self::step::<R>(&law, &slots, row, steps);
                    Self::step::<R>(&law, &slots, row + R::WIDTH, steps);
                    row += 2 * R::WIDTH;
                }
            }
            while row != wide {
                ahead.iter().for_each(|from| prefetch(from.wrapping_add(row)));
                Self::step::<R>(&law, &slots, row, steps);
                row += R::WIDTH;
            }
        }
        // Lanes that are more than half full are faster than one row after the other, whatever a body takes.
        let left = rows - row;
        if 2 * left > R::WIDTH && R::WIDTH > 1 {
            return Self::step::<R>(&self.law.kernel::<R>(), &slots, row, steps.map(R::splat));
        }
        if 2 * left > <R::Narrow as Lanes<P>>::WIDTH && <R::Narrow as Lanes<P>>::WIDTH > 1 {
            let (law, steps) = (self.law.kernel::<R::Narrow>(), steps.map(<R::Narrow as Lanes<P>>::splat));
            return Self::step::<R::Narrow>(&law, &slots, row, steps);
        }
        let law = self.law.kernel::<P>();
        while row < rows {
            Self::step::<P>(&law, &slots, row, steps);
            row += 1;
        }
    }
}

/// Rows that only load what the wanted rates depend on.
struct Masked<S, F, Rule, const UNIFORM: bool> {
    rows: S,
    marker: PhantomData<(F, Rule)>,
}

impl<S, F: RowFamily, Rule: RateRule, const UNIFORM: bool> Masked<S, F, Rule, UNIFORM> {
    const MASK: u64 = wants(F::SIGNATURE.ports, Rule::PART);

    #[inline(always)]
    fn new(rows: S) -> Self {
        Masked { rows, marker: PhantomData }
    }
}

impl<R, S: Source<R>, F: RowFamily, Rule: RateRule, const UNIFORM: bool> Source<R> for Masked<S, F, Rule, UNIFORM> {
    #[inline(always)]
    fn wants(&self, port: usize) -> bool {
        port >= 64 || Self::MASK >> port & 1 == 1
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        self.rows.has(slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        self.rows.component(slot)
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.rows.constant(slot)
    }
    #[inline(always)]
    fn field(&self, slot: usize) -> R {
        // The number of a uniform field is kept beside those of constants.
        if UNIFORM { self.rows.constant(slot) } else { self.rows.field(slot) }
    }
}
