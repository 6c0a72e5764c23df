//! The loop of a pair law that looks at differences of coordinates alone, where states are known beyond their last digit.
//!
//! Row i is told that it is at 0, and row j how far it is from there: `(x_j - x_i) - (r_j - r_i)`, with what rounding added to
//! each coordinate. In a close encounter far from the origin the distance then has all its digits, and not those
//! that the coordinates have left of it. The body is the same; a law says that it takes this by `translation_invariant`, and
//! [`is_invariant`] looks whether it does.
//!
//! Sums are taken in the order of [`super::pair`], so the bits do not depend on the width of the lanes.

use super::pair::{PairCall, Task};
use super::pointers::{Rows, Slots, Splat, Sums};
use super::within::Within;
use crate::law::{Declared, Mode, PairFamily, PairLaw, Place, Port, Source};
use crate::property::Role;
use crate::real::{Lanes, Scalar, WithLanes};
use core::ops::Range;

/// Components of coordinates that one law may look at.
const COORDINATES: usize = 12;

/// The slots of coordinates of rows, one bit each.
pub(crate) const fn coordinate_slots(ports: &[Port]) -> u64 {
    let (mut port, mut slot, mut mask) = (0, 0, 0_u64);
    while port < ports.len() {
        let next = slot + ports[port].property.kind.width();
        let looks = matches!(ports[port].mode, Mode::Reads) && matches!(ports[port].place, Place::Own);
        while slot < next {
            if looks && matches!(ports[port].property.role, Role::Coordinate) && slot < 64 {
                mask |= 1 << slot;
            }
            slot += 1;
        }
        port += 1;
    }
    if mask.count_ones() as usize > COORDINATES { 0 } else { mask }
}

/// The number of a slot among those of coordinates.
#[inline(always)]
const fn number(mask: u64, slot: usize) -> usize {
    (mask & ((1 << slot) - 1)).count_ones() as usize
}

/// The same as [`Task`], with differences.
pub(super) struct Apart<'a, P, F>(pub(super) Task<'a, P, F>);

/// Coordinates of the rows i of the lanes, and what rounding added to them.
#[derive(Clone, Copy)]
struct Own<R> {
    places: [R; COORDINATES],
    rests: [R; COORDINATES],
}

impl<P: Scalar, F: PairFamily> Apart<'_, P, F> {
    const MASK: u64 = coordinate_slots(F::SIGNATURE.ports);

    #[inline(always)]
    fn own<R: Lanes<P>>(&self, slots: &Slots<P>, i: usize) -> (RowOf<F, R>, Own<R>) {
        // SAFETY: `Task::new` was promised the rows; the same for all blocks here.
        let rows = unsafe { Rows::<P>::new(slots, i) };
        let mut own = Own { places: [R::lit(0.0); COORDINATES], rests: [R::lit(0.0); COORDINATES] };
        for (slot, rest) in self.0.call.rests[..Task::<P, F>::COUNT].iter().enumerate() {
            if Self::MASK >> slot & 1 == 1 {
                let coordinate = number(Self::MASK, slot);
                own.places[coordinate] = rows.component(slot);
                // SAFETY: as above; coordinates have rests.
                own.rests[coordinate] = unsafe { R::load(rest.add(i)) };
            }
        }
        let source = Within::<_, F>::new(AtZero { rows, mask: Self::MASK });
        (<F::Kernel<R> as Declared<R>>::load(&source), own)
    }

    /// What row j does to the rows of the lanes.
    #[inline(always)]
    fn share<R: Lanes<P>>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        (row_i, own): (RowOf<F, R>, &Own<R>),
        j: usize,
    ) -> Sums<R> {
        // SAFETY: see above.
        let row = unsafe { Splat::new(slots, j) };
        let source = Seen { row, mask: Self::MASK, own, rests: self.0.call.rests, j };
        let row_j = <F::Kernel<R> as Declared<R>>::load(&Within::<_, F>::new(source));
        let mut share = Sums::nothing(Task::<P, F>::FIRST);
        <F::Kernel<R> as Declared<R>>::store(law.pair(row_i, row_j), &mut share);
        share
    }

    #[inline(always)]
    fn others<R: Lanes<P>>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        row_i: (RowOf<F, R>, &Own<R>),
        sums: &mut Sums<R>,
        others: Range<usize>,
    ) {
        for j in others {
            sums.take(&self.share(law, slots, row_i, j), Task::<P, F>::ADDED);
        }
    }

    /// What all other rows do to `count` rows, at most as many as there are lanes.
    #[inline(always)]
    fn block<R: Lanes<P>>(&self, law: &F::Kernel<R>, slots: &Slots<P>, i: usize, count: usize) {
        let (row_i, own) = self.own::<R>(slots, i);
        let mut sums = Sums::zero(Task::<P, F>::FIRST);
        self.others(law, slots, (row_i, &own), &mut sums, 0..i);
        // How far the row of each lane is behind row j: in one lane i is j, and that lane's sum stays as it is.
        let mut behind = R::from_lanes(|lane| P::from_f64(lane as f64));
        for j in i..i + count {
            let itself = behind.equal(R::lit(0.0));
            behind -= R::lit(1.0);
            sums.take_but(itself, &self.share(law, slots, (row_i, &own), j), Task::<P, F>::ADDED);
        }
        self.others(law, slots, (row_i, &own), &mut sums, i + count..self.0.call.rows);
        self.0.give(slots, i, &sums);
    }
}

type RowOf<F, R> = <<F as PairFamily>::Kernel<R> as Declared<R>>::Row;

