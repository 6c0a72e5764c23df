//! Which cells are far from which groups.
//!
//! In: the cells, and groups, one in each lane. Out: far cells with the lanes that they are far for; for each lane, cells that are near,
//! but summed as one, and ranges of rows. Never: a cell left out, or taken twice.
//!
//! Every cell is compared with all groups at once, and opened if it is too near for one of them; each lane sees the cells that it would
//! see alone, in the same order.
//!
//! - far: `radius of the cell + radius of the group < opening * distance of their middles`; both series, in the cell and in the group, have
//!   terms that fall by less than that factor (Dehnen 2002, section 3.1);
//! - near: `radius of the cell < near opening * distance of its middle from the box of the group` (Barnes and Hut 1986, Nature 324, 446,
//!   for groups: Barnes 1990, J. Comput. Phys. 87, 161).

use super::fast::bits;
use super::rows::{Groups, NUMBERS, load};
use super::tree::Tree;
use crate::real::{Lanes, MAX_WIDTH, Scalar};

/// A cell of fewer rows is summed row by row: that costs no more (counted in instructions), and is exact.
const FEW: usize = 5;

/// How near a cell may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    /// For one expansion in the whole group.
    pub(super) far: f64,
    /// For a sum over the rows of the group.
    pub(super) near: f64,
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
    open: Vec<(u32, M)>,
}

impl<M> Lists<M> {
    pub(super) fn new() -> Self {
        Lists { far: Vec::new(), near: core::array::from_fn(|_| Near::default()), open: Vec::new() }
    }
}

/// Groups in lanes.
#[derive(Clone, Copy)]
pub(super) struct InLanes<R: Lanes<P>, P> {
    pub(super) numbers: [R; NUMBERS],
    /// The lanes that hold a group.
    pub(super) active: R::Mask,
    _precision: core::marker::PhantomData<P>,
}

impl<P: Scalar, R: Lanes<P>> InLanes<R, P> {
    /// The groups of a list, at most as many as there are lanes.
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
        InLanes { numbers, active, _precision: core::marker::PhantomData }
    }
}

/// Fills the lists.
#[inline(always)]
pub(super) fn walk<P: Scalar, R: Lanes<P>>(
    tree: &Tree<P>,
    groups: &InLanes<R, P>,
    opening: Opening,
    points_alone: bool,
    lists: &mut Lists<R::Mask>,
) {
    lists.far.clear();
    for near in &mut lists.near {
        near.cells.clear();
        near.ranges.clear();
    }
    lists.open.clear();
    let [gx, gy, gz, hx, hy, hz, reach] = groups.numbers;
    let zero = R::lit(0.0);
    let far2 = R::lit(opening.far * opening.far);
    let near2 = R::lit(opening.near * opening.near);
    // Nearer than that, powers of the distance may leave the range of the numbers.
    let least = R::lit(if P::EPSILON > 1e-10 { 2f64.powi(-32) } else { 2f64.powi(-250) });
    let cells = &tree.cells[..];
    let (mut at, mut mask) = (0, groups.active);
    let mut until = cells.len();
    loop {
        // The end of a cell that was opened: the lanes that it was closed for go on.
        while at == until {
            let Some((_, outer)) = lists.open.pop() else { return };
            mask = outer;
            until = lists.open.last().map_or(cells.len(), |open| open.0 as usize);
        }
        let cell = &cells[at];
        let [dx, dy, dz] =
            [R::splat(cell.centre[0]) - gx, R::splat(cell.centre[1]) - gy, R::splat(cell.centre[2]) - gz];
        let d2 = dx * dx + dy * dy + dz * dz;
        let radius = R::splat(cell.radius);
        let both = radius + reach;
        let far = (both * both).less(d2 * far2) & least.less(d2) & mask;
        let [bx, by, bz] =
            [(dx.abs() - hx).max(zero), (dy.abs() - hy).max(zero), (dz.abs() - hz).max(zero)];
        let b2 = bx * bx + by * by + bz * bz;
        let near = (radius * radius).less(b2 * near2) & least.less(b2) & mask & !far;
        if bits::<P, R>(far) != 0 {
            lists.far.push((at as u32, far));
        }
        let mut rest = mask & !far;
        if cell.count() >= FEW {
            let mut left = bits::<P, R>(near);
            while left != 0 {
                lists.near[left.trailing_zeros() as usize % MAX_WIDTH].cells.push(at as u32);
                left &= left - 1;
            }
            rest = rest & !near;
        }
        let mut left = bits::<P, R>(rest);
        let next = cell.next as usize;
        if next != at + 1 && left != 0 {
            lists.open.push((next as u32, mask));
            (until, mask) = (next, rest);
            at += 1;
            continue;
        }
        let range = if cell.point != 0 && points_alone { [cell.point, cell.point + 1] } else { [cell.start, cell.end] };
        while left != 0 {
            let ranges = &mut lists.near[left.trailing_zeros() as usize % MAX_WIDTH].ranges;
            match ranges.last_mut() {
                Some(last) if last[1] == range[0] => last[1] = range[1],
                _ => ranges.push(range),
            }
            left &= left - 1;
        }
        at = next;
    }
}
