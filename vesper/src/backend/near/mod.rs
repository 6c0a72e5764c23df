//! Lists of neighbours, for pair laws that end at a distance.
//!
//! In: where rows are, how far the law reaches, and the lengths after which everything comes again. Out: *clusters* of rows that
//! are near each other, and for each cluster one list of all that is within reach of any of its rows. Never: a sum, a law,
//! a choice between lists and all pairs.
//!
//! A list is made for a little more than the reach, the *skin*, and holds until some row has moved by half of that
//! (Verlet 1967, <https://doi.org/10.1103/PhysRev.159.98>; Allen and Tildesley, Computer Simulation of Liquids, 2nd edition
//! 2017, section 5.3). One list for the rows that stand in lanes together, instead of one for each row, lets a loop read
//! each neighbour once, as one number for all lanes (Páll and Hess 2013, <https://doi.org/10.1016/j.cpc.2013.06.003>).
//!
//! # Bits
//!
//! A list's entries are numbered by row, then by image, and stand in ascending order. A loop that adds
//! `select(r^2 < cutoff^2 and not the row itself, share, 0)` for every entry therefore adds, for each row, the shares of the
//! partners within the cut-off in one order that is given by the rows alone, with exact zeros between them; a sum that began
//! with +0 keeps its bits over an added zero. So a sum does not depend on when the list was made, on the skin, on the
//! clusters, the lanes or the threads; without periods it is what a loop over all pairs with the same `select` gives.
//!
//! With periods, the loop reads coordinates that [`Lists::place`] gives. All of them are on a grid where differences are exact
//! (`period.rs`), so that the difference of two entries depends on the rows' own coordinates and on the number of boxes
//! between them only, not on the box that a row was counted in. Laws must look at differences of coordinates alone, as laws do that
//! mean anything in a periodic box.
//!
//! # Rows without a place
//!
//! Rows with a coordinate that is not finite, or so many boxes away that it has no digit left, are on nobody's list, and their own
//! lists are empty: no distance from them is less than a cut-off. Lists with such rows never hold.

#![allow(clippy::needless_range_loop, reason = "directions, of several arrays at a time")]

mod follow;
mod images;
mod period;
mod search;
#[cfg(test)]
mod tests;
mod tree;

use crate::real::{Isa, Scalar};
use core::ops::Range;
use core::sync::atomic::AtomicU64;
use follow::Follow;
use images::Entries;
use period::Period;
use search::{Part, Search, SearchParts, TOGETHER};
use std::sync::{Mutex, PoisonError};
use tree::{Around, FAN, Level, Point};

/// Calls the work for ranges that are `0..count` together, on as many threads as it likes.
pub(crate) type InParts<'a> = &'a dyn Fn(usize, &(dyn Fn(Range<usize>) + Sync));

/// How far lists reach, and in what space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// From here on, two rows do nothing to each other. In the unit of the coordinates.
    pub(crate) cutoff: f64,
    /// How much further lists reach than that, so that they hold for a while.
    pub(crate) skin: f64,
    /// After how much everything comes again, in each direction; 0 or infinite for never.
    pub(crate) lengths: [f64; 3],
    /// Entries that all lists together may have. More are refused, before the memory is full.
    pub(crate) most: u64,
}

impl Reach {
    /// With a skin that is right for a dense fluid, and as many entries as 16 GiB hold.
    pub(crate) fn new(cutoff: f64, lengths: [f64; 3]) -> Self {
        Reach { cutoff, skin: SKIN * cutoff, lengths, most: u32::MAX.into() }
    }
}

/// The skin, in parts of the cut-off. See `how_long_it_takes` among the tests for others.
const SKIN: f64 = 0.12;

/// Why there are no lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unfit {
    /// The cut-off or the skin is no distance.
    #[error("a cut-off is a positive number, and a skin is not negative")]
    Reach,
    /// A length that numbers of this precision cannot divide.
    #[error("a length of the box is too small, too large, or no number")]
    Length,
    /// More than there are numbers for, or than was allowed.
    #[error("neighbours are too many for lists: reach less far, or take all pairs")]
    TooMany,
}

/// One cluster and its list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster<'a> {
    /// Its rows, ascending, at most [`Lists::width`].
    pub(crate) rows: &'a [u32],
    /// The entries within reach, ascending, with those of its own rows.
    pub(crate) list: &'a [u32],
    /// Where the entry of each of its rows is in the list, ascending; nothing where rows have no place.
    pub(crate) own: &'a [u32],
}

/// The lists of all rows of a domain.
#[derive(Debug)]
pub(crate) struct Lists<P> {
    reach: Reach,
    /// Rows of a cluster.
    width: usize,
    periods: [Option<Period<P>>; 3],
    /// How many lengths bring each row into the box; none in a direction without a period.
    turns: [Vec<P>; 3],
    /// Where rows were in the box when the lists were made; empty where there are none.
    built: [Vec<P>; 3],
    /// Where they are now; empty without periods.
    now: [Vec<P>; 3],
    /// Rows in the order of clusters.
    points: Vec<Point<P>>,
    /// The same, and those without a place behind them.
    members: Vec<u32>,
    entries: Entries,
    parts: Vec<Part>,
    /// Entries of all lists now, and when rows were put in order.
    total: u64,
    ordered: u64,
}

