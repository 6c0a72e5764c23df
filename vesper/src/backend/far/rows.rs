//! Rows in the order of the tree, and the groups of them that are summed for together.
//!
//! In: the order. Out: columns of places and strengths, padded to whole groups; for each group its box and its sphere. Never: a
//! change of what it was given.

use super::order::{self, Box3, Keyed};
use super::tree::distance_squared;
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

    /// Takes the rows in order.
    pub(super) fn take(&mut self, places: &[Vec<P>; 3], strength: &[P], keyed: &[Keyed]) {
        let padded = keyed.len().next_multiple_of(GROUP);
        for (own, from) in self.places.iter_mut().zip(places) {
            own.clear();
            own.extend(keyed.iter().map(|keyed| from[order::row(*keyed)]));
            // A row of padding stands where the last one does, so that it has no share in the size of a group.
            own.resize(padded, own[keyed.len() - 1]);
        }
        self.strength.clear();
        self.strength.extend(keyed.iter().map(|keyed| strength[order::row(*keyed)]));
        self.strength.resize(padded, P::from_f64(0.0));
        self.origin.clear();
        self.origin.extend(keyed.iter().map(|keyed| order::row(*keyed) as u32));
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
    pub(super) fn find(&mut self, rows: &Rows<P>) {
        self.count = rows.count().div_ceil(GROUP);
        for column in &mut self.numbers {
            column.clear();
        }
        for group in 0..self.count {
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
            for (k, &centre) in centre.iter().enumerate() {
                self.numbers[k].push(centre);
                // The middle is rounded: the farther side counts.
                self.numbers[3 + k].push((around.high[k] - centre).max(centre - around.low[k]));
            }
            self.numbers[6].push(radius.sqrt());
        }
        let padded = self.count + MAX_WIDTH;
        for column in &mut self.numbers {
            column.resize(padded, column[self.count - 1]);
        }
    }
}
