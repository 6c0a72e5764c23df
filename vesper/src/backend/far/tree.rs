//! The tree of cells.
//!
//! In: places and strengths in the units of the frame. Out: the rows in the order of the tree, and its cells, each one before those
//! inside it. Never: a recursion, or a limit of its depth: rows that the bits of one key do not tell apart get new keys within the
//! box of those rows alone, until they are few, or all at one place.
//!
//! A cell's box is the box of its rows, not the cube of the octree: it is smaller, and more cells are far.

use super::order::{self, Box3, Keyed};
use super::rows::Rows;
use super::{OneThread, Parts, SHARE, Source};
use crate::real::Scalar;

/// Cells of no more rows are not divided (measured: see the module's documentation).
pub(super) const LEAF: usize = 48;

/// Cells that one part of the work takes.
pub(super) const CELLS: usize = SHARE / 32;

/// A cell: a range of rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<P> {
    /// The mean of its rows' places, by the magnitude of their strengths.
    pub(super) centre: [P; 3],
    /// A distance from there that no row is beyond.
    pub(super) radius: P,
    /// The sum of the magnitudes of the strengths.
    pub(super) weight: P,
    /// The sum of the strengths.
    pub(super) strength: P,
    /// The mean of the fourth power of the rows' distances from the centre, its fourth root: what the terms left out go by.
    pub(super) size: P,
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

    /// Whether there is no cell inside this one, which is at that number.
    #[inline(always)]
    pub(super) fn is_leaf(&self, at: usize) -> bool {
        self.next as usize == at + 1
    }
}

/// The rows in order, and the cells.
#[derive(Debug, Default)]
pub(super) struct Tree<P> {
    pub(super) rows: Rows<P>,
    pub(super) cells: Vec<Cell<P>>,
    /// The caller's rows in the order of the tree before.
    before: Vec<Source<P>>,
    /// Which of those each row is.
    keyed: Vec<Keyed>,
    scratch: Vec<Keyed>,
    boxes: Vec<Box3<P>>,
}

impl<P: Scalar> Tree<P> {
    /// Makes the tree of at least one row of the caller, which are all in the box.
    pub(super) fn build(&mut self, sources: &[Source<P>], around: Box3<P>, threads: &impl Parts) {
        let count = sources.len();
        let origin = &mut self.rows.origin;
        if origin.len() != count {
            origin.clear();
            origin.extend(0..count as u32);
        }
        // In the order of the tree before: what comes after meets rows that lie together, and this alone does not.
        self.before.resize(count, [P::from_f64(0.0); 4]);
        threads.each(self.before.chunks_mut(SHARE).zip(origin.chunks(SHARE)), |_, (own, origin)| {
            for (own, &row) in own.iter_mut().zip(*origin) {
                *own = sources[row as usize];
            }
        });
        self.keyed.clear();
        self.keyed.extend(0..count as u64);
        order::sort(&self.before, origin, around, &mut self.keyed, &mut self.scratch, threads);
        self.divide();
        self.rows.take(&self.before, &self.keyed, threads);
        self.bound(threads);
    }

