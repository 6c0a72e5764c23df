//! Krylov spaces: an orthonormal basis of `v, A v, A A v, ...`, one vector at a time, and what `A` is in it.
//!
//! In: vectors of a system, in which whoever asks has put `A` times the last one. Out: columns of the Hessenberg matrix.
//! Never: the operator `A` itself.
//!
//! Source: Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., SIAM 2011, 6.2, algorithm 6.2 (modified
//! Gram-Schmidt), done twice: then the basis is orthogonal to rounding.

use super::{Register, System};
use crate::law::Part;

/// The most vectors of a space; one more is needed for the last product.
pub(super) const BASIS: usize = 30;

/// A basis in the work vectors from a number on.
pub(super) struct Arnoldi {
    first: usize,
    part: Part,
    /// Of the scalar product, for each state.
    pub(super) weights: Vec<f64>,
}

impl Arnoldi {
    pub(super) fn new(first: usize, part: Part, weights: Vec<f64>) -> Self {
        Arnoldi { first, part, weights }
    }

    fn vector(&self, number: usize) -> Register {
        Register::Work(self.first + number)
    }

    pub(super) fn norm(&self, system: &dyn System, of: Register) -> f64 {
        system.dot(of, of, self.part, &self.weights).sqrt()
    }

    /// Makes the first vector, which has this norm, one of norm 1.
    pub(super) fn begin(&self, system: &mut dyn System, norm: f64) {
        let first = self.vector(0);
        system.combine(first, &[(1.0 / norm, first)], self.part);
    }

    /// `A` times vector `number` is in the vector behind it: makes that one orthogonal to all before, of norm 1; what it was in
    /// the basis. The last number is 0 where nothing is left of it: the space is whole.
    pub(super) fn extend(&self, system: &mut dyn System, number: usize) -> Vec<f64> {
        let new = self.vector(number + 1);
        let mut column = vec![0.0; number + 2];
        let whole = self.norm(system, new);
        for _ in 0..2 {
            for (known, sum) in column[..=number].iter_mut().enumerate().map(|(k, sum)| (self.vector(k), sum)) {
                let share = system.dot(new, known, self.part, &self.weights);
                system.axpy(new, -share, known, self.part);
                *sum += share;
            }
        }
        let left = self.norm(system, new);
        // What rounding leaves of a vector that lies in the space.
        if left > 10.0 * system.epsilon() * whole {
            column[number + 1] = left;
            system.combine(new, &[(1.0 / left, new)], self.part);
        }
        column
    }
}

/// The rotation that takes `(a, b)` to `(r, 0)`: its cosine and sine.
pub(super) fn givens(a: f64, b: f64) -> (f64, f64) {
    let r = a.hypot(b);
    if r == 0.0 { (1.0, 0.0) } else { (a / r, b / r) }
}
