//! Which cells are far from which groups.
//!
//! In: the cells, and groups, one in each lane. Out: far cells with the lanes that they are far for; for each lane, cells that are near,
//! but summed as one, and ranges of rows. Never: a cell left out, or taken twice.
//!
//! Every cell is compared with all groups at once, and opened if it is too near for one of them; each lane sees the cells that it would
//! see alone, in the same order.
//!
//! A cell of weight S (the sum of the magnitudes of its strengths) and size b is taken as a whole where the field that its expansion
//! leaves out is small against the field A of the group (Salmon and Warren 1994, J. Comput. Phys. 111, 136; Dehnen 2014, Comput.
//! Astrophys. Cosmol. 1, 1, section 3.2): a heavy cell must be farther than a light one. With the fourth power of size over distance for
//! all orders, which the calibration of [`Opening::allowed`] makes up for:
//!
//! - far: `S (b + c R)^4 / d^6 <= allowed A`, d from the cell's centre to the middle of the group, R its radius; one expansion for the
//!   whole group, so its size counts, too, if not all of it (c), since few rows are at its rim;
//! - near: `S b^4 / d^6 <= near allowed A`, d from the cell's centre to the box of the group (groups: Barnes 1990, J. Comput. Phys. 87,
//!   161); a sum over the rows one by one.
//!
//! Besides, no radius may be larger than a part of the distance, since the series must converge for every row.

use super::fast::fused;
use super::rows::{Groups, NUMBERS, load};
use super::tree::Tree;
use crate::real::{Lanes, MAX_WIDTH, Mask, Scalar};
use core::marker::PhantomData;

/// A cell of fewer rows is summed row by row: that costs no more (counted in instructions), and is exact.
const FEW: usize = 5;
/// What the radius of a group counts beside the size of a cell.
const REACH: f64 = 0.7;
/// What the magnitudes of all shares count in the field of a group, where they cancel.
const CANCELLED: f64 = 0.1;

/// How near a cell may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    /// What one far cell's expansion may leave out, in parts of the field.
    pub(super) allowed: f64,
    /// The same of a near cell's.
    pub(super) near_allowed: f64,
    /// The largest part of the distance that the radii of cell and group may have together.
    pub(super) part: f64,
    /// The same of the radius of a near cell.
    pub(super) near_part: f64,
}

/// What a group sums over besides far cells.
#[derive(Debug, Default)]
pub(super) struct Near {
    pub(super) cells: Vec<u32>,
    /// Ranges of sources, from and to.
    pub(super) ranges: Vec<[u32; 2]>,
}

/// What a walk gives; kept for the next one.
#[derive(Debug)]
pub(super) struct Lists<M> {
    pub(super) far: Vec<(u32, M)>,
    pub(super) near: [Near; MAX_WIDTH],
    open: Open<M>,
}

impl<M: Copy> Lists<M> {
    pub(super) fn new() -> Self {
        Lists { far: Vec::new(), near: core::array::from_fn(|_| Near::default()), open: Open { outer: Vec::new() } }
    }
}

/// The cells that a walk is inside of: where each ends, and the lanes that go on from there.
#[derive(Debug)]
struct Open<M> {
    outer: Vec<(usize, M)>,
}

impl<M: Copy> Open<M> {
    /// Leaves all cells that end here; the lanes that go on.
    #[inline(always)]
    fn leave(&mut self, at: usize, mut lanes: M) -> M {
        while let Some(&(end, outer)) = self.outer.last()
            && end == at
        {
            lanes = outer;
            self.outer.pop();
        }
        lanes
    }
}

/// Groups in lanes.
#[derive(Clone, Copy)]
pub(super) struct InLanes<P, R: Lanes<P>> {
    pub(super) numbers: [R; NUMBERS],
    /// The lanes that hold a group.
    active: R::Mask,
    precision: PhantomData<P>,
}

impl<P: Scalar, R: Lanes<P>> InLanes<P, R> {
    /// The groups of a list, at least one, at most as many as there are lanes.
    #[inline(always)]
    pub(super) fn new(groups: &Groups<P>, list: &[u32]) -> Self {
        let mut numbers = [R::lit(0.0); NUMBERS];
        let mut column = [P::from_f64(0.0); MAX_WIDTH];
        for (lanes, from) in numbers.iter_mut().zip(&groups.numbers) {
            for (lane, number) in column.iter_mut().enumerate() {
                *number = from[list[lane.min(list.len() - 1)] as usize];
            }
            *lanes = load(&column, 0);
        }
        for (lane, number) in column.iter_mut().enumerate() {
            *number = P::from_f64(lane as f64);
        }
        let active = load::<P, R>(&column, 0).less(R::lit(list.len() as f64));
        InLanes { numbers, active, precision: PhantomData }
    }

    /// From the middle of each group to a place.
    #[inline(always)]
    fn to(&self, place: [P; 3]) -> [R; 3] {
        // Not by a closure, which nobody can tell to be inlined: see `real::registers`.
        let [x, y, z] = place;
        [R::splat(x) - self.numbers[0], R::splat(y) - self.numbers[1], R::splat(z) - self.numbers[2]]
    }

