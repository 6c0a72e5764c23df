//! The sum of everything for a list of groups.
//!
//! In: tree, groups, moments. Out: field or potential of the rows of the groups, in the order of the list. Never: a number of another
//! group.

use super::kernel::{self, Sources, least_square};
use super::local::{self, Expansions};
use super::moments::Moments;
use super::rows::{GROUP, Groups, load, store};
use super::terms::{Fifth, Fourth, Order, Sixth, Third, count};
use super::tree::Tree;
use super::walk::{InLanes, Lists, Near, Opening, walk};
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

impl<P: Scalar> Call<'_, P> {
    /// Sums for the groups of a list; `out` has [`GROUP`] rows for each.
    pub(super) fn sum<const POTENTIAL: bool>(&self, order: usize, isa: Isa, list: &[u32], out: &mut [&mut [P]; 4]) {
        match order {
            3 => P::with_lanes(isa, Task::<P, Third, POTENTIAL> { call: self, list, out, order: PhantomData }),
            4 => P::with_lanes(isa, Task::<P, Fourth, POTENTIAL> { call: self, list, out, order: PhantomData }),
            5 => P::with_lanes(isa, Task::<P, Fifth, POTENTIAL> { call: self, list, out, order: PhantomData }),
            _ => P::with_lanes(isa, Task::<P, Sixth, POTENTIAL> { call: self, list, out, order: PhantomData }),
        }
    }
}

struct Task<'a, 'o, P, O, const POTENTIAL: bool> {
    call: &'a Call<'a, P>,
    list: &'a [u32],
    out: &'a mut [&'o mut [P]; 4],
    order: PhantomData<O>,
}

impl<P: Scalar, O: Order, const POTENTIAL: bool> WithLanes<P> for Task<'_, '_, P, O, POTENTIAL> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let call = self.call;
        let mut lists = Lists::new();
        let mut sums = O::all(R::lit(0.0));
        for (number, list) in self.list.chunks(R::WIDTH).enumerate() {
            let groups = InLanes::<R, P>::new(call.groups, list);
            walk(call.tree, &groups, call.opening, !POTENTIAL, &mut lists);
            sums.as_mut().fill(R::lit(0.0));
            let softening_squared = R::splat(call.softening_squared);
            let moments = count(O::MOMENTS);
            for &(cell, mask) in &lists.far {
                let [x, y, z] = call.tree.cells[cell as usize].centre;
                let from = [
                    groups.numbers[0] - R::splat(x),
                    groups.numbers[1] - R::splat(y),
                    groups.numbers[2] - R::splat(z),
                ];
                let of_cell = &call.moments.all[cell as usize * moments..][..moments];
                local::add_cell::<P, R, O>(&mut sums, from, softening_squared, mask, of_cell);
            }
            let expansions = Expansions::of::<R, O>(&sums);
            for (lane, &group) in list.iter().enumerate() {
                let to = (number * R::WIDTH + lane) * GROUP;
                let near = &lists.near[lane];
                // Registers for four rows of lanes at once are there with AVX-512 only.
                if size_of::<R>() == 64 {
                    self::group::<P, R, O, 4, POTENTIAL>(call, group as usize, lane, near, &expansions, self.out, to);
                } else {
                    self::group::<P, R, O, 1, POTENTIAL>(call, group as usize, lane, near, &expansions, self.out, to);
                }
            }
        }
    }
}

/// Sums for the rows of one group.
#[inline(always)]
fn group<P: Scalar, R: Lanes<P>, O: Order, const U: usize, const POTENTIAL: bool>(
    call: &Call<'_, P>,
    group: usize,
    lane: usize,
    near: &Near,
    expansions: &Expansions<P>,
    out: &mut [&mut [P]; 4],
    to: usize,
) {
    let columns = &call.tree.rows.places;
    let middle = [0, 1, 2].map(|axis| R::splat(call.groups.numbers[axis][group]));
    let softening_squared = R::splat(call.softening_squared);
    let at_least = softening_squared.max(R::splat(least_square::<P>()));
    for block in (0..GROUP).step_by(U * R::WIDTH) {
        let first = group * GROUP + block;
        let mut rows = [[R::lit(0.0); 3]; U];
        let mut sums = [[R::lit(0.0); 4]; U];
        for k in 0..U {
            for axis in 0..3 {
                rows[k][axis] = load(&columns[axis], first + k * R::WIDTH);
            }
            let [x, y, z] = rows[k];
            let from = [x - middle[0], y - middle[1], z - middle[2]];
            sums[k] = expansions.at::<R, O, POTENTIAL>(lane, from);
        }
        for &cell in &near.cells {
            let (centre, moments) = (call.tree.cells[cell as usize].centre, &call.moments.near[cell as usize]);
            for k in 0..U {
                if const { O::DEGREE > 3 } {
                    kernel::add_cell::<P, R, true, POTENTIAL>(&mut sums[k], rows[k], at_least, centre, moments);
                } else {
                    kernel::add_cell::<P, R, false, POTENTIAL>(&mut sums[k], rows[k], at_least, centre, moments);
                }
            }
        }
        for range in &near.ranges {
            let range = range[0] as usize..range[1] as usize;
            let sources = Sources {
                places: [0, 1, 2].map(|axis| &columns[axis][range.clone()]),
                strength: &call.tree.rows.strength[range.clone()],
            };
            if POTENTIAL {
                for k in 0..U {
                    let behind = first as f64 - range.start as f64 + (k * R::WIDTH) as f64;
                    let behind = R::from_lanes(|lane| P::from_f64(behind + lane as f64));
                    kernel::add_potential(&mut sums[k][3], rows[k], softening_squared, sources, behind);
                }
            } else {
                kernel::add_field(&mut sums, &rows, at_least, sources);
            }
        }
        for k in 0..U {
            for (column, sum) in out.iter_mut().zip(sums[k]) {
                store(sum, column, to + block + k * R::WIDTH);
            }
        }
    }
}

/// Throwaway: what the walk finds.
#[cfg(test)]
impl<P: Scalar> Call<'_, P> {
    pub(super) fn count(&self, isa: Isa) -> String {
        P::with_lanes(isa, Count { call: self })
    }
}
#[cfg(test)]
struct Count<'a, P> {
    call: &'a Call<'a, P>,
}
#[cfg(test)]
impl<P: Scalar> WithLanes<P> for Count<'_, P> {
    type Output = String;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> String {
        let call = self.call;
        let mut lists = Lists::new();
        let (mut far, mut far_lanes, mut cells, mut rows, mut ranges) = (0, 0, 0, 0, 0);
        let all: Vec<u32> = (0..call.groups.count as u32).collect();
        let t = std::time::Instant::now();
        for list in all.chunks(R::WIDTH) {
            let groups = InLanes::<R, P>::new(call.groups, list);
            walk(call.tree, &groups, call.opening, true, &mut lists);
            far += lists.far.len() * R::WIDTH;
            for f in &lists.far {
                far_lanes += super::fast::bits::<P, R>(f.1).count_ones() as usize;
            }
            for n in &lists.near {
                cells += n.cells.len();
                ranges += n.ranges.len();
                rows += n.ranges.iter().map(|r| (r[1] - r[0]) as usize).sum::<usize>();
            }
        }
        let t = t.elapsed().as_secs_f64();
        let g = call.groups.count;
        format!(
            "cells {} per group: far {} of {}, near {}, ranges {}, rows {}; walk {:.1} ms",
            call.tree.cells.len(), far_lanes / g, far / g, cells / g, ranges / g, rows / g, t * 1e3
        )
    }
}