/// How much longer lists may become than they were when rows were put in order, before that is done again.
const LONGER: f64 = 1.03;

impl<P: Scalar> Lists<P> {
    /// For clusters of so many rows: a multiple of the lanes that a loop takes is best.
    pub(crate) fn new(reach: Reach, width: usize) -> Result<Self, Unfit> {
        let Reach { cutoff, skin, lengths, .. } = reach;
        if !(cutoff > 0.0 && skin >= 0.0 && (cutoff + skin).is_finite()) {
            return Err(Unfit::Reach);
        }
        let mut lists = Lists {
            reach,
            width: width.max(1),
            periods: [None; 3],
            turns: Default::default(),
            built: Default::default(),
            now: Default::default(),
            points: Vec::new(),
            members: Vec::new(),
            entries: Entries::default(),
            parts: Vec::new(),
            total: 0,
            ordered: 0,
        };
        for (period, length) in lists.periods.iter_mut().zip(lengths) {
            if length != 0.0 && length != f64::INFINITY {
                // Rows may be half a skin outside of the box, and are seen from as far outside.
                let beyond = 1.01 * (cutoff + 2.0 * skin);
                *period = Some(Period::new(length, beyond).ok_or(Unfit::Length)?);
            }
        }
        Ok(lists)
    }

    /// The rows of a cluster that is full.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// How far lists reach, with a little for the rounding of all that is computed from it.
    fn listed(&self) -> f64 {
        (self.reach.cutoff + self.reach.skin) * (1.0 + 32.0 * P::EPSILON)
    }

    /// Takes in where the rows are now. Whether the lists hold: they were made for as many rows, each of them is at a finite place,
    /// and none has moved by more than half the skin since.
    pub(crate) fn follow(&mut self, isa: Isa, places: [&[P]; 3]) -> bool {
        let rows = places[0].len();
        if self.members.len() != rows || self.built[0].len() != rows {
            return false;
        }
        let limit = self.reach.skin / 2.0 * (1.0 - 32.0 * P::EPSILON);
        let [x, y, z] = &mut self.now;
        P::with_lanes(
            isa,
            Follow {
                places,
                periods: &self.periods,
                turns: self.turns.each_ref().map(Vec::as_slice),
                built: self.built.each_ref().map(Vec::as_slice),
                square: P::from_f64(limit * limit),
                now: [x, y, z],
            },
        )
    }

    /// Makes the lists anew, for rows at these places. Where that fails, there are none.
    pub(crate) fn build(&mut self, isa: Isa, places: [&[P]; 3], in_parts: InParts<'_>) -> Result<(), Unfit> {
        let made = self.make(isa, places, in_parts);
        if made.is_err() {
            self.parts.clear();
            self.built.iter_mut().for_each(Vec::clear);
            (self.members, self.points, self.total, self.ordered) = (Vec::new(), Vec::new(), 0, 0);
        }
        made
    }

    fn make(&mut self, isa: Isa, places: [&[P]; 3], in_parts: InParts<'_>) -> Result<(), Unfit> {
        let rows = u32::try_from(places[0].len()).map_err(|_| Unfit::TooMany)?;
        self.bring_in(isa, places);
        self.order(rows);
        let levels = tree::levels(&self.points, self.width);
        let around = levels[levels.len() - 1].around_all();
        // A thousandth more than rows are listed for, and what rounding of coordinates could do.
        let longest = self.periods.iter().flatten().fold(0.0, |most, period| f64::max(most, period.length.to_f64()));
        let beyond = self.listed() * (1.0 + 1e-3) + 16.0 * f64::EPSILON * longest;
        self.entries.find(self.built.each_ref().map(Vec::as_slice), &around, beyond, &self.periods)?;
        self.search(isa, in_parts, &levels, &around, beyond)?;
        if self.ordered == 0 {
            self.ordered = self.total;
        }
        Ok(())
    }

    /// Fills `turns`, `now` and `built`.
    fn bring_in(&mut self, isa: Isa, places: [&[P]; 3]) {
        let nowhere = P::from_f64(f64::NAN);
        let periodic = self.periods.iter().any(Option::is_some);
        for side in 0..3 {
            self.turns[side].clear();
            if let Some(period) = &self.periods[side] {
                self.turns[side].extend(places[side].iter().map(|place| period.turns(*place).unwrap_or(nowhere)));
            }
            self.built[side].clear();
            self.now[side].clear();
            if periodic {
                self.now[side].resize(places[side].len(), P::default());
            }
        }
        if periodic {
            let [x, y, z] = &mut self.now;
            let turns = self.turns.each_ref().map(Vec::as_slice);
            let square = P::default();
            let now: [&mut [P]; 3] = [x, y, z];
            P::with_lanes(isa, Follow { places, periods: &self.periods, turns, built: [&[]; 3], square, now });
        }
        for side in 0..3 {
            let from = if periodic { &self.now[side][..] } else { places[side] };
            self.built[side].extend_from_slice(from);
        }
        for row in 0..places[0].len() {
            if (0..3).any(|side| !self.built[side][row].is_finite()) {
                self.built.iter_mut().for_each(|built| built[row] = nowhere);
            }
        }
    }

