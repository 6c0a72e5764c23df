//! Rows in memory as a source and a sink: a pointer for every component of every port.

use crate::law::{Mode, Part, Place, Port, Sink, Source};
use crate::real::{Lanes, MAX_WIDTH, Real, Scalar};
use core::marker::PhantomData;

pub(crate) use crate::law::MAX_SLOTS;

/// The ports that the wanted rates depend on, one bit each; all ports for a law without rates.
pub(crate) const fn wants(ports: &[Port], part: Part) -> u64 {
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
pub(crate) struct Slots<P> {
    pointers: [*mut P; MAX_SLOTS],
    /// The numbers of constants and uniform fields: here, too, no store of the loop can change them.
    numbers: [P; MAX_SLOTS],
    /// Slots of fields that are the same in all rows: one set of lanes each. One bit for each slot.
    uniform: u64,
}

/// The row to load where all rows are the same (`uniform` has the bit `slot`): the first one. Computed, since a branch
/// in the loop would keep the compiler from holding sums in registers.
#[inline(always)]
pub(crate) fn row_of(row: usize, uniform: u64, slot: usize) -> usize {
    row & ((uniform >> slot & 1) as usize).wrapping_sub(1)
}

impl<P: Scalar> Slots<P> {
    /// Copies the pointers of a law's `count` slots, and the numbers of those that `numbers` has a bit for. Both are
    /// constants of the law: the copy is then a few moves.
    ///
    /// # Safety
    /// There are `count` slots; those in `numbers` are null, or point to a number.
    #[inline(always)]
    pub(crate) unsafe fn copied(slots: &[*mut P], count: usize, numbers: u64, uniform: u64) -> Self {
        let mut copy =
            Slots { pointers: [core::ptr::null_mut(); MAX_SLOTS], numbers: [P::default(); MAX_SLOTS], uniform };
        for (slot, &pointer) in slots[..count].iter().enumerate() {
            copy.pointers[slot] = pointer;
            if numbers >> slot & 1 == 1 && !pointer.is_null() {
                // SAFETY: passed on to the caller.
                copy.numbers[slot] = unsafe { *pointer };
            }
        }
        copy
    }
}

impl<P: Scalar> Slots<P> {
    /// Whether there are numbers.
    #[inline(always)]
    pub(crate) fn is_there(&self, slot: usize) -> bool {
        !self.pointers[slot].is_null()
    }

    /// The number of a constant.
    #[inline(always)]
    pub(crate) fn constant(&self, slot: usize) -> P {
        self.numbers[slot]
    }

    /// The number of a row.
    ///
    /// # Safety
    /// The slot has one for it.
    #[inline(always)]
    pub(crate) unsafe fn number(&self, slot: usize, row: usize) -> P {
        // SAFETY: passed on to the caller.
        unsafe { *self.pointers[slot].add(row) }
    }

    /// Adds to the number of a row, or begins it.
    ///
    /// # Safety
    /// The slot has one for it, which nobody else touches.
    #[inline(always)]
    pub(crate) unsafe fn give(&self, slot: usize, row: usize, value: P, first: bool) {
        // SAFETY: passed on to the caller.
        unsafe {
            let to = self.pointers[slot].add(row);
            *to = if first { value } else { *to + value };
        }
    }
}

/// Numbers of all ports.
pub(crate) const fn slot_count(ports: &[Port]) -> usize {
    let (mut port, mut slots) = (0, 0);
    while port < ports.len() {
        slots += ports[port].property.kind.width();
        port += 1;
    }
    slots
}

/// The first slot that the law gives something for: outputs follow the inputs.
pub(crate) const fn first_output(ports: &[Port]) -> usize {
    let (mut port, mut slot) = (0, 0);
    while port < ports.len() && ports[port].mode.is_input() {
        slot += ports[port].property.kind.width();
        port += 1;
    }
    slot
}

/// The slots of ports at `place`, one bit each.
pub(crate) const fn slots_at(ports: &[Port], place: Place) -> u64 {
    let (mut port, mut slot, mut mask) = (0, 0, 0_u64);
    while port < ports.len() {
        let next = slot + ports[port].property.kind.width();
        while slot < next {
            if ports[port].place as u8 == place as u8 && slot < 64 {
                mask |= 1 << slot;
            }
            slot += 1;
        }
        port += 1;
    }
    mask
}

/// `R::WIDTH` neighbouring rows from `row` on.
pub(crate) struct Rows<'a, P> {
    slots: &'a Slots<P>,
    row: usize,
}

impl<'a, P: Scalar> Rows<'a, P> {
    /// # Safety
    /// Every slot is null, or points to numbers of rows `row..row + R::WIDTH` of the lanes `R` it is read in, or, for a
    /// constant, to one number, or, for a uniform field, to `MAX_WIDTH` equal ones; they stay valid for `'a`.
    #[inline(always)]
    pub(crate) unsafe fn new(slots: &'a Slots<P>, row: usize) -> Self {
        Rows { slots, row }
    }
}

impl<P: Scalar, R: Lanes<P>> Source<R> for Rows<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots.pointers[slot].is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the rows.
        unsafe { R::load(self.slots.pointers[slot].add(self.row)) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        R::splat(self.slots.numbers[slot])
    }
    #[inline(always)]
    fn field(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the rows.
        unsafe { R::load(self.slots.pointers[slot].add(row_of(self.row, self.slots.uniform, slot))) }
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

impl<P: Scalar, R: Lanes<P>> Source<R> for Splat<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots.pointers[slot].is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `new` was promised the row.
        unsafe { R::splat(*self.slots.pointers[slot].add(self.row)) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        R::splat(self.slots.numbers[slot])
    }
}

