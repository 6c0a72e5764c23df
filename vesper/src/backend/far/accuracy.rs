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
    /// Root of the mean square, relative.
    pub(crate) measured: f64,
    /// The largest one of the sample.
    pub(crate) largest: f64,
}

/// Least and most that a cell may leave out.
pub(super) const ALLOWED: [f64; 2] = [1e-16, 1.0];
/// Near cells may leave out so many times as much: their errors are those of single rows, and go in all directions (measured: errors
/// from 1e-3 to 1e-5 cost the same with 10 as with 30, more with 3 and with 100).
const NEAR: f64 = 20.0;
/// The largest part of the distance that radii may have. Every row is within, so the series converges; what it leaves out is what the
/// weights say (measured: parts of 0.6 take 1.2 times as long for the same error).
const PART: f64 = 0.9;
const NEAR_PART: f64 = 0.95;

impl Effort {
    /// A first guess, from a concentrated sphere of 10^5 rows.
    pub(super) fn first(error: f64) -> Self {
        // A lower order is cheaper for errors of some 0.1 % (measured: at 10^-3 by a tenth, for sphere, disc and cube; at 5 10^-4 by a
        // tenth for the disc, but not for the others), a higher one for those of 10^-6.
        let (degree, at_one) = if error > 7e-4 {
            (3, 1.8)
        } else if error > 3e-6 {
            (4, 5.5)
        } else {
            (5, 12.0)
        };
        let allowed = at_one * error.max(1e-12).powf(1.48);
        Effort { degree, allowed: allowed.clamp(ALLOWED[0], ALLOWED[1]) }
    }

    /// How near cells may be.
    pub(super) fn opening(self) -> Opening {
        Opening { allowed: self.allowed, near_allowed: NEAR * self.allowed, part: PART, near_part: NEAR_PART }
    }
}

/// Whether a far field of a requested error takes less time than the sum over all pairs.
///
/// From timings of a concentrated sphere, in f32 and f64 alike, beside pairs that are looked at once: with an error of 10^-3 the two
/// take the same time for 3200 rows, with 10^-5 for 13 000.
pub(crate) fn pays(rows: usize, error: f64) -> bool {
    let error = error.max(1e-12);
    let pairs = 3200.0 * (1e-3 / error).powf(0.3) * (1e-5 / error).max(1.0).powf(0.3);
    rows as f64 > pairs
}
