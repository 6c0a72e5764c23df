//! Springs between bodies, colour by colour: no two springs of one colour share a body, so that threads add without locks.

use super::Sprung;
use crate::scenes::{Lattice, STEP};
use core::ops::Range;
use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vesper::prelude::Precision;

/// Bodies, and the springs between them in the order of their colours.
#[derive(Clone, Debug)]
pub struct Coloured<P> {
    /// Bodies and springs.
    pub sprung: Sprung<P>,
    /// The springs of each colour.
    colours: Vec<Range<usize>>,
}

/// Rows or springs that a thread takes at a time, at least.
const GRAIN: usize = 2048;

/// A column that threads write to at different rows.
#[derive(Clone, Copy)]
struct Shared<P>(*mut P);

// SAFETY: whoever hands one to threads sees to it that they touch different rows.
unsafe impl<P> Sync for Shared<P> {}

impl<P: Precision> Shared<P> {
    /// # Safety
    /// The column has the row, and no other thread writes to it.
    #[inline(always)]
    unsafe fn get(&self, row: usize) -> P {
        // SAFETY: passed on to the caller.
        unsafe { *self.0.add(row) }
    }

    /// # Safety
    /// The column has the row, and no other thread touches it.
    #[inline(always)]
    unsafe fn set(&self, row: usize, number: P) {
        // SAFETY: passed on to the caller.
        unsafe { *self.0.add(row) = number }
    }

    /// # Safety
    /// As for `set`.
    #[inline(always)]
    unsafe fn add(&self, row: usize, number: P) {
        // SAFETY: passed on to the caller.
        unsafe { *self.0.add(row) += number }
    }
}

impl<P: Precision> Coloured<P> {
    /// The same bodies and springs as an engine gets. Each spring in turn takes the first colour that none of its two bodies has.
    pub fn new(lattice: &Lattice) -> Self {
        let mut taken = vec![0_u64; lattice.bodies.len()];
        let mut colour_of = Vec::new();
        for ends in &lattice.ends {
            let [a, b] = ends.map(|end| end as usize);
            let colour = (taken[a] | taken[b]).trailing_ones();
            assert!(colour < 64, "a body has so many springs that 64 colours are too few");
            taken[a] |= 1 << colour;
            taken[b] |= 1 << colour;
            colour_of.push(colour);
        }
        let mut order: Vec<usize> = (0..lattice.ends.len()).collect();
        order.sort_by_key(|&spring| colour_of[spring]);
        let mut colours: Vec<Range<usize>> = Vec::new();
        for (at, &spring) in order.iter().enumerate() {
            if colours.len() <= colour_of[spring] as usize {
                colours.push(at..at);
            }
            colours[colour_of[spring] as usize].end = at + 1;
        }
        let sorted = Lattice {
            bodies: lattice.bodies.clone(),
            ends: order.iter().map(|&spring| lattice.ends[spring]).collect(),
            stiffness: order.iter().map(|&spring| lattice.stiffness[spring]).collect(),
            rest_length: order.iter().map(|&spring| lattice.rest_length[spring]).collect(),
        };
        assert!(sorted.ends.iter().flatten().all(|&end| (end as usize) < sorted.bodies.len()), "springs end at bodies");
        Coloured { sprung: Sprung::new(&sorted), colours }
    }

    /// One step of semi-implicit Euler under gravity and springs, on the threads of the pool, or on this one alone.
    pub fn step(&mut self, gravity: [f64; 3], pool: Option<&ThreadPool>) {
        let step = P::from_f64(STEP);
        let Sprung { position, velocity, force, mass, ends, stiffness, rest_length } = &mut self.sprung;
        let rows = mass.numbers().len();
        let [x, y, z] = position.each_mut().map(|column| Shared(column.slice().as_mut_ptr()));
        let [vx, vy, vz] = velocity.each_mut().map(|column| Shared(column.slice().as_mut_ptr()));
        let [fx, fy, fz] = force.each_mut().map(|column| Shared(column.slice().as_mut_ptr()));
        let (mass, stiffness, rest_length) = (mass.numbers(), stiffness.numbers(), rest_length.numbers());
        let [gx, gy, gz] = gravity.map(P::from_f64);
        let (x, y, z, vx, vy, vz, fx, fy, fz) = (&x, &y, &z, &vx, &vy, &vz, &fx, &fy, &fz);
        in_parts(pool, 0..rows, |rows| {
            for row in rows {
                // SAFETY: the columns have a number for each body; parts are different rows.
                unsafe {
                    fx.set(row, gx * mass[row]);
                    fy.set(row, gy * mass[row]);
                    fz.set(row, gz * mass[row]);
                }
            }
        });
        for colour in &self.colours {
            in_parts(pool, colour.clone(), |springs| {
                let numbers = stiffness[springs.clone()].iter().zip(&rest_length[springs.clone()]);
                for (ends, (&stiffness, &rest_length)) in ends[springs].iter().zip(numbers) {
                    let [a, b] = ends.map(|end| end as usize);
                    // SAFETY: `new` checked the ends; springs of one colour end at different bodies; nobody writes positions.
                    unsafe {
                        let (dx, dy, dz) = (x.get(b) - x.get(a), y.get(b) - y.get(a), z.get(b) - z.get(a));
                        let length = (dx * dx + dy * dy + dz * dz).sqrt();
                        let inverse = if length == P::default() { P::default() } else { P::lit(1.0) / length };
                        let (nx, ny, nz) = (dx * inverse, dy * inverse, dz * inverse);
                        let pull = stiffness * (length - rest_length);
                        let (px, py, pz) = (nx * pull, ny * pull, nz * pull);
                        fx.add(a, px);
                        fy.add(a, py);
                        fz.add(a, pz);
                        fx.add(b, -px);
                        fy.add(b, -py);
                        fz.add(b, -pz);
                    }
                }
            });
        }
        in_parts(pool, 0..rows, |rows| {
            for i in rows.filter(|&i| mass[i] != P::default()) {
                // SAFETY: as for gravity.
                unsafe {
                    vx.add(i, fx.get(i) / mass[i] * step);
                    vy.add(i, fy.get(i) / mass[i] * step);
                    vz.add(i, fz.get(i) / mass[i] * step);
                    x.add(i, vx.get(i) * step);
                    y.add(i, vy.get(i) * step);
                    z.add(i, vz.get(i) * step);
                }
            }
        });
    }
}

/// Calls `work` with parts of the range, four for each thread.
fn in_parts(pool: Option<&ThreadPool>, range: Range<usize>, work: impl Fn(Range<usize>) + Sync) {
    let Some(pool) = pool else { return work(range) };
    let each = range.len().div_ceil(4 * pool.current_num_threads()).max(GRAIN);
    let parts = range.len().div_ceil(each);
    let part = |part: usize| (range.start + part * each)..(range.start + (part + 1) * each).min(range.end);
    pool.install(|| (0..parts).into_par_iter().for_each(|number| work(part(number))));
}
