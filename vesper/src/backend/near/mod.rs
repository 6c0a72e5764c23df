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

#[cfg(test)]
mod edges;
mod follow;
mod images;
#[cfg(test)]
mod melt;
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
use tree::{Around, FAN, Point};

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

/// The skin, in parts of the cut-off. In a dense fluid a step takes 1.25 times as long with 0.08 and 1.03 times as long with 0.2;
/// `how_long_it_takes` among the tests tells.
const SKIN: f64 = 0.16;

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
    /// Rows in the order of clusters, those without a place behind the others, which are so many.
    members: Vec<u32>,
    placed: usize,
    entries: Entries,
    parts: Vec<Part>,
    /// Entries of all lists.
    total: u64,
}

/// How far rounding may be off where distances are measured in f32, in parts of the reach.
const BLUR: f64 = 1e-3;

impl<P: Scalar> Lists<P> {
    /// For clusters that fill the widest registers: the best width for narrower ones, too.
    pub(crate) fn new(reach: Reach) -> Result<Self, Unfit> {
        Self::with_width(reach, 64 / size_of::<P>())
    }

    /// For clusters of so many rows.
    pub(crate) fn with_width(reach: Reach, width: usize) -> Result<Self, Unfit> {
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
            members: Vec::new(),
            placed: 0,
            entries: Entries::default(),
            parts: Vec::new(),
            total: 0,
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
    #[cfg(test)]
    fn width(&self) -> usize {
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
        // Without a skin, the largest number that there is.
        let scale = 2.0 / self.reach.skin * (1.0 + 32.0 * P::EPSILON);
        let scale = [scale, 1e308, 1e38].map(P::from_f64).into_iter().find(|scale| scale.is_finite());
        let [x, y, z] = &mut self.now;
        P::with_lanes(
            isa,
            Follow {
                places,
                periods: &self.periods,
                turns: self.turns.each_ref().map(Vec::as_slice),
                built: self.built.each_ref().map(Vec::as_slice),
                scale: scale.unwrap_or_default(),
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
            (self.members, self.placed, self.total) = (Vec::new(), 0, 0);
        }
        made
    }

    fn make(&mut self, isa: Isa, places: [&[P]; 3], in_parts: InParts<'_>) -> Result<(), Unfit> {
        let rows = u32::try_from(places[0].len()).map_err(|_| Unfit::TooMany)?;
        self.bring_in(isa, places);
        let has_place = |row: &u32| self.built[0][*row as usize].is_finite();
        self.members.clear();
        self.members.extend((0..rows).filter(has_place));
        self.placed = self.members.len();
        self.members.extend((0..rows).filter(|row| !has_place(row)));
        let mut around = Around::<f64>::nothing();
        for row in &self.members[..self.placed] {
            around.take(self.built.each_ref().map(|numbers| numbers[*row as usize].to_f64()));
        }
        // A thousandth more than rows are listed for, and what rounding of coordinates could do.
        let lengths = self.periods.map(|period| period.map_or(0.0, |period| period.length.to_f64()));
        let longest = lengths.into_iter().fold(0.0, f64::max);
        let beyond = self.listed() * (1.0 + 2.0 * BLUR) + 16.0 * f64::EPSILON * longest;
        self.entries.find(self.built.each_ref().map(Vec::as_slice), &around, beyond, lengths, self.reach.most)?;
        // Lists need not know distances to the last digit: f32 has twice the lanes, if it can tell the places apart. In
        // parts of the reach, so that no square is too large or too small for it.
        let listed = self.listed();
        let scale = 1.0 / listed;
        let centre: [f64; 3] = core::array::from_fn(|side| 0.5 * (around.low[side] + around.high[side]));
        let extent = (0..3).fold(0.0, |most, side| f64::max(most, around.high[side] - centre[side]));
        let blur = 16.0 * f64::from(f32::EPSILON) * scale * (extent + longest + beyond);
        if P::EPSILON < f32::EPSILON.into() && scale.is_normal() && blur < BLUR {
            let centre = centre.map(P::from_f64);
            let lengths = lengths.map(|length| length * scale);
            self.search::<f32>(isa, in_parts, (lengths, beyond * scale, 1.0 + blur), |side, place| {
                ((place - centre[side]).to_f64() * scale) as f32
            })
        } else {
            self.search::<P>(isa, in_parts, (lengths, beyond, listed), |_, place| place)
        }
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
            let scale = P::default();
            let now: [&mut [P]; 3] = [x, y, z];
            P::with_lanes(isa, Follow { places, periods: &self.periods, turns, built: [&[]; 3], scale, now });
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

    /// Puts rows in the order of clusters and finds their lists, by places in precision `S`, for what is within `listed`.
    fn search<S: Scalar>(
        &mut self,
        isa: Isa,
        in_parts: InParts<'_>,
        (lengths, beyond, listed): ([f64; 3], f64, f64),
        place: impl Fn(usize, P) -> S,
    ) -> Result<(), Unfit> {
        let rows = &mut self.members[..self.placed];
        let at = |row: u32| core::array::from_fn(|side| place(side, self.built[side][row as usize]));
        let mut points: Vec<Point<S>> = rows.iter().map(|row| Point { at: at(*row), row: *row }).collect();
        tree::arrange(&mut points, self.width);
        rows.iter_mut().zip(&points).for_each(|(row, point)| *row = point.row);
        let levels = tree::levels(&points, self.width);
        let places: [Vec<S>; 3] = core::array::from_fn(|side| {
            let mut places = Vec::with_capacity(points.len() + FAN);
            places.extend(points.iter().map(|point| point.at[side]));
            places.resize(points.len() + FAN, S::default());
            places
        });
        let own: Vec<u32> = rows.iter().map(|row| self.entries.own(*row)).collect();
        let mut parts = core::mem::take(&mut self.parts);
        parts.resize_with(levels[0].count.div_ceil(TOGETHER), Part::default);
        let parts: Vec<_> = parts.into_iter().map(Mutex::new).collect();
        let total = AtomicU64::new(0);
        let search = Search {
            places: places.each_ref().map(Vec::as_slice),
            rows,
            own: &own,
            width: self.width,
            levels: &levels,
            entries: &self.entries,
            lengths,
            beyond,
            square: S::from_f64(listed * listed),
            parts: &parts,
            total: &total,
            most: self.reach.most,
        };
        let isa = isa.for_few::<S>(self.width);
        in_parts(parts.len(), &|parts| S::with_lanes(isa, SearchParts { search: &search, parts }));
        self.parts = parts.into_iter().map(|part| part.into_inner().unwrap_or_else(PoisonError::into_inner)).collect();
        self.total = total.into_inner();
        if self.total > self.reach.most { Err(Unfit::TooMany) } else { Ok(()) }
    }

    /// How many clusters there are.
    pub(crate) fn clusters(&self) -> usize {
        let placed = self.placed.div_ceil(self.width);
        placed + (self.members.len() - self.placed).div_ceil(self.width)
    }

    /// One of them. Every row is in one cluster.
    #[inline]
    pub(crate) fn cluster(&self, number: usize) -> Cluster<'_> {
        let placed = self.placed;
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

    /// The entries of some rows.
    pub(crate) fn entries_of(&self, rows: Range<usize>) -> Range<usize> {
        self.entries.of(rows)
    }

    /// Where each entry of some rows is now, as [`Lists::follow`] or [`Lists::build`] saw the rows last: a number for each of
    /// [`Lists::entries_of`] them. Only with periods.
    pub(crate) fn place(&self, rows: Range<usize>, to: [&mut [P]; 3]) {
        self.entries.place(rows, self.now.each_ref().map(Vec::as_slice), &self.periods, to);
    }

    /// Copies a number of each of some rows to all its entries.
    pub(crate) fn spread(&self, rows: Range<usize>, from: &[P], to: &mut [P]) {
        self.entries.spread(rows, from, to);
    }

    /// How long a list is, on average.
    pub(crate) fn average(&self) -> f64 {
        self.total as f64 / self.placed.div_ceil(self.width).max(1) as f64
    }

    /// Whether lists are less work than all pairs, where they hold for so many evaluations. Without periods only: nothing else
    /// finds images.
    pub(crate) fn pays(&self, evaluations: f64) -> bool {
        pays(self.members.len(), self.average(), evaluations)
    }
}

/// Whether lists of so many entries, each held for so many evaluations, are less work than all pairs of so many rows.
pub(crate) fn pays(rows: usize, average: f64, evaluations: f64) -> bool {
    // In entries that a loop reads: those of the list, what it costs to make it, and to begin with it.
    average * (1.0 + MAKING / evaluations.max(1.0)) + BEGINNING < rows as f64
}

/// How many times what a loop does with a list it costs to make it, and entries that the loop could read while it begins one.
/// Measured with a body of twenty operations and a division, see `how_long_it_takes`; heavier bodies make lists pay earlier.
const MAKING: f64 = 4.5;
const BEGINNING: f64 = 16.0;
