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
use core::ops::{Range, RangeInclusive};

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
        around: &Around<f64>,
        beyond: f64,
        lengths: [f64; 3],
        most: u64,
    ) -> Result<(), Unfit> {
        self.images.clear();
        self.count = places[0].len();
        if lengths == [0.0; 3] {
            return Ok(());
        }
        self.images.reserve(places[0].len());
        let (mut next, most) = (0_u64, most.min(u32::MAX.into()));
        for row in 0..places[0].len() {
            let mut images = Images { first: next as u32, low: [0; 3], count: [1; 3] };
            for side in 0..3 {
                let place = places[side][row].to_f64();
                let (low, high) = (around.low[side] - beyond, around.high[side] + beyond);
                // Most are seen from nowhere else; what has no place is not seen at all.
                if lengths[side] == 0.0 || !(place + lengths[side] <= high || place - lengths[side] >= low) {
                    continue;
                }
                let seen = seen(place..=place, low..=high, lengths[side]).ok_or(Unfit::TooMany)?;
                (images.low[side], images.count[side]) = (*seen.start(), seen.end() - seen.start() + 1);
            }
            next += images.count.iter().map(|count| u64::from(count.unsigned_abs())).product::<u64>();
            if next > most {
                return Err(Unfit::TooMany);
            }
            self.images.push(images);
        }
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
            number = number * count[side].unsigned_abs() + place.unsigned_abs();
        }
        Some(first + number)
    }

    /// The entries of some rows.
    pub(super) fn of(&self, rows: Range<usize>) -> Range<usize> {
        let first = |row: usize| match self.images.get(row) {
            Some(images) => images.first as usize,
            None if self.images.is_empty() => row,
            None => self.count,
        };
        first(rows.start)..first(rows.end)
    }

    /// Copies a number of each of these rows to all its entries.
    pub(super) fn spread<P: Copy>(&self, rows: Range<usize>, from: &[P], to: &mut [P]) {
        if self.images.is_empty() {
            return to.copy_from_slice(from);
        }
        let later = self.images.get(rows.start + 1..).unwrap_or_default();
        let ends = later.iter().map(|images| images.first as usize).chain([self.count]);
        let (mut at, start) = (0, self.of(rows).start);
        for (value, end) in from.iter().zip(ends) {
            to[at] = *value;
            at += 1;
            if at < end - start {
                to[at..end - start].fill(*value);
                at = end - start;
            }
        }
    }

    /// Copies coordinates of these rows, in the box, to all their entries, each moved to its image.
    pub(super) fn place<P: Scalar>(
        &self,
        rows: Range<usize>,
        from: [&[P]; 3],
        periods: &[Option<Period<P>>; 3],
        [to_x, to_y, to_z]: [&mut [P]; 3],
    ) {
        let mut at = 0;
        for row in rows {
            let place = from.map(|numbers| numbers[row]);
            let Images { low, count, .. } = self.images[row];
            if count == [1; 3] {
                (to_x[at], to_y[at], to_z[at]) = (place[0], place[1], place[2]);
                at += 1;
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

/// The boxes whose rows, if they are in `around`, may be within it of `places`; `None` where they are too many.
pub(super) fn seen_from(
    places: RangeInclusive<f64>,
    around: RangeInclusive<f64>,
    length: f64,
) -> Option<RangeInclusive<i32>> {
    let seen = seen(places, around, length)?;
    Some(-seen.end()..=-seen.start())
}

/// The boxes that `places` are in `around` from, and the one that they are in.
fn seen(places: RangeInclusive<f64>, around: RangeInclusive<f64>, length: f64) -> Option<RangeInclusive<i32>> {
    let least = ((around.start() - places.end()) / length).ceil().min(0.0);
    let most = ((around.end() - places.start()) / length).floor().max(0.0);
    (most - least < MOST).then_some(least as i32..=most as i32)
}
