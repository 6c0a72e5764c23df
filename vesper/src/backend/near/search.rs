//! Who is near whom: one list for each cluster.
//!
//! In: clusters with boxes around them, and the entries of their rows. Out: for each cluster, the entries that are within
//! reach of any of its rows, ascending. Never: where rows are now; a sum.
//!
//! Distances may be measured in less precision than rows have: then all is listed that could be within reach.
//!
//! A cluster looks down the levels of boxes for clusters whose box is near enough to its own, and then measures the distance
//! of each of their rows from each of its own. Candidates stand in lanes, so that one comparison is for as many of them.

use super::images::{Entries, seen_from};
use super::tree::{Around, FAN, Level};
use crate::real::{Lanes, MAX_WIDTH, Scalar, WithLanes};
use core::ops::Range;
use core::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Clusters whose lists lie together: what a thread takes at a time.
pub(super) const TOGETHER: usize = 32;

/// The lists of some clusters, one after the other.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) entries: Vec<u32>,
    /// By cluster, where its list ends.
    pub(super) ends: Vec<usize>,
    /// By row of the clusters, where in its cluster's list its own entry stands: ascending.
    pub(super) own: Vec<u32>,
}

/// What all threads read, in the precision that distances are measured in.
pub(super) struct Search<'a, P> {
    /// Where the rows of all clusters are, cluster by cluster; room for a register behind the last.
    pub(super) places: [&'a [P]; 3],
    /// The row of each.
    pub(super) rows: &'a [u32],
    /// The entry of each where it is in the box.
    pub(super) own: &'a [u32],
    pub(super) width: usize,
    pub(super) levels: &'a [Level<P>],
    pub(super) entries: &'a Entries,
    /// After how much everything comes again, or 0.
    pub(super) lengths: [f64; 3],
    /// More than how far rows are listed.
    pub(super) beyond: f64,
    /// The square of how far they are.
    pub(super) square: P,
    /// The lists of parts, each with [`TOGETHER`] clusters.
    pub(super) parts: &'a [Mutex<Part>],
    /// How many entries all lists have, and may have.
    pub(super) total: &'a AtomicU64,
    pub(super) most: u64,
}

/// The lists of some parts.
pub(super) struct SearchParts<'a, P> {
    pub(super) search: &'a Search<'a, P>,
    pub(super) parts: Range<usize>,
}

impl<P: Scalar> WithLanes<P> for SearchParts<'_, P> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let search = self.search;
        let mut scratch = Scratch {
            stack: Vec::new(),
            near: Vec::new(),
            hits: Vec::new(),
            own: [const { Vec::new() }; 3],
            sort: Sort::new(search.entries.count),
            around: search.levels[search.levels.len() - 1].around_all(),
        };
        for number in self.parts {
            let mut part = search.parts[number].lock().unwrap_or_else(PoisonError::into_inner);
            part.entries.clear();
            part.ends.clear();
            part.own.clear();
            let clusters = number * TOGETHER..((number + 1) * TOGETHER).min(search.levels[0].count);
            for cluster in clusters {
                search.cluster::<R>(cluster, &mut scratch);
                let total = scratch.hits.len() as u64;
                if search.total.fetch_add(total, Ordering::Relaxed) + total > search.most {
                    return;
                }
                let start = part.entries.len();
                scratch.sort.ascending(&mut scratch.hits, &mut part.entries);
                let end = part.entries.len();
                for entry in &search.own[search.members(cluster)] {
                    let at = part.entries[start..].partition_point(|listed| listed < entry);
                    part.own.push(at as u32);
                }
                part.ends.push(end);
            }
        }
    }
}

/// Memory of one thread.
struct Scratch<P> {
    /// Boxes to look into: level and number.
    stack: Vec<(usize, usize)>,
    /// Clusters to measure.
    near: Vec<u32>,
    /// What was found.
    hits: Vec<u32>,
    /// The cluster's rows, seen from the image of the box.
    own: [Vec<P>; 3],
    sort: Sort,
    /// The box around all clusters.
    around: Around<P>,
}