/// What becomes of a rate.
pub(crate) trait RateRule {
    /// Which states' rates are wanted.
    const PART: Part;
    /// Whether the state is advanced by the rate at once, instead of the rate being stored.
    const ADVANCE: bool;
    /// Whether sums begin with what is added.
    const FIRST: bool;
    /// Whether the coordinates advance after the momenta.
    const DRIFT: bool;
}

macro_rules! rate_rules {
    ($($name:ident $part:ident $advance:literal $first:literal $drift:literal,)*) => {$(
        pub(crate) struct $name;
        impl RateRule for $name {
            const PART: Part = Part::$part;
            const ADVANCE: bool = $advance;
            const FIRST: bool = $first;
            const DRIFT: bool = $drift;
        }
    )*};
}
rate_rules! {
    StoreAll All false false false, StoreFirst All false true false,
    StoreCoordinates Coordinates false false false, StoreMomenta Momenta false false false,
    AdvanceAll All true false false, AdvanceCoordinates Coordinates true false false,
    AdvanceMomenta Momenta true false false, KickDrift Momenta true false true,
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

impl<P: Scalar, R: Lanes<P>, Rule: RateRule> Sink<R> for RowsMut<'_, P, R, Rule> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        // SAFETY: `new` was promised the rows.
        unsafe { value.store(self.slots.pointers[slot].add(self.row)) };
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        if Rule::FIRST {
            return self.set(slot, value);
        }
        // SAFETY: as above.
        let before = unsafe { R::load(self.slots.pointers[slot].add(self.row)) };
        self.set(slot, before + value);
    }
    #[inline(always)]
    fn turn(&mut self, slot: usize, value: R) {
        // Most runs want none.
        if !self.slots.pointers[slot].is_null() {
            self.add(slot, value);
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

/// What one pair gives, or the sums of many, in registers: room for `N` numbers, since what is never used takes the compiler's time.
#[derive(Clone, Copy)]
pub(crate) struct Sums<R, const N: usize> {
    pub(crate) values: [R; N],
    first: usize,
}

/// Components that one pair law may add to.
pub(crate) const SUMS: usize = 12;

impl<R: Real, const N: usize> Sums<R, N> {
    #[inline(always)]
    pub(crate) fn zero(first: usize) -> Self {
        Sums { values: [R::lit(0.0); N], first }
    }

    /// Adds the first `count` of a share.
    #[inline(always)]
    pub(crate) fn take(&mut self, share: &Sums<R, N>, count: usize) {
        for (sum, share) in self.values[..count].iter_mut().zip(&share.values) {
            *sum += *share;
        }
    }

    /// The same, but for the lanes that are true.
    #[inline(always)]
    pub(crate) fn take_but(&mut self, not: R::Mask, share: &Sums<R, N>, count: usize) {
        for (sum, share) in self.values[..count].iter_mut().zip(&share.values) {
            *sum = R::select(not, *sum, *sum + *share);
        }
    }

    /// Takes the first `count` of a share away.
    #[inline(always)]
    pub(crate) fn lose(&mut self, share: &Sums<R, N>, count: usize) {
        for (sum, share) in self.values[..count].iter_mut().zip(&share.values) {
            *sum -= *share;
        }
    }

    /// The same, but for the lanes that are true.
    #[inline(always)]
    pub(crate) fn lose_but(&mut self, not: R::Mask, share: &Sums<R, N>, count: usize) {
        for (sum, share) in self.values[..count].iter_mut().zip(&share.values) {
            *sum = R::select(not, *sum, *sum - *share);
        }
    }

    /// Whether the first `count` are numbers in the first `lanes` lanes: what is in the others is nobody's.
    #[inline(always)]
    pub(crate) fn are_finite<P: Scalar>(&self, count: usize, lanes: usize) -> bool
    where
        R: Lanes<P>,
    {
        // Zero, but NaN where a number is infinite or NaN.
        let mut nothing = R::lit(0.0);
        for number in &self.values[..count] {
            nothing += *number * R::lit(0.0);
        }
        if lanes >= R::WIDTH {
            return nothing.sum().is_finite();
        }
        let mut numbers = [P::default(); MAX_WIDTH];
        // SAFETY: no lanes are wider than that.
        unsafe { nothing.store(numbers.as_mut_ptr()) };
        let mut lane = 0;
        while lane < lanes && numbers[lane].is_finite() {
            lane += 1;
        }
        lane == lanes
    }

    /// For a share that gives nothing to some: what leaves every number as it is, so that the compiler leaves it out.
    #[inline(always)]
    pub(crate) fn nothing(first: usize) -> Self {
        Sums { values: [R::lit(-0.0); N], first }
    }
}

/// A share is given number by number, each of them once.
impl<R: Real, const N: usize> Sink<R> for Sums<R, N> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        self.values[slot - self.first] = value;
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        self.set(slot, value);
    }
    #[inline(always)]
    fn rate(&mut self, _coordinate: bool, slot: usize, value: R) {
        self.set(slot, value);
    }
}
