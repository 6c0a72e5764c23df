//! The loops of a pair law that ends at a distance: over all pairs, and over lists of neighbours.
//!
//! In: a call, with the square of that distance; lists. Out: sums in columns. Never: lists themselves, or when they are made.
//!
//! A share counts where the square of the distance is less than that of the cut-off; else an exact zero is added in its place. So
//! sums have the same bits from lists of any age, and without a periodic box from all pairs, too ([`crate::backend::near`]).

use super::each::{TILE, Tiles};
use super::sight::{RowOf, Sight, load, share};
use super::{PairCall, Pairs};
use crate::backend::near::{Cluster, Lists};
use crate::backend::pointers::{Rows, Slots, Splat, Sums};
use crate::law::{Mode, PairFamily, PairLaw, Place, Port, Source};
use crate::property::{Kind, PeriodicBox, Property, Role};
use crate::real::{Lanes, MAX_WIDTH, Real, Scalar, WithLanes};
use core::ops::Range;

/// The first slot of the one coordinate of rows that a law reads: a vector, which is always there.
pub(crate) const fn distance_slot(ports: &[Port]) -> Option<usize> {
    let (mut port, mut slot, mut found, mut count) = (0, 0, 0, 0);
    while port < ports.len() {
        let property = &ports[port].property;
        let coordinate = matches!(property.role, Role::Coordinate) && matches!(property.kind, Kind::Vector);
        let own = matches!(ports[port].mode, Mode::Reads) && matches!(ports[port].place, Place::Own);
        if coordinate && own && !ports[port].optional {
            found = slot;
            count += 1;
        }
        slot += property.kind.width();
        port += 1;
    }
    if count == 1 { Some(found) } else { None }
}

/// The first slot of the lengths of a periodic box.
pub(crate) fn box_slot(ports: &[Port]) -> Option<usize> {
    let port = ports.iter().position(|port| port.place == Place::Scene && port.property == PeriodicBox::INFO)?;
    Some(ports[..port].iter().map(|port| port.property.kind.width()).sum())
}

/// Rows within the cut-off.
#[derive(Clone, Copy)]
pub(super) struct Near<P> {
    square: P,
}

impl<P: Scalar> Near<P> {
    /// For the call of a law with a cut-off.
    pub(super) fn new(call: &PairCall<'_, P>) -> Self {
        Near { square: call.square }
    }

    #[inline(always)]
    fn seen<F: PairFamily, R: Lanes<P>, const N: usize>(
        self,
        law: &F::Kernel<R>,
        (row_i, place_i): &(RowOf<F, R>, [R; 3]),
        (row_j, place_j): (RowOf<F, R>, [R; 3]),
    ) -> Sums<R, N> {
        let [x, y, z] = [place_j[0] - place_i[0], place_j[1] - place_i[1], place_j[2] - place_i[2]];
        let near = (x * x + y * y + z * z).less(R::splat(self.square));
        let mut share = share::<F, R, N>(law, *row_i, row_j);
        for number in &mut share.values[..Pairs::<P, F>::ADDED] {
            *number = R::select(near, *number, R::lit(0.0));
        }
        share
    }
}

/// A row, and where it is.
#[inline(always)]
fn placed<F: PairFamily, R: Real>(source: impl Source<R>) -> (RowOf<F, R>, [R; 3]) {
    let slot = const { distance_slot(F::SIGNATURE.ports) }.unwrap_or_default();
    let place = [source.component(slot), source.component(slot + 1), source.component(slot + 2)];
    (load::<F, R>(source), place)
}

