//! Near rows and near cells: their sums over the rows of a group, row by row.
//!
//! In: rows of a group in lanes; ranges of rows, or cells. Out: what they add to field or potential. Never: a share of a row in its own
//! sum.
//!
//! A cell at x from a row, `r^2 = x^2 + e^2`, `u = 1/r`, `y = x u^2`, `v = u^2`: with the homogeneous polynomials
//! `P_n(y) = sum of M_m y^m over |m| = n` its potential is (contracting the derivatives of u with the moments, traces included)
//!
//! ```text
//! u [P0 - P1 - v T + 3 (P2 + v L) - 15 P3],    T = laplacian P2 / 2,  L = laplacian P3 / 2
//! ```
//!
//! and the gradient of that, since gradients of homogeneous polynomials give back the polynomials (Euler),
//!
//! ```text
//! u (v W + y S),   W = a + B + v l + C,   S = -P0 + 3 v T + y (-3 a - 5/2 B - 5 v l - 7/3 C)
//! a = -grad P1,  B = 3 grad P2,  l = 3 grad L,  C = -15 grad P3
//! ```

use super::fast::{fused, rsqrt};
use super::moments::NEAR;
use crate::real::{Lanes, Scalar};

/// Columns of sources.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a, P> {
    pub(super) places: [&'a [P]; 3],
    pub(super) strength: &'a [P],
}

/// The smallest square of a distance that is told from 0: its power of -3/2 is within the range of the numbers, even times the strengths
/// of all rows.
#[inline(always)]
pub(super) fn least_square<P: Scalar>() -> P {
    P::from_f64(if P::EPSILON > 1e-10 { 2f64.powi(-68) } else { 2f64.powi(-600) })
}

/// Adds the field of a range of rows to the rows in lanes.
///
/// The softening is not below [`least_square`]: a row at the place of another then adds 0 times a finite number.
#[inline(always)]
pub(super) fn add_field<P: Scalar, R: Lanes<P>, const U: usize>(
    sums: &mut [[R; 4]; U],
    rows: &[[R; 3]; U],
    softening_squared: R,
    sources: Sources<'_, P>,
) {
    // A sum of its own for each range: fewer roundings of large sums.
    let mut own = [[R::lit(0.0); 3]; U];
    let [x, y, z] = sources.places;
    for (((&x, &y), &z), &strength) in x.iter().zip(y).zip(z).zip(sources.strength) {
        let (x, y, z, strength) = (R::splat(x), R::splat(y), R::splat(z), R::splat(strength));
        for k in 0..U {
            let d = [x - rows[k][0], y - rows[k][1], z - rows[k][2]];
            let r2 = fused(d[0], d[0], fused(d[1], d[1], fused(d[2], d[2], softening_squared)));
            let w = rsqrt(r2);
            let share = (strength * w) * (w * w);
            for axis in 0..3 {
                own[k][axis] = fused(share, d[axis], own[k][axis]);
            }
        }
    }
    for k in 0..U {
        for axis in 0..3 {
            sums[k][axis] += own[k][axis];
        }
    }
}

/// Adds the potential of a range of rows to the rows in lanes; of the range, the row that is `behind` by 0 adds nothing.
#[inline(always)]
pub(super) fn add_potential<P: Scalar, R: Lanes<P>>(
    sum: &mut R,
    row: [R; 3],
    softening_squared: R,
    sources: Sources<'_, P>,
    mut behind: R,
) {
    let (zero, one) = (R::lit(0.0), R::lit(1.0));
    let [x, y, z] = sources.places;
    for (((&x, &y), &z), &strength) in x.iter().zip(y).zip(z).zip(sources.strength) {
        let d = [R::splat(x) - row[0], R::splat(y) - row[1], R::splat(z) - row[2]];
        let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + softening_squared;
        let nothing = behind.equal(zero) | r2.less_or_equal(zero);
        *sum += R::select(nothing, zero, R::splat(strength) / r2.sqrt());
        behind -= one;
    }
}

/// Adds field or potential of a cell to the rows in lanes.
#[inline(always)]
pub(super) fn add_cell<P: Scalar, R: Lanes<P>, const THIRD: bool, const POTENTIAL: bool>(
    sums: &mut [R; 4],
    row: [R; 3],
    softening_squared: R,
    centre: [P; 3],
    moments: &[P; NEAR],
) {
    let x = [row[0] - R::splat(centre[0]), row[1] - R::splat(centre[1]), row[2] - R::splat(centre[2])];
    let r2 = fused(x[0], x[0], fused(x[1], x[1], fused(x[2], x[2], softening_squared)));
    let u = rsqrt(r2);
    let v = u * u;
    let y = [x[0] * v, x[1] * v, x[2] * v];
    // The second degree, B.
    let b = [
        fused(R::splat(moments[5]), y[0], fused(R::splat(moments[6]), y[1], R::splat(moments[7]) * y[2])),
        fused(R::splat(moments[6]), y[0], fused(R::splat(moments[8]), y[1], R::splat(moments[9]) * y[2])),
        fused(R::splat(moments[7]), y[0], fused(R::splat(moments[9]), y[1], R::splat(moments[10]) * y[2])),
    ];
    // The third degree, C.
    let mut c = [R::lit(0.0); 3];
    if THIRD {
        let twice = [y[0] + y[0], y[1] + y[1]];
        let [xx, xy, xz] = [y[0] * y[0], twice[0] * y[1], twice[0] * y[2]];
        let [yy, yz, zz] = [y[1] * y[1], twice[1] * y[2], y[2] * y[2]];
        let products = [xx, xy, xz, yy, yz, zz];
        c = [
            product(products, moments, [14, 15, 16, 17, 18, 19]),
            product(products, moments, [15, 17, 18, 20, 21, 22]),
            product(products, moments, [16, 18, 19, 21, 22, 23]),
        ];
    }
    if POTENTIAL {
        // The same polynomials, from their gradients.
        let mut terms = fused(v, R::splat(moments[1]) * R::lit(-1.0 / 3.0), R::lit(0.0) - R::splat(moments[0]));
        for axis in 0..3 {
            let mut own = fused(b[axis], R::lit(0.5), R::splat(moments[2 + axis]));
            if THIRD {
                own = fused(c[axis], R::lit(1.0 / 3.0), fused(v, R::splat(moments[11 + axis]), own));
            }
            terms = fused(y[axis], own, terms);
        }
        sums[3] = fused(u, terms, sums[3]);
        return;
    }
    let mut s = fused(v, R::splat(moments[1]), R::splat(moments[0]));
    let mut w = [R::lit(0.0); 3];
    for axis in 0..3 {
        let a = R::splat(moments[2 + axis]);
        w[axis] = a + b[axis];
        let mut own = fused(b[axis], R::lit(-2.5), a * R::lit(-3.0));
        if THIRD {
            let l = v * R::splat(moments[11 + axis]);
            w[axis] = w[axis] + l + c[axis];
            own = fused(c[axis], R::lit(-7.0 / 3.0), fused(l, R::lit(-5.0), own));
        }
        s = fused(y[axis], own, s);
    }
    for axis in 0..3 {
        sums[axis] = fused(u, fused(v, w[axis], y[axis] * s), sums[axis]);
    }
}

/// The sum of six products, with the moments that stand at some places.
#[inline(always)]
fn product<P: Scalar, R: Lanes<P>>(products: [R; 6], moments: &[P; NEAR], at: [usize; 6]) -> R {
    let mut sum = products[5] * R::splat(moments[at[5]]);
    for k in 0..5 {
        sum = fused(products[4 - k], R::splat(moments[at[4 - k]]), sum);
    }
    sum
}