impl<P: Scalar> Search<'_, P> {
    /// The numbers of a cluster's rows in the order of all.
    fn members(&self, cluster: usize) -> Range<usize> {
        cluster * self.width..((cluster + 1) * self.width).min(self.rows.len())
    }

    /// Finds all that is near a cluster, in any order.
    #[inline(always)]
    fn cluster<R: Lanes<P>>(&self, cluster: usize, scratch: &mut Scratch<P>) {
        scratch.hits.clear();
        let around = self.levels[0].get(cluster);
        let images: [_; 3] = core::array::from_fn(|side| {
            if self.lengths[side] == 0.0 {
                return 0..=0;
            }
            let all =
                scratch.around.low[side].to_f64() - self.beyond..=scratch.around.high[side].to_f64() + self.beyond;
            // Entries were found for all rows, so that there are not too many for some.
            let places = around.low[side].to_f64()..=around.high[side].to_f64();
            seen_from(places, all, self.lengths[side]).unwrap_or(0..=0)
        });
        for x in images[0].clone() {
            for y in images[1].clone() {
                for z in images[2].clone() {
                    self.image::<R>(cluster, &around, [x, y, z], scratch);
                    if scratch.hits.len() as u64 > self.most {
                        return;
                    }
                }
            }
        }
    }

    /// Finds what is near a cluster among the rows moved by so many boxes: the cluster is moved back instead.
    #[inline(always)]
    fn image<R: Lanes<P>>(&self, cluster: usize, around: &Around<P>, boxes: [i32; 3], scratch: &mut Scratch<P>) {
        let mut seen = *around;
        for side in 0..3 {
            let by = P::from_f64(f64::from(boxes[side]) * self.lengths[side]);
            (seen.low[side], seen.high[side]) = (around.low[side] - by, around.high[side] - by);
            scratch.own[side].clear();
            scratch.own[side].extend(self.places[side][self.members(cluster)].iter().map(|place| *place - by));
        }
        self.boxes::<R>(&seen, scratch);
        let from = scratch.hits.len();
        for near in 0..scratch.near.len() {
            self.measure::<R>(scratch.near[near] as usize, scratch);
        }
        if boxes == [0; 3] {
            scratch.hits[from..].iter_mut().for_each(|hit| *hit = self.own[*hit as usize]);
            return;
        }
        // An image that is near enough was found for the row; one that was not is none.
        let mut to = from;
        for at in from..scratch.hits.len() {
            if let Some(entry) = self.entries.at(self.rows[scratch.hits[at] as usize], boxes) {
                scratch.hits[to] = entry;
                to += 1;
            }
        }
        scratch.hits.truncate(to);
    }

    /// Goes down the levels to the clusters whose box is near enough to a box.
    #[inline(always)]
    fn boxes<R: Lanes<P>>(&self, seen: &Around<P>, scratch: &mut Scratch<P>) {
        scratch.near.clear();
        scratch.stack.clear();
        scratch.stack.push((self.levels.len() - 1, 0));
        while let Some((level, first)) = scratch.stack.pop() {
            let boxes = &self.levels[level];
            let count = FAN.min(boxes.count - first);
            let squares = self.squares::<R>(boxes, first, seen);
            if level > 0 {
                for (number, square) in (first..).zip(&squares[..count]) {
                    if *square <= self.square {
                        scratch.stack.push((level - 1, number * FAN));
                    }
                }
                continue;
            }
            // No branch: nobody could foretell it.
            let mut found = scratch.near.len();
            scratch.near.resize(found + count, 0);
            for (number, square) in (first as u32..).zip(&squares[..count]) {
                scratch.near[found] = number;
                found += usize::from(*square <= self.square);
            }
            scratch.near.truncate(found);
        }
    }

    /// The squares of the distances of sixteen boxes from a box.
    #[inline(always)]
    fn squares<R: Lanes<P>>(&self, boxes: &Level<P>, first: usize, seen: &Around<P>) -> [P; FAN] {
        let mut squares = [P::default(); FAN];
        for lanes in (0..FAN).step_by(R::WIDTH) {
            let mut square = R::lit(0.0);
            for side in 0..3 {
                let low = &boxes.low[side][first + lanes..][..R::WIDTH];
                let high = &boxes.high[side][first + lanes..][..R::WIDTH];
                // SAFETY: both have so many numbers.
                let (low, high) = unsafe { (R::load(low.as_ptr()), R::load(high.as_ptr())) };
                let before = low - R::splat(seen.high[side]);
                let behind = R::splat(seen.low[side]) - high;
                let apart = before.max(behind).max(R::lit(0.0));
                square += apart * apart;
            }
            let squares = &mut squares[lanes..][..R::WIDTH];
            // SAFETY: there is room for so many.
            unsafe { square.store(squares.as_mut_ptr()) };
        }
        squares
    }

    /// Adds those rows of another cluster that are near enough to any of the cluster's own, by their number in the order of all.
    #[inline(always)]
    fn measure<R: Lanes<P>>(&self, other: usize, scratch: &mut Scratch<P>) {
        let members = self.members(other);
        let [own_x, own_y, own_z] = &scratch.own;
        let mut found = scratch.hits.len();
        scratch.hits.resize(found + members.len(), 0);
        for first in members.clone().step_by(R::WIDTH) {
            let [x, y, z] = self.places.map(|places| {
                let places = &places[first..][..R::WIDTH];
                places.as_ptr()
            });
            // SAFETY: each has so many numbers.
            let (x, y, z) = unsafe { (R::load(x), R::load(y), R::load(z)) };
            let mut least = R::lit(f64::INFINITY);
            for ((own_x, own_y), own_z) in own_x.iter().zip(own_y).zip(own_z) {
                let (x, y, z) = (x - R::splat(*own_x), y - R::splat(*own_y), z - R::splat(*own_z));
                least = (x * x + y * y + z * z).min(least);
            }
            let mut squares = [P::default(); MAX_WIDTH];
            // SAFETY: there is room for the widest lanes.
            unsafe { least.store(squares.as_mut_ptr()) };
            let count = R::WIDTH.min(members.end - first);
            for (number, square) in (first as u32..).zip(&squares[..count]) {
                scratch.hits[found] = number;
                found += usize::from(*square <= self.square);
            }
        }
        scratch.hits.truncate(found);
    }
}

