//! The tree of cells.
//!
//! In: places and strengths in the units of the frame. Out: the rows in the order of the tree, and its cells, each one before those
//! inside it. Never: a recursion, or a limit of its depth: rows that the bits of one key do not tell apart get new keys within the
//! box of those rows alone, until they are few, or all at one place.
//!
//! A cell's box is the box of its rows, not the cube of the octree: it is smaller, and more cells are far.

use super::order::{self, Box3, Keyed};
use super::rows::Rows;
use crate::real::Scalar;

/// Cells of no more rows are not divided (measured: see the module's documentation).
pub(super) const LEAF: usize = 24;

/// A cell: a range of rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<P> {
    /// The middle of the box.
    pub(super) centre: [P; 3],
    /// A distance from there that no row is beyond.
    pub(super) radius: P,
    pub(super) start: u32,
    pub(super) end: u32,
    /// The next cell that is not inside this one.
    pub(super) next: u32,
    /// Where the sum of all rows stands, if they are many and all at one place, or 0.
    pub(super) point: u32,
}

impl<P> Cell<P> {
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        (self.end - self.start) as usize
    }
}

/// The rows in order, and the cells.
#[derive(Debug, Default)]
pub(super) struct Tree<P> {
    pub(super) rows: Rows<P>,
    pub(super) cells: Vec<Cell<P>>,
    keyed: Vec<Keyed>,
    scratch: Vec<Keyed>,
    boxes: Vec<Box3<P>>,
}

impl<P: Scalar> Tree<P> {
    /// Makes the tree of at least one row; `places` and `strength` are scratch of the caller, in the frame.
    pub(super) fn build(&mut self, places: &[Vec<P>; 3], strength: &[P]) {
        self.divide(places);
        self.rows.take(places, strength, &self.keyed);
        self.bound();
    }

    /// Sorts the rows and finds the cells.
    fn divide(&mut self, places: &[Vec<P>; 3]) {
        let count = places[0].len();
        self.cells.clear();
        self.keyed.clear();
        self.keyed.extend(0..count as u64);
        let keyed = &mut self.keyed;
        let whole = order::box_of(places, keyed);
        order::sort(places, whole, keyed, &mut self.scratch);
        let mut pending = vec![(0, count)];
        while let Some((start, end)) = pending.pop() {
            let nothing = P::from_f64(0.0);
            let [start_, end_] = [start, end].map(|row| row as u32);
            let cell = Cell { centre: [nothing; 3], radius: nothing, start: start_, end: end_, next: 0, point: 0 };
            self.cells.push(cell);
            if end - start <= LEAF {
                continue;
            }
            let ends = |keyed: &[Keyed]| order::key(keyed[start]) ^ order::key(keyed[end - 1]);
            if ends(keyed) == 0 {
                let range = &mut keyed[start..end];
                let within = order::box_of(places, range);
                if within.is_point() {
                    continue;
                }
                order::sort(places, within, range, &mut self.scratch);
            }
            // The highest digit that is not the same in all of them.
            let shift = (31 - ends(keyed).leading_zeros()) / 3 * 3;
            let mut last = end;
            // The last range first: the stack turns the order around.
            while last > start {
                let digit = order::key(keyed[last - 1]) >> shift;
                let first = start + keyed[start..last].partition_point(|keyed| order::key(*keyed) >> shift < digit);
                pending.push((first, last));
                last = first;
            }
        }
        let mut open: Vec<usize> = Vec::new();
        for at in 0..self.cells.len() {
            while let Some(&outer) = open.last()
                && self.cells[outer].end <= self.cells[at].start
            {
                self.cells[outer].next = at as u32;
                open.pop();
            }
            open.push(at);
        }
        for outer in open {
            self.cells[outer].next = self.cells.len() as u32;
        }
    }

    /// Finds boxes and radii, the inner cells first.
    fn bound(&mut self) {
        let whole = Box3::at([P::from_f64(0.0); 3]);
        self.boxes.clear();
        self.boxes.resize(self.cells.len(), whole);
        for at in (0..self.cells.len()).rev() {
            let cell = self.cells[at];
            let range = cell.start as usize..cell.end as usize;
            let is_leaf = cell.next as usize == at + 1;
            let mut around = if is_leaf { Box3::at(self.rows.place(range.start)) } else { self.boxes[at + 1] };
            if is_leaf {
                for row in range.clone() {
                    around.hold(Box3::at(self.rows.place(row)));
                }
            } else {
                let mut inner = at + 1;
                while inner < cell.next as usize {
                    around.hold(self.boxes[inner]);
                    inner = self.cells[inner].next as usize;
                }
            }
            self.boxes[at] = around;
            let centre = around.centre();
            let mut radius = P::from_f64(0.0);
            if is_leaf {
                for row in range {
                    radius = radius.max(distance_squared(self.rows.place(row), centre));
                }
                radius = radius.sqrt();
            } else {
                let mut inner = at + 1;
                while inner < cell.next as usize {
                    let cell = &self.cells[inner];
                    radius = radius.max(distance_squared(cell.centre, centre).sqrt() + cell.radius);
                    inner = cell.next as usize;
                }
                // The corner of the box may be nearer than the farthest point of the spheres inside.
                radius = radius.min(distance_squared(around.high, centre).sqrt());
            }
            let cell = &mut self.cells[at];
            (cell.centre, cell.radius) = (centre, radius);
            if is_leaf && cell.count() > LEAF {
                cell.point = self.rows.sum_up(cell.start as usize..cell.end as usize) as u32;
            }
        }
    }
}

#[inline(always)]
pub(super) fn distance_squared<P: Scalar>(a: [P; 3], b: [P; 3]) -> P {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}
