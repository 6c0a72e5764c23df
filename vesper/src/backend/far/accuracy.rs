//! What an error costs, and what is allowed for it.
//!
//! In: a requested error. Out: the order of expansions, how near they are used, and from how many rows on that is faster than all pairs.
//! Never: a look at the rows; [`super::calibrate`] does that.

use super::walk::Opening;

/// What says how large the error of a far field is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort {
    /// The degree of the highest derivative in the expansions, 3 to 5.
    pub(super) degree: usize,
    /// What one cell's expansion may leave out, in parts of the field.
    pub(super) allowed: f64,
}

/// A far field's error, as measured for a sample of rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// Requested: root of the mean square, relative.
    pub(crate) requested: f64,
    /// Measured, the same.
    pub(crate) measured: f64,
    /// The largest one of the sample.
    pub(crate) largest: f64,
}

/// Least and most that a cell may leave out.
pub(super) const ALLOWED: [f64; 2] = [1e-14, 1.0];
/// Near cells may leave out so many times as much: their errors are those of single rows, and go in all directions (measured: errors
/// from 1e-3 to 1e-5 cost least with 5 to 20).
const NEAR: f64 = 10.0;

impl Effort {
    /// A first guess, from a concentrated sphere of 10^5 rows; within a factor of 3 for other scenes.
    pub(super) fn first(error: f64) -> Self {
        // A lower order is cheaper for errors of 0.1 %, a higher one for those of 10^-6 (measured).
        let (degree, at_one) = if error > 2e-3 {
            (3, 1.0)
        } else if error > 3e-6 {
            (4, 2.2)
        } else {
            (5, 2.6)
        };
        let allowed = at_one * error.max(1e-12).powf(1.35);
        Effort { degree, allowed: allowed.clamp(ALLOWED[0], ALLOWED[1]) }
    }

    /// How near cells may be.
    pub(super) fn opening(self) -> Opening {
        // A series whose terms fall by less than half costs less opened than continued, unless a large error is allowed.
        let part = (0.7 * (self.allowed / 3e-4).powf(0.2)).clamp(0.5, 0.95);
        Opening { allowed: self.allowed, near_allowed: NEAR * self.allowed, part, near_part: (part + 0.2).min(0.95) }
    }
}

/// Whether a far field of a requested error takes less time than the sum over all pairs.
///
/// From timings of a concentrated sphere: a row costs as much as about 4000 pairs at an error of 10^-3, and 1.9 times as many for each
/// factor of ten.
pub(crate) fn pays(rows: usize, error: f64) -> bool {
    rows as f64 > 4000.0 * (1e-3 / error.max(1e-12)).powf(0.28)
}