impl<P: Scalar, F: PairFamily> Sight<P, F> for Near<P> {
    type Own<R: Lanes<P>> = (RowOf<F, R>, [R; 3]);
    #[inline(always)]
    unsafe fn own<R: Lanes<P>>(self, slots: &Slots<P>, i: usize) -> Self::Own<R> {
        // SAFETY: the caller promises the rows.
        placed::<F, R>(unsafe { Rows::<P>::new(slots, i) })
    }
    #[inline(always)]
    unsafe fn share<R: Lanes<P>, const N: usize>(
        self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &Self::Own<R>,
        j: usize,
    ) -> Sums<R, N> {
        // SAFETY: the caller promises the row.
        self.seen::<F, R, N>(law, own, placed::<F, R>(unsafe { Splat::<P>::new(slots, j) }))
    }
}

/// Some entries, one in each lane.
struct Gathered<'a, P> {
    slots: &'a Slots<P>,
    entries: [u32; MAX_WIDTH],
}

impl<P: Scalar, R: Lanes<P>> Source<R> for Gathered<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        self.slots.is_there(slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        // SAFETY: `Listed::new` was promised a number for each entry.
        R::from_lanes(|lane| unsafe { self.slots.number(slot, self.entries[lane] as usize) })
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        R::splat(self.slots.constant(slot))
    }
}

/// The work of some clusters.
pub(super) struct Listed<'a, P: Scalar, F, const N: usize> {
    law: &'a F,
    call: &'a PairCall<'a, P>,
    lists: &'a Lists<P>,
    clusters: Range<usize>,
    /// The row of the first cluster to begin with.
    start: usize,
    sight: Near<P>,
}

impl<'a, P: Scalar, F: PairFamily, const N: usize> Listed<'a, P, F, N> {
    /// # Safety
    /// As for [`super::PairKernel::run_listed`], as long as it lives.
    pub(super) unsafe fn new(
        law: &'a F,
        call: &'a PairCall<'a, P>,
        lists: &'a Lists<P>,
        (clusters, start): (Range<usize>, usize),
    ) -> Self {
        Listed { law, call, lists, clusters, start, sight: Near::new(call) }
    }

    /// What others do to rows of a cluster from its row `first` on; false where an estimate has no number to give.
    #[inline(always)]
    fn rows<R: Lanes<P>>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        cluster: &Cluster<'_>,
        first: usize,
        count: usize,
    ) -> bool {
        let mut entries = [cluster.list[cluster.own[first] as usize]; MAX_WIDTH];
        for (lane, entry) in entries[..count].iter_mut().enumerate() {
            *entry = cluster.list[cluster.own[first + lane] as usize];
        }
        let own = placed::<F, R>(Gathered { slots, entries });
        let mut sums = Tiled::<R, N> {
            sums: Sums::zero(Pairs::<P, F>::FIRST),
            tiles: Tiles::zero(),
            // Entries of images have other numbers in lists of another age.
            end: if self.lists.is_plain() { 0 } else { u32::MAX },
        };
        let mut at = 0;
        for lane in 0..count {
            let itself = cluster.own[first + lane] as usize;
            self.others(law, slots, &own, &mut sums, &cluster.list[at..itself]);
            sums.reach(cluster.list[itself], Pairs::<P, F>::ADDED);
            let mask = R::from_lanes(|lane| P::from_f64(lane as f64)).equal(R::lit(lane as f64));
            // SAFETY: `new` was promised the entries.
            let share =
                unsafe { Sight::<P, F>::share::<R, N>(self.sight, law, slots, &own, cluster.list[itself] as usize) };
            sums.sums.take_but(mask, &share, Pairs::<P, F>::ADDED);
            at = itself + 1;
        }
        self.others(law, slots, &own, &mut sums, &cluster.list[at..]);
        let sums = sums.all(Pairs::<P, F>::ADDED);
        if R::ESTIMATES && !sums.are_finite::<P>(Pairs::<P, F>::ADDED, count) {
            return false;
        }
        for (k, sum) in sums.values[..Pairs::<P, F>::ADDED].iter().enumerate() {
            for lane in 0..count {
                let row = cluster.rows[first + lane] as usize;
                // SAFETY: `new` was promised the rows.
                unsafe { slots.give(Pairs::<P, F>::FIRST + k, row, sum.lane(lane), self.call.first) };
            }
        }
        true
    }

    #[inline(always)]
    fn others<R: Lanes<P>>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &(RowOf<F, R>, [R; 3]),
        sums: &mut Tiled<R, N>,
        mut list: &[u32],
    ) {
        while let Some(first) = list.first() {
            sums.reach(*first, Pairs::<P, F>::ADDED);
            let end = sums.end;
            let count = if end == u32::MAX { list.len() } else { list.partition_point(|entry| *entry < end) };
            let (tile, rest) = list.split_at(count);
            for entry in tile {
                // SAFETY: `new` was promised the entries.
                let share = unsafe { Sight::<P, F>::share::<R, N>(self.sight, law, slots, own, *entry as usize) };
                sums.sums.take(&share, Pairs::<P, F>::ADDED);
            }
            list = rest;
        }
    }
}

