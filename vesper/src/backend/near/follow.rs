//! Where rows are now: brought into the box as they were when the lists were made, and whether one of them moved too far.
//!
//! In: coordinates as the laws see them. Out: the same in the box, and whether the lists still hold. Never: a list.

use super::period::Period;
use crate::real::{Lanes, Scalar, WithLanes};

/// One look at all rows.
pub(super) struct Follow<'a, P> {
    pub(super) places: [&'a [P]; 3],
    pub(super) periods: &'a [Option<Period<P>>; 3],
    /// By direction with a period: how many lengths each row is moved.
    pub(super) turns: [&'a [P]; 3],
    /// Where the rows were, or nothing to compare with.
    pub(super) built: [&'a [P]; 3],
    /// One over how far a row may move. A product, so that no unit of length makes its square too small to compare.
    pub(super) scale: P,
    /// Takes where the rows are in the box; nothing to take without periods.
    pub(super) now: [&'a mut [P]; 3],
}

impl<P: Scalar> WithLanes<P> for Follow<'_, P> {
    /// Whether no row moved too far.
    type Output = bool;
    #[inline(always)]
    fn with<R: Lanes<P>>(mut self) -> bool {
        match self.places[0].len() {
            0 => true,
            rows if rows < R::WIDTH => self.all::<P>(rows),
            rows => self.all::<R>(rows),
        }
    }
}

impl<P: Scalar> Follow<'_, P> {
    /// All rows, at least as many as there are lanes.
    #[inline(always)]
    fn all<R: Lanes<P>>(&mut self, rows: usize) -> bool {
        let mut fine = R::lit(0.0).equal(R::lit(0.0));
        for row in (0..rows - R::WIDTH).step_by(R::WIDTH) {
            fine = fine & self.rows::<R>(row);
        }
        // The last ones are looked at twice where they do not fill the lanes.
        fine = fine & self.rows::<R>(rows - R::WIDTH);
        let far = R::select(fine, R::lit(0.0), R::lit(1.0));
        (0..R::WIDTH).all(|lane| far.lane(lane) == P::default())
    }

    /// As many rows as there are lanes.
    #[inline(always)]
    fn rows<R: Lanes<P>>(&mut self, row: usize) -> R::Mask {
        let mut square = R::lit(0.0);
        for side in 0..3 {
            let place = &self.places[side][row..][..R::WIDTH];
            // SAFETY: it has so many numbers.
            let mut place = unsafe { R::load(place.as_ptr()) };
            if let Some(period) = &self.periods[side] {
                let turns = &self.turns[side][row..][..R::WIDTH];
                // SAFETY: as above.
                place = period.moved(place, unsafe { R::load(turns.as_ptr()) });
            }
            if !self.now[side].is_empty() {
                let now = &mut self.now[side][row..][..R::WIDTH];
                // SAFETY: there is room for so many.
                unsafe { place.store(now.as_mut_ptr()) };
            }
            if !self.built[side].is_empty() {
                let built = &self.built[side][row..][..R::WIDTH];
                // SAFETY: as above.
                let moved = (place - unsafe { R::load(built.as_ptr()) }) * R::splat(self.scale);
                square += moved * moved;
            }
        }
        // False for what is no number.
        square.less_or_equal(R::lit(1.0))
    }
}
