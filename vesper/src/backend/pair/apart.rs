//! The loop of a pair law that looks at differences of coordinates alone, where states are known beyond their last digit.
//!
//! Row i is told that it is at 0, and row j how far it is from there: `(x_j - x_i) - (r_j - r_i)`, with what rounding added to
//! each coordinate. In a close encounter far from the origin the distance then has all its digits, and not those
//! that the coordinates have left of it. The body is the same; a law says that it takes this by `translation_invariant`, and
//! [`is_invariant`] looks whether it does.
//!
//! Sums are taken in the order of [`super::pair`], so the bits do not depend on the width of the lanes.

use super::sight::{RowOf, Sight, load, share};
use super::{PairCall, Pairs};
use crate::backend::pointers::{Rows, SUMS, Slots, Splat, Sums};
use crate::law::{Mode, PairFamily, Place, Port, Source};
use crate::property::Role;
use crate::real::{Lanes, Scalar};
use core::marker::PhantomData;

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

/// Rows by their differences.
pub(super) struct Apart<'a, P, F> {
    /// By slot, what rounding added to each row's coordinate, or null.
    rests: &'a [*mut P],
    law: PhantomData<F>,
}

impl<P, F> Clone for Apart<'_, P, F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P, F> Copy for Apart<'_, P, F> {}

/// Coordinates of the rows i of the lanes, and what rounding added to them.
#[derive(Clone, Copy)]
pub(super) struct Own<R> {
    places: [R; COORDINATES],
    rests: [R; COORDINATES],
}

impl<'a, P: Scalar, F: PairFamily> Apart<'a, P, F> {
    const MASK: u64 = coordinate_slots(F::SIGNATURE.ports);

    /// # Safety
    /// There is one for each slot; those of coordinates have a number for every row, with room behind the last one.
    pub(super) unsafe fn new(rests: &'a [*mut P]) -> Self {
        Apart { rests, law: PhantomData }
    }
}

impl<P: Scalar, F: PairFamily> Sight<P, F> for Apart<'_, P, F> {
    type Own<R: Lanes<P>> = (RowOf<F, R>, Own<R>);
    #[inline(always)]
    unsafe fn own<R: Lanes<P>>(self, slots: &Slots<P>, i: usize) -> Self::Own<R> {
        // SAFETY: the caller promises the rows.
        let rows = unsafe { Rows::<P>::new(slots, i) };
        let mut own = Own { places: [R::lit(0.0); COORDINATES], rests: [R::lit(0.0); COORDINATES] };
        for (slot, rest) in self.rests[..Pairs::<P, F>::COUNT].iter().enumerate() {
            if Self::MASK >> slot & 1 == 1 {
                let coordinate = number(Self::MASK, slot);
                own.places[coordinate] = rows.component(slot);
                // SAFETY: as above; coordinates have rests.
                own.rests[coordinate] = unsafe { R::load(rest.add(i)) };
            }
        }
        (load::<F, R>(AtZero { rows, mask: Self::MASK }), own)
    }
    #[inline(always)]
    unsafe fn share<R: Lanes<P>, const N: usize>(
        self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        (row, own): &Self::Own<R>,
        j: usize,
    ) -> Sums<R, N> {
        // SAFETY: the caller promises the row.
        let seen = Seen { row: unsafe { Splat::new(slots, j) }, mask: Self::MASK, own, rests: self.rests, j };
        share::<F, R, N>(law, *row, load::<F, R>(seen))
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
    let (slots, apart) = unsafe { (Pairs::<P, F>::slots(call.slots), Apart::<P, F>::new(call.rests)) };
    let law = law.kernel::<P>();
    let rows = call.others.end.min(LOOKED_AT);
    let mut pairs = (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))).filter(|(i, j)| i != j);
    pairs.all(|(i, j)| {
        // SAFETY: passed on to the caller; the same for all blocks here.
        let [seen, (_, other)] = unsafe { [apart.own::<P>(&slots, i), apart.own::<P>(&slots, j)] };
        let own = seen.1;
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
            // SAFETY: see above.
            let rows = unsafe { Rows::<P>::new(&slots, row) };
            load::<F, P>(Moved { rows, mask: Apart::<P, F>::MASK, by: distance })
        };
        let expected = share::<F, P, SUMS>(&law, moved(i), moved(j));
        // SAFETY: see above.
        let found = unsafe { apart.share::<P, SUMS>(&law, &slots, &seen, j) };
        let [found, expected] = [found, expected].map(|share| share.values.map(Scalar::to_f64));
        super::agree(&found, &expected, allowed)
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