/// Sums in the tiles of [`super::each`], so that they have its bits.
struct Tiled<R, const N: usize> {
    sums: Sums<R, N>,
    tiles: Tiles<R, N>,
    /// The first row of the next tile.
    end: u32,
}

impl<R: Real, const N: usize> Tiled<R, N> {
    /// Ends the tile before that of a row.
    #[inline(always)]
    fn reach(&mut self, row: u32, count: usize) {
        if row >= self.end && self.end < u32::MAX {
            self.tiles.take(&self.sums, count);
            self.sums.values = [R::lit(0.0); N];
            self.end = (row / TILE as u32 + 1).saturating_mul(TILE as u32);
        }
    }

    #[inline(always)]
    fn all(mut self, count: usize) -> Sums<R, N> {
        self.tiles.take(&self.sums, count);
        self.tiles.sum(&mut self.sums, count);
        self.sums
    }
}

impl<P: Scalar, F: PairFamily, const N: usize> WithLanes<P> for Listed<'_, P, F, N> {
    /// The cluster, and its row, from which on estimates gave no numbers, where the work ended.
    type Output = Option<(usize, usize)>;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> Option<(usize, usize)> {
        // SAFETY: `new` was promised the slots.
        let slots = unsafe { Pairs::<P, F>::slots(self.call.slots) };
        let law = self.law.kernel::<R>();
        for number in self.clusters.clone() {
            let cluster = self.lists.cluster(number);
            let mut first = if number == self.clusters.start { self.start } else { 0 };
            while first < cluster.own.len() {
                let count = R::WIDTH.min(cluster.own.len() - first);
                if !self.rows::<R>(&law, &slots, &cluster, first, count) {
                    return Some((number, first));
                }
                first += count;
            }
            if cluster.own.is_empty() && self.call.first {
                for row in cluster.rows {
                    for k in 0..Pairs::<P, F>::ADDED {
                        // SAFETY: `new` was promised the rows.
                        unsafe { slots.give(Pairs::<P, F>::FIRST + k, *row as usize, P::default(), true) };
                    }
                }
            }
        }
        None
    }
}

/// The energy of all pairs within the cut-off, by lists.
///
/// # Safety
/// As for [`super::PairKernel::run_listed`].
pub(super) unsafe fn energy<P: Scalar, F: PairFamily>(law: &F, call: &PairCall<'_, P>, lists: &Lists<P>) -> f64 {
    // SAFETY: passed on to the caller.
    let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
    let law = law.kernel::<P>();
    // SAFETY: passed on to the caller.
    let row = |entry: u32| placed::<F, P>(unsafe { Rows::<P>::new(&slots, entry as usize) });
    let mut energy = 0.0;
    for cluster in (0..lists.clusters()).map(|number| lists.cluster(number)) {
        for own in cluster.own {
            let itself = cluster.list[*own as usize];
            let (row_i, place_i) = row(itself);
            for entry in cluster.list.iter().filter(|entry| **entry != itself) {
                let (row_j, place_j) = row(*entry);
                if is_near(place_i, place_j, call.square) {
                    // Each pair is met from both sides.
                    energy += 0.5 * PairLaw::<P>::energy(&law, row_i, row_j).to_f64();
                }
            }
        }
    }
    energy
}