    /// Puts rows in the order of clusters; the old order, where it is still a good one.
    fn order(&mut self, rows: u32) {
        let at = |row: u32| core::array::from_fn(|side| self.built[side][row as usize]);
        let has_place = |row: &u32| self.built[0][*row as usize].is_finite();
        let count = (0..rows).filter(has_place).count();
        let same = self.ordered > 0
            && self.total as f64 <= LONGER * self.ordered as f64
            && self.members.len() == rows as usize
            && self.points.len() == count
            && self.points.iter().all(|point| has_place(&point.row));
        if same {
            self.points.iter_mut().for_each(|point| point.at = at(point.row));
        } else {
            self.ordered = 0;
            self.points.clear();
            self.points.extend((0..rows).filter(has_place).map(|row| Point { at: at(row), row }));
            tree::arrange(&mut self.points, self.width);
            self.members.clear();
            self.members.extend(self.points.iter().map(|point| point.row));
            self.members.extend((0..rows).filter(|row| !has_place(row)));
        }
    }

    fn search(
        &mut self,
        isa: Isa,
        in_parts: InParts<'_>,
        levels: &[Level<P>],
        around: &Around<P>,
        beyond: f64,
    ) -> Result<(), Unfit> {
        let room = self.points.len() + FAN;
        let mut places = [const { Vec::new() }; 3].map(|_: Vec<P>| Vec::with_capacity(room));
        for (side, places) in places.iter_mut().enumerate() {
            places.extend(self.points.iter().map(|point| point.at[side]));
            places.resize(room, P::default());
        }
        let rows = &self.members[..self.points.len()];
        let own: Vec<u32> = rows.iter().map(|row| self.entries.own(*row)).collect();
        let mut parts = core::mem::take(&mut self.parts);
        parts.resize_with(levels[0].count.div_ceil(TOGETHER), Part::default);
        let parts: Vec<_> = parts.into_iter().map(Mutex::new).collect();
        let total = AtomicU64::new(0);
        let listed = self.listed();
        let search = Search {
            places: places.each_ref().map(Vec::as_slice),
            rows,
            own: &own,
            width: self.width,
            levels,
            around,
            entries: &self.entries,
            periods: &self.periods,
            beyond,
            square: P::from_f64(listed * listed),
            parts: &parts,
            total: &total,
            most: self.reach.most,
        };
        in_parts(parts.len(), &|parts| P::with_lanes(isa, SearchParts { search: &search, parts }));
        self.parts = parts.into_iter().map(|part| part.into_inner().unwrap_or_else(PoisonError::into_inner)).collect();
        self.total = total.into_inner();
        if self.total > self.reach.most { Err(Unfit::TooMany) } else { Ok(()) }
    }

    /// How many clusters there are.
    pub(crate) fn clusters(&self) -> usize {
        let placed = self.points.len().div_ceil(self.width);
        placed + (self.members.len() - self.points.len()).div_ceil(self.width)
    }

    /// One of them. Every row is in one cluster.
    #[inline]
    pub(crate) fn cluster(&self, number: usize) -> Cluster<'_> {
        let placed = self.points.len();
        let first = number * self.width;
        if first >= placed {
            let first = placed + (number - placed.div_ceil(self.width)) * self.width;
            let end = (first + self.width).min(self.members.len());
            return Cluster { rows: &self.members[first..end], list: &[], own: &[] };
        }
        let part = &self.parts[number / TOGETHER];
        let within = number % TOGETHER;
        let start = if within == 0 { 0 } else { part.ends[within - 1] };
        let end = (first + self.width).min(placed);
        let before = within * self.width;
        Cluster {
            rows: &self.members[first..end],
            list: &part.entries[start..part.ends[within]],
            own: &part.own[before..before + end - first],
        }
    }

    /// How many entries lists point to: as many numbers each array has that a loop reads.
    pub(crate) fn entries(&self) -> usize {
        self.entries.count
    }

    /// Whether rows are their own entries, where they stand: without periods, nothing needs to be copied.
    pub(crate) fn is_plain(&self) -> bool {
        self.periods.iter().all(Option::is_none)
    }

    /// Where each entry is now, as [`Lists::follow`] or [`Lists::build`] saw the rows last. Only with periods.
    pub(crate) fn place(&self, to: [&mut [P]; 3]) {
        self.entries.place(self.now.each_ref().map(Vec::as_slice), &self.periods, to);
    }

    /// Copies a number of each row to all its entries.
    pub(crate) fn spread(&self, from: &[P], to: &mut [P]) {
        self.entries.spread(from, to);
    }

    /// How long a list is, on average.
    pub(crate) fn average(&self) -> f64 {
        self.total as f64 / self.points.len().div_ceil(self.width).max(1) as f64
    }
}
