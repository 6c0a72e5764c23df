//! Rows in an order in which neighbours in space are neighbours in memory.
//!
//! In: places, and the box that they lie in. Out: the rows sorted along Hilbert's curve: the rows of every cell of an octree are one
//! range, as with the bits of the coordinates in turn (Warren and Salmon 1993, Supercomputing, p. 12), and besides any rows that follow
//! each other lie together, so that groups of them are small. Never: a place outside the range of its array, whatever the coordinates
//! are; a result that depends on anything but the places, such as the order in which rows come.

use super::{Parts, SHARE, Source};
use crate::real::Scalar;

/// Bits of a key for each coordinate: levels of the octree that one key tells apart.
pub(super) const LEVELS: u32 = 10;
/// Values of one digit of the sort.
const DIGITS: usize = 1 << LEVELS;
/// Rows from which on the sort by digits is faster than one by comparison.
const MANY: usize = 600;

/// A key above the number of its row: 32 bits each.
pub(super) type Keyed = u64;

/// The key alone.
#[inline(always)]
pub(super) fn key(keyed: Keyed) -> u32 {
    (keyed >> 32) as u32
}

/// The row alone.
#[inline(always)]
pub(super) fn row(keyed: Keyed) -> usize {
    keyed as u32 as usize
}

/// Ten bits, with two empty ones between every two.
#[inline(always)]
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00FF;
    let bits = (bits | bits << 8) & 0x0300_F00F;
    let bits = (bits | bits << 4) & 0x030C_30C3;
    (bits | bits << 2) & 0x0924_9249
}

/// One level of the curve: from the octant and the curve's state in the cell to the octant's number along the curve, above the state
/// in the octant.
///
/// A state is the corner where the curve enters and the axis along which it leaves: Hamilton and Rau-Chaplin 2008, Inf. Process. Lett.
/// 105, 155, algorithm 2 with sections 2.1 to 2.3.
const CURVE: [[u8; 8]; 24] = {
    let mut curve = [[0; 8]; 24];
    let mut state = 0;
    while state < 24 {
        let (entry, axis) = (state / 3, state % 3);
        let mut octant = 0;
        while octant < 8 {
            let turned = rotated(octant ^ entry, 2 - axis);
            // The inverse of the Gray code.
            let number = turned ^ turned >> 1 ^ turned >> 2;
            let before = if number == 0 { 0 } else { (number - 1) / 2 * 2 };
            let entry = entry ^ rotated(before ^ before >> 1, axis + 1);
            let along = if number == 0 { 0 } else { (number - 1 + number % 2).trailing_ones() as usize };
            curve[state][octant] = (number << 5 | (entry * 3 + (axis + along + 1) % 3)) as u8;
            octant += 1;
        }
        state += 1;
    }
    curve
};

/// Three bits, turned to the left.
const fn rotated(bits: usize, by: usize) -> usize {
    let by = by % 3;
    (bits << by | bits >> (3 - by)) & 7
}

/// From the bits of the coordinates in turn to the number along the curve.
#[inline(always)]
fn along_curve(key: u32) -> u32 {
    let (mut number, mut state) = (0, 0);
    for level in (0..LEVELS).rev() {
        let step = CURVE[state][(key >> (3 * level) & 7) as usize];
        number = number << 3 | u32::from(step >> 5);
        state = usize::from(step & 31);
    }
    number
}

/// A box around rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3<P> {
    pub(super) low: [P; 3],
    pub(super) high: [P; 3],
}

impl<P: Scalar> Box3<P> {
    /// A box of one place.
    #[inline(always)]
    pub(super) fn at(place: [P; 3]) -> Self {
        Box3 { low: place, high: place }
    }

    /// Grows so that the other one is inside.
    #[inline(always)]
    pub(super) fn hold(&mut self, other: Self) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }

    /// Whether it has no extent.
    pub(super) fn is_point(&self) -> bool {
        self.low == self.high
    }

    #[inline(always)]
    pub(super) fn centre(&self) -> [P; 3] {
        let half = P::from_f64(0.5);
        [0, 1, 2].map(|k| (self.low[k] + self.high[k]) * half)
    }
}

/// The box of the rows of a range.
pub(super) fn box_of<P: Scalar>(sources: &[Source<P>], rows: &[Keyed]) -> Box3<P> {
    let place = |keyed: &Keyed| {
        let [x, y, z, _] = sources[row(*keyed)];
        Box3::at([x, y, z])
    };
    let mut found = place(&rows[0]);
    for keyed in rows {
        found.hold(place(keyed));
    }
    found
}