/// Whether two places are within a distance of which this is the square.
pub(super) fn is_near<P: Scalar>(a: [P; 3], b: [P; 3], square: P) -> bool {
    let [x, y, z] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    (x * x + y * y + z * z) < square
}

/// The energy of all pairs of few rows within the cut-off.
///
/// # Safety
/// As for [`super::PairKernel::run`].
pub(super) unsafe fn energy_of_all<P: Scalar, F: PairFamily>(law: &F, call: &PairCall<'_, P>) -> f64 {
    // SAFETY: passed on to the caller.
    let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
    let law = law.kernel::<P>();
    // SAFETY: passed on to the caller.
    let row = |row: usize| placed::<F, P>(unsafe { Rows::<P>::new(&slots, row) });
    let mut energy = 0.0;
    for i in call.rows.clone() {
        let (row_i, place_i) = row(i);
        for (row_j, _) in (i + 1..call.others.end).map(row).filter(|(_, place)| is_near(place_i, *place, call.square)) {
            energy += PairLaw::<P>::energy(&law, row_i, row_j).to_f64();
        }
    }
    energy
}

/// Shifts by which a row comes within a cut-off of another one in a periodic box, for the difference of the two: whole numbers of
/// lengths. In an open box that is no shift, where they are as near.
pub(crate) fn images(apart: [f64; 3], lengths: [f64; 3], cutoff: f64) -> Vec<[f64; 3]> {
    let shifts = |side: usize| {
        let length = lengths[side];
        if !(length > 0.0 && length.is_finite()) {
            return vec![0.0];
        }
        let nearest = -(apart[side] / length).round();
        // Those within reach are at most so many boxes from the nearest one.
        let more = (cutoff / length + 0.5).floor().min(64.0) as i32;
        (-more..=more).map(|more| (nearest + f64::from(more)) * length).collect()
    };
    let [along_x, along_y, along_z] = [0, 1, 2].map(shifts);
    let mut found = Vec::new();
    for x in along_x {
        for y in &along_y {
            for z in &along_z {
                let shift = [x, *y, *z];
                let square: f64 = shift.iter().zip(apart).map(|(shift, apart)| (shift + apart).powi(2)).sum();
                if square < cutoff * cutoff {
                    found.push(shift);
                }
            }
        }
    }
    found
}

/// Rows that are looked at.
const LOOKED_AT: usize = 4;
/// Roundings that two results may differ by.
const ROUNDINGS: f64 = 1e3;

/// Whether pairs of the first rows give what the law's form of inverse squares says.
///
/// # Safety
/// As for [`super::PairKernel::run`].
pub(super) unsafe fn is_as_inverse_square<P: Scalar, F: PairFamily>(law: &F, call: &PairCall<'_, P>) -> bool {
    // SAFETY: passed on to the caller.
    let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
    let law = law.kernel::<P>();
    let rows = call.others.end.min(LOOKED_AT);
    // SAFETY: as above.
    let row = |row: usize| placed::<F, P>(unsafe { Rows::<P>::new(&slots, row) });
    let mut pairs = (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j))).filter(|(i, j)| i != j);
    pairs.all(|(i, j)| {
        let ((row_i, at_i), (row_j, at_j)) = (row(i), row(j));
        let (of_i, of_j) = (law.inverse_square(row_i), law.inverse_square(row_j));
        let apart = [0, 1, 2].map(|side| at_j[side] - at_i[side]);
        let square = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2] + of_i.softening * of_i.softening;
        let weight = (of_i.response * of_j.source).over_root_cubed(square);
        let expected = apart.map(|apart| (apart * weight).to_f64());
        let found = share::<F, P, 12>(&law, row_i, row_j).values.map(Scalar::to_f64);
        super::agree(&found[..3], &expected, ROUNDINGS * P::EPSILON)
    })
}
