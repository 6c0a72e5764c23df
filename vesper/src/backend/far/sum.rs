//! The sum of everything for a list of groups.
//!
//! In: tree, groups, moments. Out: field or potential of the rows of the groups, in the order of the list. Never: a number of another
//! group.

use super::kernel::{self, Sources, least_square};
use super::local::{self, Expansions};
use super::moments::Moments;
use super::rows::{GROUP, Groups, load, store};
use super::terms::{Fifth, Fourth, Order, Third, count};
use super::tree::Tree;
use super::walk::{InLanes, Lists, Near, Opening};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use core::marker::PhantomData;

/// All that a sum reads.
#[derive(Clone, Copy)]
pub(super) struct Call<'a, P> {
    pub(super) tree: &'a Tree<P>,
    pub(super) groups: &'a Groups<P>,
    pub(super) moments: &'a Moments<P>,
    pub(super) opening: Opening,
    pub(super) softening_squared: P,
}

/// Columns that sums are written to: the field, the potential.
pub(super) type Out<'a, P> = [&'a mut [P]; 4];

impl<P: Scalar> Call<'_, P> {
    /// Sums for the groups of a list; `out` has [`GROUP`] rows for each.
    pub(super) fn sum<const POTENTIAL: bool>(&self, degree: usize, isa: Isa, list: &[u32], out: &mut Out<'_, P>) {
        match degree {
            3 => P::with_lanes(isa, Task::<P, Third, POTENTIAL> { call: self, list, out, order: PhantomData }),
            4 => P::with_lanes(isa, Task::<P, Fourth, POTENTIAL> { call: self, list, out, order: PhantomData }),
            _ => P::with_lanes(isa, Task::<P, Fifth, POTENTIAL> { call: self, list, out, order: PhantomData }),
        }
    }
}

struct Task<'a, 'o, P, O, const POTENTIAL: bool> {
    call: &'a Call<'a, P>,
    list: &'a [u32],
    out: &'a mut Out<'o, P>,
    order: PhantomData<O>,
}

impl<P: Scalar, O: Order, const POTENTIAL: bool> WithLanes<P> for Task<'_, '_, P, O, POTENTIAL> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let Task { call, list, out, .. } = self;
        let mut lists = Lists::new();
        let mut sums = O::all(R::lit(0.0));
        for (number, list) in list.chunks(R::WIDTH).enumerate() {
            let groups = InLanes::<P, R>::new(call.groups, list);
            groups.walk(call.tree, call.opening, call.softening_squared, !POTENTIAL, &mut lists);
            sums.as_mut().fill(R::lit(0.0));
            let softening_squared = R::splat(call.softening_squared);
            let moments = count(O::MOMENTS);
            for &(cell, lanes) in &lists.far {
                let [x, y, z] = call.tree.cells[cell as usize].centre;
                let [gx, gy, gz, ..] = groups.numbers;
                let from = [gx - R::splat(x), gy - R::splat(y), gz - R::splat(z)];
                let of_cell = &call.moments.all[cell as usize * moments..][..moments];
                local::add_cell::<P, R, O>(&mut sums, from, softening_squared, lanes, of_cell);
            }
            let expansions = Expansions::of::<R, O>(&sums);
            for (lane, &group) in list.iter().enumerate() {
                let one = One::<P, O> {
                    call,
                    group: group as usize,
                    near: &lists.near[lane],
                    expansions: &expansions,
                    lane,
                    to: (number * R::WIDTH + lane) * GROUP,
                    order: PhantomData,
                };
                // There are registers for several lanes of rows at once with AVX-512 only.
                match size_of::<R>() {
                    64 if GROUP / R::WIDTH >= 4 => one.sum::<R, 4, POTENTIAL>(out),
                    64 => one.sum::<R, 2, POTENTIAL>(out),
                    _ => one.sum::<R, 1, POTENTIAL>(out),
                }
            }
        }
    }
}

/// One group.
struct One<'a, P, O> {
    call: &'a Call<'a, P>,
    group: usize,
    near: &'a Near,
    expansions: &'a Expansions<P>,
    /// Of the expansions.
    lane: usize,
    /// Its first row in the columns of results.
    to: usize,
    order: PhantomData<O>,
}

impl<P: Scalar, O: Order> One<'_, P, O> {
    /// Sums for all rows, so many lanes of them at a time.
    #[inline(always)]
    fn sum<R: Lanes<P>, const U: usize, const POTENTIAL: bool>(&self, out: &mut Out<'_, P>) {
        let tree = self.call.tree;
        let columns = &tree.rows.places;
        let [x, y, z, ..] = &self.call.groups.numbers;
        let middle = [R::splat(x[self.group]), R::splat(y[self.group]), R::splat(z[self.group])];
        let softening_squared = R::splat(self.call.softening_squared);
        let at_least = softening_squared.max(R::splat(least_square::<P>()));
        for block in (0..GROUP).step_by(U * R::WIDTH) {
            let first = self.group * GROUP + block;
            let mut rows = [[R::lit(0.0); 3]; U];
            let mut sums = [[R::lit(0.0); 4]; U];
            for k in 0..U {
                for axis in 0..3 {
                    rows[k][axis] = load(&columns[axis], first + k * R::WIDTH);
                }
                let [x, y, z] = rows[k];
                let from = [x - middle[0], y - middle[1], z - middle[2]];
                sums[k] = self.expansions.at::<R, O, POTENTIAL>(self.lane, from);
            }
            for &cell in &self.near.cells {
                let (centre, moments) = (tree.cells[cell as usize].centre, &self.call.moments.near[cell as usize]);
                for k in 0..U {
                    if const { O::DEGREE > 3 } {
                        kernel::add_cell::<P, R, true, POTENTIAL>(&mut sums[k], rows[k], at_least, centre, moments);
                    } else {
                        kernel::add_cell::<P, R, false, POTENTIAL>(&mut sums[k], rows[k], at_least, centre, moments);
                    }
                }
            }
            for &[start, end] in &self.near.ranges {
                let (start, end) = (start as usize, end as usize);
                let sources = Sources {
                    places: [&columns[0][start..end], &columns[1][start..end], &columns[2][start..end]],
                    strength: &tree.rows.strength[start..end],
                };
                if POTENTIAL {
                    for k in 0..U {
                        let behind = (first + k * R::WIDTH) as f64 - start as f64;
                        let lanes = R::from_lanes(|lane| P::from_f64(lane as f64)) + R::lit(behind);
                        kernel::add_potential(&mut sums[k][3], rows[k], softening_squared, sources, lanes);
                    }
                } else {
                    kernel::add_field(&mut sums, &rows, at_least, sources);
                }
            }
            for (k, sums) in sums.into_iter().enumerate() {
                for (column, sum) in out.iter_mut().zip(sums) {
                    store(sum, column, self.to + block + k * R::WIDTH);
                }
            }
        }
    }
}