/// Gives the rows of a range the keys of a box, and sorts them; rows of the same key by their origin.
pub(super) fn sort<P: Scalar>(
    sources: &[Source<P>],
    origin: &[u32],
    within: Box3<P>,
    rows: &mut [Keyed],
    scratch: &mut Vec<Keyed>,
    threads: &impl Parts,
) {
    let curve = Curve::within(within);
    let give = |rows: &mut [Keyed]| {
        for keyed in rows {
            *keyed = curve.keyed(sources, row(*keyed));
        }
    };
    if rows.len() < MANY {
        give(rows);
        rows.sort_unstable();
        return by_origin(rows, origin);
    }
    threads.each(rows.chunks_mut(SHARE), |_, rows| give(rows));
    // By the highest digit first. After it the rows of one value are few, near each other, and no concern of other threads; and where
    // the rows come in nearly this order, as those of the tree before do, its writes are in order as well.
    scratch.clear();
    scratch.resize(rows.len(), 0);
    let ends = by_digit(rows, scratch, 2);
    threads.each(shares(&ends, rows, scratch).into_iter(), |_, (ends, rows, from)| {
        let (mut start, first) = (0, ends[0] as usize);
        for end in ends[1..].iter().map(|&end| end as usize - first) {
            let (rows, from) = (&mut rows[start..end], &mut from[start..end]);
            start = end;
            if from.len() < MANY {
                from.sort_unstable();
                rows.copy_from_slice(from);
            } else {
                by_digit(from, rows, 0);
                by_digit(rows, from, 1);
                rows.copy_from_slice(from);
            }
            by_origin(rows, origin);
        }
    });
}

/// What one thread sorts at a time: where each value's rows end, the first number of them being where the first one's begin; where to;
/// and where from.
type Share<'a> = (&'a [u32], &'a mut [Keyed], &'a mut [Keyed]);

/// Divides the rows between values of the highest digit.
fn shares<'a>(ends: &'a [u32; DIGITS + 1], mut rows: &'a mut [Keyed], mut from: &'a mut [Keyed]) -> Vec<Share<'a>> {
    let mut shares = Vec::new();
    let mut first = 0;
    for last in 1..=DIGITS {
        let count = (ends[last] - ends[first]) as usize;
        if count >= SHARE || last == DIGITS {
            let (own, rest) = core::mem::take(&mut rows).split_at_mut(count);
            let (own_from, rest_from) = core::mem::take(&mut from).split_at_mut(count);
            shares.push((&ends[first..=last], own, own_from));
            (rows, from, first) = (rest, rest_from, last);
        }
    }
    shares
}

/// Has rows of the same key stand by their origin, whatever order they came in.
fn by_origin(rows: &mut [Keyed], origin: &[u32]) {
    let of = |keyed: &Keyed| origin[row(*keyed)];
    for same in rows.chunk_by_mut(|a, b| key(*a) == key(*b)) {
        if !same.is_sorted_by_key(of) {
            same.sort_unstable_by_key(of);
        }
    }
}

/// Hilbert's curve through a box.
struct Curve {
    low: [f64; 3],
    /// One for all axes, so that cells are cubes: their expansions then converge alike in all directions.
    scale: f64,
}

impl Curve {
    fn within<P: Scalar>(within: Box3<P>) -> Self {
        let low = within.low.map(Scalar::to_f64);
        let extents = [0, 1, 2].map(|k| within.high[k].to_f64() - low[k]);
        Curve { low, scale: DIGITS as f64 / extents[0].max(extents[1]).max(extents[2]) }
    }

    #[inline(always)]
    fn keyed<P: Scalar>(&self, sources: &[Source<P>], at: usize) -> Keyed {
        let source = &sources[at];
        // A conversion to whole numbers takes NaN to 0 and large numbers to the largest.
        let digit = |k: usize| (((source[k].to_f64() - self.low[k]) * self.scale) as u32).min(DIGITS as u32 - 1);
        let key = spread(digit(0)) << 2 | spread(digit(1)) << 1 | spread(digit(2));
        u64::from(along_curve(key)) << 32 | at as u64
    }
}

/// One pass of a sort by digits; where the rows of each value end, after where the first ones begin.
fn by_digit(from: &[Keyed], to: &mut [Keyed], number: u32) -> [u32; DIGITS + 1] {
    let digit = |keyed: Keyed| (key(keyed) >> (number * LEVELS)) as usize % DIGITS;
    let mut places = [0; DIGITS + 1];
    for &keyed in from {
        places[digit(keyed) + 1] += 1;
    }
    let mut before = 0;
    for place in &mut places[1..] {
        before += core::mem::replace(place, before);
    }
    for &keyed in from {
        let place = &mut places[digit(keyed) + 1];
        to[*place as usize] = keyed;
        *place += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the first 4096 cells of the curve each is next to the one before, and all are different.
    #[test]
    fn the_curve_goes_from_a_cell_to_the_next() {
        let mut cells: Vec<(u32, [i32; 3])> = (0..4096u32)
            .map(|key| {
                let bits = |axis: u32| (0..4).map(|bit| (key >> (3 * bit + 2 - axis) & 1) << bit).sum::<u32>() as i32;
                (along_curve(key), [bits(0), bits(1), bits(2)])
            })
            .collect();
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let steps: i32 = (0..3).map(|k| (pair[0].1[k] - pair[1].1[k]).abs()).sum();
            assert!(steps == 1 && pair[1].0 == pair[0].0 + 1, "{pair:?}");
        }
    }
}
