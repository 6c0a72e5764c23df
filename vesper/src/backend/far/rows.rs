//! Rows in the order of the tree, and the groups of them that are summed for together.
//!
//! In: the order. Out: columns of places and strengths, padded to whole groups; for each group its box and its sphere. Never: a
//! change of what it was given.

use super::order::{self, Box3, Keyed};
use super::tree::distance_squared;
use super::{Parts, SHARE, Source};
use crate::real::{Lanes, MAX_WIDTH, Scalar};
use core::ops::Range;

/// Rows that are summed for together: two registers of the widest f32 lanes (measured: see the module's documentation).
pub(super) const GROUP: usize = 32;

/// Columns in the order of the tree; behind the rows and their padding stand the sums of rows that are all at one place.
#[derive(Debug, Default)]
pub(super) struct Rows<P> {
    pub(super) places: [Vec<P>; 3],
    pub(super) strength: Vec<P>,
    /// Which row of the caller each one is.
    pub(super) origin: Vec<u32>,
    origin_before: Vec<u32>,
}

/// The numbers of one group: the middle of its box, half the box, the radius of its sphere.
pub(super) const NUMBERS: usize = 7;

/// Boxes and spheres of the groups, one column for each number, padded to whole lanes.
#[derive(Debug, Default)]
pub(super) struct Groups<P> {
    pub(super) count: usize,
    pub(super) numbers: [Vec<P>; NUMBERS],
}

/// Lanes of a column.
#[inline(always)]
pub(super) fn load<P, R: Lanes<P>>(column: &[P], at: usize) -> R {
    let numbers = &column[at..at + R::WIDTH];
    // SAFETY: the slice has a number for every lane.
    unsafe { R::load(numbers.as_ptr()) }
}

/// Writes lanes into a column.
#[inline(always)]
pub(super) fn store<P, R: Lanes<P>>(lanes: R, column: &mut [P], at: usize) {
    let numbers = &mut column[at..at + R::WIDTH];
    // SAFETY: the slice has a number for every lane.
    unsafe { lanes.store(numbers.as_mut_ptr()) };
}

impl<P: Scalar> Rows<P> {
    #[inline(always)]
    pub(super) fn place(&self, row: usize) -> [P; 3] {
        [self.places[0][row], self.places[1][row], self.places[2][row]]
    }

    /// How many rows there are without the padding.
    pub(super) fn count(&self) -> usize {
        self.origin.len()
    }

    /// Takes the rows in another order than the one before: `before` are those of that order, `keyed` says which one each is.
    pub(super) fn take(&mut self, before: &[Source<P>], keyed: &[Keyed], threads: &impl Parts) {
        let count = keyed.len();
        let padded = count.next_multiple_of(GROUP);
        core::mem::swap(&mut self.origin, &mut self.origin_before);
        self.origin.resize(count, 0);
        for column in self.places.iter_mut().chain([&mut self.strength]) {
            // What it has from the tree before is written over.
            column.resize(padded, P::from_f64(0.0));
        }
        let [xs, ys, zs] = self.places.each_mut().map(|column| column.chunks_mut(SHARE));
        let parts = xs.zip(ys).zip(zs.zip(self.strength.chunks_mut(SHARE)));
        let parts = parts.zip(self.origin.chunks_mut(SHARE).zip(keyed.chunks(SHARE)));
        let origin_before = &self.origin_before;
        threads.each(parts, |_, (((xs, ys), (zs, strengths)), (origins, keyed))| {
            let columns = xs.iter_mut().zip(ys.iter_mut()).zip(zs.iter_mut().zip(strengths.iter_mut()));
            for ((columns, origin), keyed) in columns.zip(origins.iter_mut()).zip(*keyed) {
                let at = order::row(*keyed);
                let ((x, y), (z, strength)) = columns;
                [*x, *y, *z, *strength] = before[at];
                *origin = origin_before[at];
            }
        });
        for column in &mut self.places {
            // A row of padding stands where the last one does, so that it has no share in the size of a group.
            let last = column[count - 1];
            column[count..].fill(last);
        }
        self.strength[count..].fill(P::from_f64(0.0));
    }

    /// Adds a row that stands for several at the same place, and says where.
    pub(super) fn sum_up(&mut self, range: Range<usize>) -> usize {
        let place = self.place(range.start);
        for (own, number) in self.places.iter_mut().zip(place) {
            own.push(number);
        }
        let mut sum = P::from_f64(0.0);
        for &strength in &self.strength[range] {
            sum += strength;
        }
        self.strength.push(sum);
        self.strength.len() - 1
    }
}

impl<P: Scalar> Groups<P> {
    pub(super) fn find(&mut self, rows: &Rows<P>, threads: &impl Parts) {
        self.count = rows.count().div_ceil(GROUP);
        for column in &mut self.numbers {
            column.resize(self.count + MAX_WIDTH, P::from_f64(0.0));
        }
        const GROUPS: usize = SHARE / GROUP;
        let mut columns = self.numbers.each_mut().map(|column| column[..self.count].chunks_mut(GROUPS));
        let parts = core::iter::from_fn(|| {
            let part = columns.each_mut().map(Iterator::next);
            part[0].is_some().then(|| part.map(Option::unwrap_or_default))
        });
        threads.each(parts, |part, columns| {
            for at in 0..columns[0].len() {
                for (column, number) in columns.iter_mut().zip(numbers_of(rows, part * GROUPS + at)) {
                    column[at] = number;
                }
            }
        });
        for column in &mut self.numbers {
            let last = column[self.count - 1];
            column[self.count..].fill(last);
        }
    }
}

/// The middle of a group's box, half the box, and the radius about the middle.
fn numbers_of<P: Scalar>(rows: &Rows<P>, group: usize) -> [P; NUMBERS] {
    let range = group * GROUP..(group + 1) * GROUP;
    let mut around = Box3::at(rows.place(range.start));
    for row in range.clone() {
        around.hold(Box3::at(rows.place(row)));
    }
    let centre = around.centre();
    let mut radius = P::from_f64(0.0);
    for row in range {
        radius = radius.max(distance_squared(rows.place(row), centre));
    }
    // The middle is rounded: the farther side counts.
    let half = |k: usize| (around.high[k] - centre[k]).max(centre[k] - around.low[k]);
    [centre[0], centre[1], centre[2], half(0), half(1), half(2), radius.sqrt()]
}
