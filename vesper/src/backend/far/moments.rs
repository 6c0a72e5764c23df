//! The moments of the cells.
//!
//! In: the tree. Out: for each cell about the middle of its box the sums `(-1)^n s d^m / m!` over its rows, for all powers m up to a
//! degree n (Taylor coefficients of the potential: Duan and Krasny 2001, J. Comput. Chem. 22, 184, equation 9), and the combinations of
//! them that the sum of a cell over rows takes. Never: a loop over pairs.
//!
//! Strengths have any sign, so the dipole about any centre counts and is kept.

use super::Parts;
use super::terms::{BY_FACTORIALS, DEGREES, Order, PRODUCT, STEPS, TERMS, count, index};
use super::tree::{CELLS, Cell, Tree};
use crate::real::Scalar;

/// Combinations for sums over rows: see [`near_moments`].
pub(super) const NEAR: usize = 24;

/// The moments of all cells.
#[derive(Debug, Default)]
pub(super) struct Moments<P> {
    /// Those of each cell, `count(MOMENTS)` numbers.
    pub(super) all: Vec<P>,
    pub(super) near: Vec<[P; NEAR]>,
}

impl<P: Scalar> Moments<P> {
    pub(super) fn find<O: Order>(&mut self, tree: &Tree<P>, threads: &impl Parts) {
        let terms = count(O::MOMENTS);
        let nothing = P::from_f64(0.0);
        self.all.clear();
        self.all.resize(terms * tree.cells.len(), nothing);
        self.near.clear();
        self.near.resize(tree.cells.len(), [nothing; NEAR]);
        let parts = self.all.chunks_mut(terms * CELLS).zip(self.near.chunks_mut(CELLS));
        threads.each(parts, |part, (all, near)| {
            for ((at, own), near) in (part * CELLS..).zip(all.chunks_mut(terms)).zip(near.iter_mut()) {
                if tree.cells[at].is_leaf(at) {
                    of_rows::<P, O>(tree, &tree.cells[at], own);
                    *near = near_moments(own);
                }
            }
        });
        for at in (0..tree.cells.len()).rev() {
            if !tree.cells[at].is_leaf(at) {
                let (before, after) = self.all.split_at_mut(terms * (at + 1));
                let own = &mut before[terms * at..];
                of_cells::<P, O>(tree, at, own, after);
                self.near[at] = near_moments(own);
            }
        }
    }
}

/// The moments of a cell of rows.
fn of_rows<P: Scalar, O: Order>(tree: &Tree<P>, cell: &Cell<P>, own: &mut [P]) {
    for row in cell.start as usize..cell.end as usize {
        let place = tree.rows.place(row);
        let powers = powers::<P, O>([0, 1, 2].map(|k| cell.centre[k] - place[k]));
        for (own, power) in own.iter_mut().zip(powers) {
            *own += power * tree.rows.strength[row];
        }
    }
    for (k, own) in own.iter_mut().enumerate() {
        *own = *own * P::from_f64(BY_FACTORIALS[k]);
    }
}

/// The moments of a cell of cells, from theirs, which stand after its own.
fn of_cells<P: Scalar, O: Order>(tree: &Tree<P>, at: usize, own: &mut [P], after: &[P]) {
    let terms = own.len();
    let cell = &tree.cells[at];
    let mut inner = at + 1;
    while inner < cell.next as usize {
        let centre = tree.cells[inner].centre;
        let mut powers = powers::<P, O>([0, 1, 2].map(|k| cell.centre[k] - centre[k]));
        for (k, power) in powers[..terms].iter_mut().enumerate() {
            *power = *power * P::from_f64(BY_FACTORIALS[k]);
        }
        let from = &after[terms * (inner - at - 1)..][..terms];
        for (m, &power) in powers[..terms].iter().enumerate() {
            // The binomial theorem, whose factors are those of the factorials.
            for (n, &from) in from[..count(O::MOMENTS - DEGREES[m])].iter().enumerate() {
                own[usize::from(PRODUCT[m][n])] += power * from;
            }
        }
        inner = tree.cells[inner].next as usize;
    }
}

/// All powers of a vector up to the degree of the moments.
#[inline(always)]
fn powers<P: Scalar, O: Order>(vector: [P; 3]) -> [P; TERMS] {
    let mut powers = [P::from_f64(1.0); TERMS];
    for k in 1..count(O::MOMENTS) {
        powers[k] = powers[STEPS[k].less] * vector[STEPS[k].axis];
    }
    powers
}

/// The combinations of the moments up to the third degree that [`super::kernel`] takes, whose formula explains them.
fn near_moments<P: Scalar>(moments: &[P]) -> [P; NEAR] {
    let of = |a, b, c| moments.get(index([a, b, c])).map_or(0.0, |moment: &P| moment.to_f64());
    let trace = of(2, 0, 0) + of(0, 2, 0) + of(0, 0, 2);
    let along = [
        3.0 * of(3, 0, 0) + of(1, 2, 0) + of(1, 0, 2),
        of(2, 1, 0) + 3.0 * of(0, 3, 0) + of(0, 1, 2),
        of(2, 0, 1) + of(0, 2, 1) + 3.0 * of(0, 0, 3),
    ];
    let numbers = [
        // -P0 and 3 T.
        -of(0, 0, 0),
        3.0 * trace,
        // -P1.
        -of(1, 0, 0),
        -of(0, 1, 0),
        -of(0, 0, 1),
        // 3 times the second derivatives of P2.
        6.0 * of(2, 0, 0),
        3.0 * of(1, 1, 0),
        3.0 * of(1, 0, 1),
        6.0 * of(0, 2, 0),
        3.0 * of(0, 1, 1),
        6.0 * of(0, 0, 2),
        // 3 times half the gradient of the Laplacian of P3.
        3.0 * along[0],
        3.0 * along[1],
        3.0 * along[2],
        // -15 times the coefficients of P3, as its gradient has them.
        -45.0 * of(3, 0, 0),
        -15.0 * of(2, 1, 0),
        -15.0 * of(2, 0, 1),
        -15.0 * of(1, 2, 0),
        -7.5 * of(1, 1, 1),
        -15.0 * of(1, 0, 2),
        -45.0 * of(0, 3, 0),
        -15.0 * of(0, 2, 1),
        -15.0 * of(0, 1, 2),
        -45.0 * of(0, 0, 3),
    ];
    numbers.map(P::from_f64)
}
