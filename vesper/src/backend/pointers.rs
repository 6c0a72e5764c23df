//! Rows in memory as a source and a sink: a pointer for every component of every port.

use crate::law::{Mode, Part, Sink, Source};
use crate::real::{Lanes, Real};
use core::marker::PhantomData;

pub(crate) use crate::law::MAX_SLOTS;

/// The ports that the wanted rates depend on, one bit each; all ports for a law without rates.
pub(crate) const fn wants(ports: &[crate::law::Port], part: Part) -> u64 {
    let mut mask = 0;
    let mut rates = false;
    let mut port = 0;
    while port < ports.len() {
        if matches!(ports[port].mode, Mode::Rates) {
            rates = true;
            if part.holds(&ports[port].property.role) {
                mask |= ports[port].from;
            }
        } else if !ports[port].mode.is_input() {
            // A law that also sets or adds needs everything it reads.
            mask = u64::MAX;
        }
        port += 1;
    }
    if rates { mask } else { u64::MAX }
}

/// Pointers of a law's components, copied where no store of the loop can be thought to change them.
#[derive(Clone, Copy)]
pub(crate) struct Slots<P>([*mut P; MAX_SLOTS]);

impl<P> Slots<P> {
    #[inline(always)]
    pub(crate) fn copied(slots: &[*mut P]) -> Self {
        let mut copy = [core::ptr::null_mut(); MAX_SLOTS];
        let count = slots.len().min(MAX_SLOTS);
        copy[..count].copy_from_slice(&slots[..count]);
        Slots(copy)
    }
}

/// `R::WIDTH` neighbouring rows from `row` on.
pub(crate) struct Rows<'a, P> {
    slots: &'a Slots<P>,
    row: usize,
}

impl<'a, P> Rows<'a, P> {
    /// # Safety
    /// Every slot is null, or points to numbers of rows `row..row + R::WIDTH` of the lanes `R` it is read in, or, for a
    /// constant, to one number; they stay valid for `'a`.
    #[inline(always)]
    pub(crate) unsafe fn new(slots: &'a Slots<P>, row: usize) -> Self {
        Rows { slots, row }
    }
}

impl<P: Copy, R: Lanes<P>> Source<R> for Rows<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots.0[slot].is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the rows.
        unsafe { R::load(self.slots.0[slot].add(self.row)) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the number.
        unsafe { R::splat(*self.slots.0[slot]) }
    }
}

/// One row, the same in every lane.
pub(crate) struct Splat<'a, P> {
    slots: &'a Slots<P>,
    row: usize,
}

impl<'a, P> Splat<'a, P> {
    /// # Safety
    /// Every slot is null, or points to the number of row `row`, or, for a constant, to one number.
    #[inline(always)]
    pub(crate) unsafe fn new(slots: &'a Slots<P>, row: usize) -> Self {
        Splat { slots, row }
    }
}

impl<P: Copy, R: Lanes<P>> Source<R> for Splat<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots.0[slot].is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the row.
        unsafe { R::splat(*self.slots.0[slot].add(self.row)) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the number.
        unsafe { R::splat(*self.slots.0[slot]) }
    }
}

/// What becomes of a rate.
pub(crate) trait RateRule {
    /// Which states' rates are wanted.
    const PART: Part;
    /// Whether the state is advanced by the rate at once, instead of the rate being stored.
    const ADVANCE: bool;
}

macro_rules! rate_rules {
    ($($name:ident $part:ident $advance:literal,)*) => {$(
        pub(crate) struct $name;
        impl RateRule for $name {
            const PART: Part = Part::$part;
            const ADVANCE: bool = $advance;
        }
    )*};
}
rate_rules! {
    StoreAll All false, StoreCoordinates Coordinates false, StoreMomenta Momenta false,
    AdvanceAll All true, AdvanceCoordinates Coordinates true, AdvanceMomenta Momenta true,
}

/// `R::WIDTH` neighbouring rows from `row` on, to write.
pub(crate) struct RowsMut<'a, P, R, Rule> {
    slots: &'a Slots<P>,
    row: usize,
    step: R,
    rule: PhantomData<Rule>,
}

impl<'a, P, R, Rule> RowsMut<'a, P, R, Rule> {
    /// # Safety
    /// As for [`Rows::new`], and every slot that is written points to numbers that nobody else touches.
    #[inline(always)]
    pub(crate) unsafe fn new(slots: &'a Slots<P>, row: usize, step: R) -> Self {
        RowsMut { slots, row, step, rule: PhantomData }
    }
}

impl<P: Copy, R: Lanes<P>, Rule: RateRule> Sink<R> for RowsMut<'_, P, R, Rule> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        // SAFETY: `new` was promised the rows.
        unsafe { value.store(self.slots.0[slot].add(self.row)) }
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        // SAFETY: `new` was promised the rows.
        unsafe {
            let to = self.slots.0[slot].add(self.row);
            (R::load(to) + value).store(to);
        }
    }
    #[inline(always)]
    fn rate(&mut self, coordinate: bool, slot: usize, value: R) {
        let wanted = match Rule::PART {
            Part::All => true,
            Part::Coordinates => coordinate,
            Part::Momenta => !coordinate,
        };
        if wanted && Rule::ADVANCE {
            self.add(slot, value * self.step);
        } else if wanted {
            self.set(slot, value);
        }
    }
}

/// Sums of the results of many pairs, in registers.
pub(crate) struct Sums<R> {
    pub(crate) values: [R; SUMS],
    first: usize,
}

/// Components that one pair law may add to.
pub(crate) const SUMS: usize = 12;

impl<R: Real> Sums<R> {
    #[inline(always)]
    pub(crate) fn zero(first: usize) -> Self {
        Sums { values: [R::lit(0.0); SUMS], first }
    }
}

impl<R: Real> Sink<R> for Sums<R> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        self.values[slot - self.first] = value;
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        self.values[slot - self.first] += value;
    }
    #[inline(always)]
    fn rate(&mut self, _coordinate: bool, slot: usize, value: R) {
        self.set(slot, value);
    }
}