    /// Finds the cells, and sorts rows that the keys do not tell apart.
    fn divide(&mut self) {
        let count = self.keyed.len();
        let (sources, keyed) = (&self.before, &mut self.keyed);
        self.cells.clear();
        let mut pending = vec![(0, count)];
        while let Some((start, end)) = pending.pop() {
            let nothing = P::from_f64(0.0);
            let [start_, end_] = [start, end].map(|row| row as u32);
            let cell = Cell {
                centre: [nothing; 3],
                radius: nothing,
                weight: nothing,
                strength: nothing,
                size: nothing,
                start: start_,
                end: end_,
                next: 0,
                point: 0,
            };
            self.cells.push(cell);
            if end - start <= LEAF {
                continue;
            }
            let ends = |keyed: &[Keyed]| order::key(keyed[start]) ^ order::key(keyed[end - 1]);
            if ends(keyed) == 0 {
                let range = &mut keyed[start..end];
                let within = order::box_of(sources, range);
                if within.is_point() {
                    continue;
                }
                order::sort(sources, &self.rows.origin, within, range, &mut self.scratch, &OneThread);
                if ends(keyed) == 0 {
                    // Numbers of more digits than keys are made from tell them apart, keys never will: a cell of many rows.
                    continue;
                }
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

    /// Finds boxes, centres and sizes, the inner cells first.
    fn bound(&mut self, threads: &impl Parts) {
        self.boxes.clear();
        self.boxes.resize(self.cells.len(), Box3::at([P::from_f64(0.0); 3]));
        let rows = &self.rows;
        let parts = self.cells.chunks_mut(CELLS).zip(self.boxes.chunks_mut(CELLS));
        threads.each(parts, |part, (cells, boxes)| {
            for (at, (cell, around)) in (part * CELLS..).zip(cells.iter_mut().zip(boxes.iter_mut())) {
                if cell.is_leaf(at) {
                    *around = cell.bound(rows);
                }
            }
        });
        for at in (0..self.cells.len()).rev() {
            let mut cell = self.cells[at];
            if !cell.is_leaf(at) {
                self.bound_outer(&mut cell, at);
            } else if cell.count() > LEAF {
                cell.point = self.rows.sum_up(cell.start as usize..cell.end as usize) as u32;
            }
            self.cells[at] = cell;
        }
    }

    /// A cell of cells.
    fn bound_outer(&mut self, cell: &mut Cell<P>, at: usize) {
        let mut around = self.boxes[at + 1];
        let mut inner = at + 1;
        while inner < cell.next as usize {
            around.hold(self.boxes[inner]);
            inner = self.cells[inner].next as usize;
        }
        let mut middle = Middle::new(around.low);
        inner = at + 1;
        while inner < cell.next as usize {
            let own = &self.cells[inner];
            cell.strength += own.strength;
            middle.add(own.centre, own.weight);
            inner = own.next as usize;
        }
        (cell.weight, cell.centre) = (middle.weight, middle.place(around));
        let nothing = P::from_f64(0.0);
        let (mut radius, mut fourths) = (nothing, nothing);
        inner = at + 1;
        while inner < cell.next as usize {
            let own = &self.cells[inner];
            let (a, b) = (distance_squared(own.centre, cell.centre), own.size * own.size);
            radius = radius.max(a.sqrt() + own.radius);
            // |a + b|^4, over all directions of b: a^4 + 10/3 a^2 b^2 + b^4.
            fourths += own.weight * (a * a + P::from_f64(10.0 / 3.0) * a * b + b * b);
            inner = own.next as usize;
        }
        // The farthest corner of the box may be nearer than the farthest point of the spheres inside.
        let mut corner = nothing;
        for k in 0..3 {
            let side = (around.high[k] - cell.centre[k]).max(cell.centre[k] - around.low[k]);
            corner += side * side;
        }
        cell.radius = radius.min(corner.sqrt());
        cell.take_size(fourths);
        self.boxes[at] = around;
    }
}

impl<P: Scalar> Cell<P> {
    /// Finds centre and sizes of a cell of rows; its box.
    fn bound(&mut self, all: &Rows<P>) -> Box3<P> {
        let rows = self.start as usize..self.end as usize;
        let mut around = Box3::at(all.place(rows.start));
        for row in rows.clone() {
            around.hold(Box3::at(all.place(row)));
        }
        let mut middle = Middle::new(around.low);
        for row in rows.clone() {
            let strength = all.strength[row];
            self.strength += strength;
            middle.add(all.place(row), strength.abs());
        }
        (self.weight, self.centre) = (middle.weight, middle.place(around));
        let nothing = P::from_f64(0.0);
        let (mut farthest, mut fourths) = (nothing, nothing);
        for row in rows {
            let d2 = distance_squared(all.place(row), self.centre);
            farthest = farthest.max(d2);
            fourths += all.strength[row].abs() * (d2 * d2);
        }
        self.radius = farthest.sqrt();
        self.take_size(fourths);
        around
    }

    fn take_size(&mut self, fourths: P) {
        // Without a strength there is nothing that has a size.
        let nothing = P::from_f64(0.0);
        self.size = if self.weight > nothing { (fourths / self.weight).sqrt().sqrt() } else { nothing };
    }
}

/// The mean of places by the magnitude of strengths. It makes the dipole 0 where strengths have one sign, and a concentrated cell
/// smaller than the middle of its box would.
struct Middle<P> {
    origin: [P; 3],
    sums: [P; 3],
    weight: P,
}

impl<P: Scalar> Middle<P> {
    fn new(origin: [P; 3]) -> Self {
        let nothing = P::from_f64(0.0);
        Middle { origin, sums: [nothing; 3], weight: nothing }
    }

    #[inline(always)]
    fn add(&mut self, place: [P; 3], weight: P) {
        self.weight += weight;
        for ((sum, place), origin) in self.sums.iter_mut().zip(place).zip(self.origin) {
            *sum += weight * (place - origin);
        }
    }

    fn place(&self, around: Box3<P>) -> [P; 3] {
        if self.weight > P::from_f64(0.0) {
            [0, 1, 2].map(|k| self.origin[k] + self.sums[k] / self.weight)
        } else {
            around.centre()
        }
    }
}

#[inline(always)]
pub(super) fn distance_squared<P: Scalar>(a: [P; 3], b: [P; 3]) -> P {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}
