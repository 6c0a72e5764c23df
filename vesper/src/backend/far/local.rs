//! Far cells: one Taylor expansion of their potential about the middle of each group.
//!
//! In: moments of a cell, and the places of groups, one in each lane. Out: the derivatives of the potential at the middle of each
//! group, and from them field and potential at its rows. Never: a distance that is not larger than both radii together.
//!
//! With x from the cell to the group, `r^2 = x^2 + e^2`, `u = 1/r`, the potential of the cell and its derivatives are
//!
//! ```text
//! L_n = sum over m of D_(n+m) M_m,    D_k = (d/dx)^k u
//! ```
//!
//! (Warren and Salmon 1995, Comput. Phys. Commun. 87, 266; Dehnen 2002, J. Comput. Phys. 179, 27, equation 3). The derivatives come
//! from those of `g_j = (-1)^j (2j-1)!! u^(2j+1)`, the j-th derivative of u by `r^2/2`, one axis after the other:
//! `D^j_(k+1) = x D^(j+1)_k + k D^(j+1)_(k-1)` (McMurchie and Davidson 1978, J. Comput. Phys. 26, 218, equations 4.6 to 4.8). They are
//! kept divided by `u^(2j)`, so that no number is larger than the largest derivative: with `y = x u^2`, `v = u^2` the step becomes
//! `y E_k + k v E_(k-1)`.

use super::fast::{fused, rsqrt};
use super::terms::{BY_FACTORIALS, DEGREES, Order, PRODUCT, STEPS, TERMS, count, each_term, index};
use crate::real::{Lanes, MAX_WIDTH, Scalar};

/// Odd factorials with the sign of a derivative: `(-1)^j (2j-1)!!`.
const ODD: [f64; 6] = [1.0, -1.0, 3.0, -15.0, 105.0, -945.0];

/// Adds a cell's share to the derivatives of the lanes that the mask holds for.
#[inline(always)]
pub(super) fn add_cell<P: Scalar, R: Lanes<P>, O: Order>(
    sums: &mut O::Terms<R>,
    x: [R; 3],
    softening_squared: R,
    mask: R::Mask,
    moments: &[P],
) {
    let derivatives = derivatives::<P, R, O>(x, softening_squared, mask);
    let (sums, derivatives) = (sums.as_mut(), derivatives.as_ref());
    let moments = &moments[..count(O::MOMENTS)];
    each_term!(N below count(O::DEGREE), {
        // The potential has one degree less than there could be: the field does not need the highest moment.
        let terms = if N == 0 { count(O::MOMENTS) } else { count(O::DEGREE - DEGREES[N]) };
        let mut sum = sums[N];
        for m in 0..terms {
            sum = fused(derivatives[usize::from(PRODUCT[N][m])], R::splat(moments[m]), sum);
        }
        sums[N] = sum;
    });
}

/// All derivatives of the softened potential of a row; 0 where the mask does not hold.
#[inline(always)]
fn derivatives<P: Scalar, R: Lanes<P>, O: Order>(x: [R; 3], softening_squared: R, mask: R::Mask) -> O::Terms<R> {
    let r2 = fused(x[0], x[0], fused(x[1], x[1], fused(x[2], x[2], softening_squared)));
    let u = R::select(mask, rsqrt(r2), R::lit(0.0));
    let v = u * u;
    let y = [x[0] * v, x[1] * v, x[2] * v];
    let times = [R::lit(0.0), v, v + v, v + v + v, v * R::lit(4.0)];
    let mut all = O::all(u);
    let e = all.as_mut();
    e[0] = u * R::lit(ODD[O::DEGREE]);
    each_term!(@ J, O::DEGREE, {
        each_term!(K down from count(O::DEGREE - J), {
            derivative::<R, P, K>(e, y, &times);
        });
        e[0] = u * R::lit(ODD[J]);
    }, 4 3 2 1);
    each_term!(K down from count(O::DEGREE), {
        derivative::<R, P, K>(e, y, &times);
    });
    e[0] = u;
    all
}

/// One step of the derivatives, in place.
#[inline(always)]
fn derivative<R: Lanes<P>, P, const K: usize>(e: &mut [R], y: [R; 3], times: &[R; 5]) {
    let step = const { STEPS[K] };
    let mut derivative = y[step.axis] * e[step.less];
    if step.factor > 0 {
        derivative = fused(times[step.factor], e[step.twice_less], derivative);
    }
    e[K] = derivative;
}

/// The expansions of the groups of all lanes, each number divided by its factorials.
pub(super) struct Expansions<P>([[P; MAX_WIDTH]; TERMS]);

impl<P: Scalar> Expansions<P> {
    #[inline(always)]
    pub(super) fn of<R: Lanes<P>, O: Order>(sums: &O::Terms<R>) -> Self {
        let mut numbers = [[P::from_f64(0.0); MAX_WIDTH]; TERMS];
        for (k, sum) in sums.as_ref().iter().enumerate() {
            let by = R::lit(BY_FACTORIALS[k]);
            super::rows::store(*sum * by, &mut numbers[k], 0);
        }
        Expansions(numbers)
    }

    /// Field and potential of the group in a lane, at rows so far from its middle.
    #[inline(always)]
    pub(super) fn at<R: Lanes<P>, O: Order, const POTENTIAL: bool>(&self, lane: usize, from: [R; 3]) -> [R; 4] {
        let mut powers = O::all(R::lit(1.0));
        let powers = powers.as_mut();
        let zero = R::lit(0.0);
        let mut sums = [zero; 4];
        for n in 0..count(O::DEGREE) {
            if n > 0 {
                powers[n] = powers[STEPS[n].less] * from[STEPS[n].axis];
            }
            if POTENTIAL {
                sums[3] = fused(powers[n], R::splat(self.0[n][lane]), sums[3]);
            } else if DEGREES[n] < O::DEGREE {
                let own = super::terms::POWERS[n];
                for axis in 0..3 {
                    let mut more = own;
                    more[axis] += 1;
                    // The derivative of a power has the power as a factor.
                    let factor = P::from_f64(more[axis] as f64) * self.0[index(more)][lane];
                    sums[axis] = fused(powers[n], R::splat(factor), sums[axis]);
                }
            }
        }
        sums
    }
}
