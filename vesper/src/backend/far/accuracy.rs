//! How much error an opening gives.

/// Order and opening for a requested error.
pub(super) fn first_guess(error: f64) -> (usize, f64) {
    if error > 3e-3 {
        (3, 0.7)
    } else if error > 1e-4 {
        (4, 0.7)
    } else if error > 2e-5 {
        (5, 0.6)
    } else {
        (6, 0.6)
    }
}

/// The opening of near cells that goes with one of far cells.
pub(super) fn near_opening(_order: usize, opening: f64) -> f64 {
    opening
}