/// Puts numbers in order by marks in a map of all: about as fast for a list of a hundred as comparing them three times.
struct Sort {
    /// A bit for each number, and one for each word of those that has any.
    bits: Vec<u64>,
    words: Vec<u64>,
}

impl Sort {
    fn new(count: usize) -> Self {
        let words = count.div_ceil(64);
        Sort { bits: vec![0; words], words: vec![0; words.div_ceil(64)] }
    }

    /// Adds numbers that are all different to a list, ascending.
    fn ascending(&mut self, numbers: &mut [u32], to: &mut Vec<u32>) {
        if self.words.len() > 4 * numbers.len() {
            numbers.sort_unstable();
            to.extend_from_slice(numbers);
            return;
        }
        for number in numbers.iter() {
            let word = *number as usize / 64;
            self.bits[word] |= 1 << (number % 64);
            self.words[word / 64] |= 1 << (word % 64);
        }
        to.reserve(numbers.len());
        for (first, words) in (0_u32..).step_by(64).zip(&mut self.words) {
            while *words != 0 {
                let word = first + words.trailing_zeros();
                *words &= *words - 1;
                let bits = &mut self.bits[word as usize];
                while *bits != 0 {
                    to.push(word * 64 + bits.trailing_zeros());
                    *bits &= *bits - 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_put_numbers_in_order() {
        for (count, step) in [(1, 1), (100, 1), (5000, 37), (300_000, 1234), (100_000_000, 999_983)] {
            let mut sort = Sort::new(count);
            for round in 0..3 {
                let mut numbers: Vec<u32> = (round..count as u32).step_by(step).collect();
                let expected = numbers.clone();
                numbers.reverse();
                let half = numbers.len() / 2;
                numbers.rotate_left(half);
                let mut sorted = Vec::new();
                sort.ascending(&mut numbers, &mut sorted);
                assert_eq!(sorted, expected, "{count}");
            }
        }
    }
}
