//! The entries of lists: every row where it is in the box, and again in the boxes beside it, where somebody sees it there.
//!
//! In: rows in the box, how far they are seen, the periods. Out: the number of the entry for a row and an image, and numbers
//! of rows, copied to entries. Never: a list, a decision who is near whom.
//!
//! Entries are numbered by row, then by how many lengths the row is moved in x, then in y, then in z: by the lengths from
//! the row's own coordinates, so that their order does not depend on which box is called the first.

use super::Unfit;
use super::period::Period;
use super::tree::Around;
use crate::real::Scalar;

/// The images of one row.
#[derive(Clone, Copy, Debug)]
struct Images {
    /// The first of its entries.
    first: u32,
    /// The image with the least boxes in each direction.
    low: [i32; 3],
    /// How many there are in each direction, at least one.
    count: [i32; 3],
}

/// The entries of all rows. Without periods, rows are their own entries.
#[derive(Debug, Default)]
pub(super) struct Entries {
    images: Vec<Images>,
    pub(super) count: usize,
}

/// Images of one row in one direction, at most: the product of three, and its sums, are then far from overflowing.
const MOST: f64 = 1e6;

impl Entries {
    /// Finds out which images are within `beyond` of the box around all rows. Rows of NaN have one entry, without a place.
    pub(super) fn find<P: Scalar>(
        &mut self,
        places: [&[P]; 3],
        around: &Around<P>,
        beyond: f64,
        periods: &[Option<Period<P>>; 3],
    ) -> Result<(), Unfit> {
        self.images.clear();
        self.count = places[0].len();
        if periods.iter().all(Option::is_none) {
            return Ok(());
        }
        self.images.reserve(places[0].len());
        let mut next = 0_u64;
        for row in 0..places[0].len() {
            // Checked against the most by the builder of lists, after every row here.
            let first = u32::try_from(next).map_err(|_| Unfit::TooMany)?;
            let mut images = Images { first, low: [0; 3], count: [1; 3] };
            for side in 0..3 {
                let place = places[side][row].to_f64();
                let Some(period) = &periods[side] else { continue };
                if place.is_nan() {
                    continue;
                }
                let seen = seen(place..=place, around, side, beyond, period).ok_or(Unfit::TooMany)?;
                (images.low[side], images.count[side]) = (*seen.start(), seen.end() - seen.start() + 1);
            }
            next += images.count.iter().map(|count| u64::from(count.unsigned_abs())).product::<u64>();
            self.images.push(images);
        }
        u32::try_from(next).map_err(|_| Unfit::TooMany)?;
        self.count = next as usize;
        Ok(())
    }

    /// The entry of a row where it is in the box.
    #[inline(always)]
    pub(super) fn own(&self, row: u32) -> u32 {
        self.at(row, [0; 3]).unwrap_or(row)
    }

    /// The entry of a row, moved by so many boxes; `None` where nobody sees it there.
    #[inline(always)]
    pub(super) fn at(&self, row: u32, boxes: [i32; 3]) -> Option<u32> {
        let Some(Images { first, low, count }) = self.images.get(row as usize) else {
            return (boxes == [0; 3]).then_some(row);
        };
        let mut number = 0;
        for side in 0..3 {
            let place = boxes[side] - low[side];
            if !(0..count[side]).contains(&place) {
                return None;
            }
            number = number * count[side] + place;
        }
        Some(first + number.unsigned_abs())
    }

    /// Copies a number of each row to all its entries.
    pub(super) fn spread<P: Copy>(&self, from: &[P], to: &mut [P]) {
        if self.images.is_empty() {
            return to[..from.len()].copy_from_slice(from);
        }
        let ends = self.images.iter().skip(1).map(|images| images.first as usize).chain([self.count]);
        let mut at = 0;
        for (value, end) in from.iter().zip(ends) {
            to[at] = *value;
            at += 1;
            if at < end {
                to[at..end].fill(*value);
                at = end;
            }
        }
    }

    /// Copies coordinates in the box to all entries, each moved to its image.
    pub(super) fn place<P: Scalar>(&self, from: [&[P]; 3], periods: &[Option<Period<P>>; 3], to: [&mut [P]; 3]) {
        if self.images.is_empty() {
            for (from, to) in from.into_iter().zip(to) {
                to[..from.len()].copy_from_slice(from);
            }
            return;
        }
        let [to_x, to_y, to_z] = to;
        for (row, Images { first, low, count }) in self.images.iter().enumerate() {
            let place = from.map(|numbers| numbers[row]);
            let mut at = *first as usize;
            if *count == [1; 3] {
                (to_x[at], to_y[at], to_z[at]) = (place[0], place[1], place[2]);
                continue;
            }
            let moved = |side: usize, image: i32| match &periods[side] {
                Some(period) => place[side] + period.times(low[side] + image),
                None => place[side],
            };
            for image in 0..count[0] {
                let x = moved(0, image);
                for image in 0..count[1] {
                    let y = moved(1, image);
                    for image in 0..count[2] {
                        (to_x[at], to_y[at], to_z[at]) = (x, y, moved(2, image));
                        at += 1;
                    }
                }
            }
        }
    }
}

/// The boxes that may hold what is seen: where rows of `around`, moved by so many lengths, are no further than `beyond` from
/// `places`. With a little more, so that no rounding here loses a pair; `None` where they are too many.
pub(super) fn seen_from<P: Scalar>(
    places: core::ops::RangeInclusive<f64>,
    around: &Around<P>,
    side: usize,
    beyond: f64,
    period: &Period<P>,
) -> Option<core::ops::RangeInclusive<i32>> {
    let seen = seen(places, around, side, beyond, period)?;
    Some(-seen.end()..=-seen.start())
}

/// The boxes that `places` are seen in, from anywhere in `around`.
fn seen<P: Scalar>(
    places: core::ops::RangeInclusive<f64>,
    around: &Around<P>,
    side: usize,
    beyond: f64,
    period: &Period<P>,
) -> Option<core::ops::RangeInclusive<i32>> {
    let (low, high, length) = (around.low[side].to_f64(), around.high[side].to_f64(), period.length.to_f64());
    let least = ((low - beyond - places.end()) / length).ceil().min(0.0);
    let most = ((high + beyond - places.start()) / length).floor().max(0.0);
    (most - least < MOST).then_some(least as i32..=most as i32)
}