    /// The magnitude of the field at the groups, from strengths of cells alone.
    #[inline(always)]
    fn estimate(&self, tree: &Tree<P>, softening_squared: R, open: &mut Open<R::Mask>) -> R {
        let cells = &tree.cells[..];
        let zero = R::lit(0.0);
        let least = R::lit(1e-20);
        let mut sums = [zero; 4];
        let (mut at, mut lanes) = (0, self.active);
        while at < cells.len() {
            lanes = open.leave(at, lanes);
            let cell = &cells[at];
            let d = self.to(cell.centre);
            let d2 = fused(d[0], d[0], fused(d[1], d[1], d[2] * d[2]));
            let both = R::splat(cell.radius) + self.numbers[6];
            let next = cell.next as usize;
            let mut closed = lanes;
            if next == at + 1 {
                at = next;
            } else {
                closed = (both * both).less(d2) & lanes;
                let opened = lanes & !closed;
                if opened.bits() == 0 {
                    at = next;
                } else {
                    open.outer.push((next, lanes));
                    lanes = opened;
                    at += 1;
                    if closed.bits() == 0 {
                        continue;
                    }
                }
            }
            // A cell that the group is inside of, or next to, is spread over its size.
            let size = R::splat(cell.size);
            let u = super::fast::rsqrt::<P, R>(fused(size, size, d2 + softening_squared).max(least));
            let u = R::select(closed, u, zero);
            let v = u * u;
            let share = R::splat(cell.strength) * u * v;
            for axis in 0..3 {
                sums[axis] = fused(share, d[axis], sums[axis]);
            }
            sums[3] = fused(R::splat(cell.weight), v, sums[3]);
        }
        open.outer.clear();
        let magnitudes = sums[3] * R::lit(CANCELLED);
        let [x, y, z, _] = sums;
        fused(x, x, fused(y, y, fused(z, z, magnitudes * magnitudes))).sqrt()
    }

    /// Fills the lists. A cell of many rows at one place is one source if `points` says so.
    #[inline(always)]
    pub(super) fn walk(
        &self,
        tree: &Tree<P>,
        opening: Opening,
        softening_squared: P,
        points: bool,
        lists: &mut Lists<R::Mask>,
    ) {
        let Lists { far: far_cells, near: near_lists, open } = lists;
        far_cells.clear();
        for near in near_lists.iter_mut() {
            near.cells.clear();
            near.ranges.clear();
        }
        let field = self.estimate(tree, R::splat(softening_squared), open);
        let allowed = field * R::lit(opening.allowed);
        let near_allowed = field * R::lit(opening.near_allowed);
        let part2 = R::lit(opening.part * opening.part);
        let near_part2 = R::lit(opening.near_part * opening.near_part);
        let [_, _, _, half_x, half_y, half_z, reach] = self.numbers;
        let counted = reach * R::lit(REACH);
        let zero = R::lit(0.0);
        // Nearer than that, powers of the distance may leave the range of the numbers.
        let least = R::lit(if P::EPSILON > 1e-10 { 2f64.powi(-32) } else { 2f64.powi(-250) });
        let cells = &tree.cells[..];
        let (mut at, mut lanes) = (0, self.active);
        while at < cells.len() {
            lanes = open.leave(at, lanes);
            let cell = &cells[at];
            let (weight, size, radius) = (R::splat(cell.weight), R::splat(cell.size), R::splat(cell.radius));
            let [x, y, z] = self.to(cell.centre);
            let d2 = fused(x, x, fused(y, y, z * z));
            let (both, sum) = (radius + reach, size + counted);
            let sum2 = sum * sum;
            let far = (weight * (sum2 * sum2)).less_or_equal(allowed * (d2 * d2 * d2))
                & (both * both).less(d2 * part2)
                & least.less(d2)
                & lanes;
            if far.bits() != 0 {
                far_cells.push((at as u32, far));
            }
            let mut rest = lanes & !far;
            let next = cell.next as usize;
            if rest.bits() == 0 {
                at = next;
                continue;
            }
            if cell.count() >= FEW {
                let [x, y, z] =
                    [(x.abs() - half_x).max(zero), (y.abs() - half_y).max(zero), (z.abs() - half_z).max(zero)];
                let d2 = fused(x, x, fused(y, y, z * z));
                let size2 = size * size;
                let near = (weight * (size2 * size2)).less_or_equal(near_allowed * (d2 * d2 * d2))
                    & (radius * radius).less(d2 * near_part2)
                    & least.less(d2)
                    & rest;
                for lane in each(near.bits()) {
                    near_lists[lane].cells.push(at as u32);
                }
                rest = rest & !near;
            }
            let bits = rest.bits();
            if next == at + 1 {
                let range =
                    if points && cell.point != 0 { [cell.point, cell.point + 1] } else { [cell.start, cell.end] };
                for lane in each(bits) {
                    near_lists[lane].add(range);
                }
                at = next;
            } else if bits == 0 {
                at = next;
            } else {
                open.outer.push((next, lanes));
                lanes = rest;
                at += 1;
            }
        }
        open.outer.clear();
    }
}

impl Near {
    #[inline(always)]
    fn add(&mut self, range: [u32; 2]) {
        match self.ranges.last_mut() {
            Some(last) if last[1] == range[0] => last[1] = range[1],
            _ => self.ranges.push(range),
        }
    }
}

/// The lanes whose bits are set.
#[inline(always)]
fn each(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        if bits == 0 {
            return None;
        }
        // No more lanes than there are lists: says so to the compiler.
        let lane = bits.trailing_zeros() as usize % MAX_WIDTH;
        bits &= bits - 1;
        Some(lane)
    })
}