impl<P: Scalar, F: PairFamily> WithLanes<P> for Apart<'_, P, F> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: `Task::new` was promised the slots.
        let slots = unsafe { Task::<P, F>::slots(self.0.call) };
        let (mut i, to) = (self.0.call.from, self.0.call.to);
        let law = self.0.law.kernel::<R>();
        while to - i > <R::Narrow as Lanes<P>>::WIDTH || R::WIDTH == 1 && i < to {
            let count = R::WIDTH.min(to - i);
            self.block::<R>(&law, &slots, i, count);
            i += count;
        }
        // Behind one row alone there is no room for more.
        if to - i > 1 {
            self.block::<R::Narrow>(&self.0.law.kernel::<R::Narrow>(), &slots, i, to - i);
        } else if i < to {
            self.block::<P>(&self.0.law.kernel::<P>(), &slots, i, 1);
        }
    }
}

/// How far rows are moved alike to see whether a law notices, in units of their distance: in no direction that it could favour.
const ALIKE: [f64; 5] = [1.0, 0.75, -0.625, 0.875, -1.25];
/// Roundings of a place, in parts of the distance, that a result may differ by; where they leave no digit, nothing is looked at.
const ROUNDINGS: f64 = 1e3;
/// Rows that are looked at.
const LOOKED_AT: usize = 4;

/// Whether what the first rows do to each other is the same by their differences, and where both are moved alike.
///
/// # Safety
/// As for [`super::PairKernel::run`]; the call has rests.
pub(super) unsafe fn is_invariant<P: Scalar, F: PairFamily>(law: &F, call: &PairCall<'_, P>) -> bool {
    // SAFETY: passed on to the caller.
    let (slots, apart) = unsafe { (Task::<P, F>::slots(call), Apart(Task::new(law, call))) };
    let law = law.kernel::<P>();
    let rows = call.rows.min(LOOKED_AT);
    let mut pairs = (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))).filter(|(i, j)| i != j);
    pairs.all(|(i, j)| {
        let (row, own) = apart.own::<P>(&slots, i);
        let (_, other) = apart.own::<P>(&slots, j);
        let largest = |numbers: &mut dyn Iterator<Item = P>| {
            numbers.fold(0.0, |most, number| f64::max(most, number.to_f64().abs()))
        };
        let distance = largest(&mut own.places.iter().zip(other.places).map(|(own, other)| other - *own));
        let far = largest(&mut own.places.into_iter().chain(other.places)) + 2.0 * distance;
        let allowed = ROUNDINGS * P::EPSILON * far / distance;
        // Rows at one place, too.
        if allowed.is_nan() || allowed > 0.1 {
            return true;
        }
        let moved = |row: usize| {
            // SAFETY: passed on to the caller.
            let rows = unsafe { Rows::<P>::new(&slots, row) };
            let source = Moved { rows, mask: Apart::<P, F>::MASK, by: distance };
            <F::Kernel<P> as Declared<P>>::load(&Within::<_, F>::new(source))
        };
        let mut expected = Sums::<P>::nothing(Task::<P, F>::FIRST);
        <F::Kernel<P> as Declared<P>>::store(law.pair(moved(i), moved(j)), &mut expected);
        let found = apart.share(&law, &slots, (row, &own), j);
        let [found, expected] = [found, expected].map(|share| share.values.map(Scalar::to_f64));
        let most = found.iter().chain(&expected).fold(0.0, |most, number| f64::max(most, number.abs()));
        let same = |(a, b): (&f64, &f64)| {
            a == b || most.is_finite() && (a - b).abs() <= allowed * most || a.is_nan() && b.is_nan()
        };
        found.iter().zip(&expected).all(same)
    })
}

/// One row, moved.
struct Moved<S> {
    rows: S,
    mask: u64,
    by: f64,
}

impl<P: Scalar> Source<P> for Moved<Rows<'_, P>> {
    fn wants(&self, _port: usize) -> bool {
        true
    }
    fn has(&self, slot: usize) -> bool {
        Source::<P>::has(&self.rows, slot)
    }
    fn component(&self, slot: usize) -> P {
        let place: P = self.rows.component(slot);
        let alike = ALIKE[number(self.mask, slot) % ALIKE.len()];
        if self.mask >> slot & 1 == 1 { place + P::from_f64(self.by * alike) } else { place }
    }
    fn constant(&self, slot: usize) -> P {
        self.rows.constant(slot)
    }
}

/// Rows whose coordinates are 0.
struct AtZero<S> {
    rows: S,
    mask: u64,
}

impl<P: Scalar, R: Lanes<P>> Source<R> for AtZero<Rows<'_, P>> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        Source::<R>::has(&self.rows, slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        if self.mask >> slot & 1 == 1 { R::lit(0.0) } else { self.rows.component(slot) }
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.rows.constant(slot)
    }
}

/// One row, the same in every lane, whose coordinates are told from those of other rows.
struct Seen<'a, P, R> {
    row: Splat<'a, P>,
    mask: u64,
    own: &'a Own<R>,
    rests: &'a [*mut P],
    j: usize,
}

impl<P: Scalar, R: Lanes<P>> Source<R> for Seen<'_, P, R> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        Source::<R>::has(&self.row, slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        let value: R = self.row.component(slot);
        if self.mask >> slot & 1 == 0 {
            return value;
        }
        let coordinate = number(self.mask, slot);
        // SAFETY: coordinates have rests, of all rows.
        let rest = unsafe { R::splat(*self.rests[slot].add(self.j)) };
        (value - self.own.places[coordinate]) - (rest - self.own.rests[coordinate])
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.row.constant(slot)
    }
}
