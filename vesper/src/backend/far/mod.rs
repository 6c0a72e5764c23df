//! Sums over all rows of an inverse square, with a requested error instead of all pairs.
//!
//! In: places, a strength for each row, a softening, a requested error. Out: for every row the field
//! `sum of s_j (x_j - x_i) / (|x_j - x_i|^2 + e^2)^(3/2)` over all others, or the potential `sum of s_j / (|x_j - x_i|^2 + e^2)^(1/2)`.
//! Never: a pair of rows that are at the same place; a result that depends on the number of threads, or on an evaluation
//! before, unless [`Far::calibrate`] is called. Its last bits depend on the instruction set, as long as [`fast`] does.
//!
//! The rows are sorted along a curve ([`order`]) and divided into cells ([`tree`]), which have moments ([`moments`]). Each 32
//! consecutive rows are a group. A walk ([`walk`]) tells for each group the cells that are far, whose potential is expanded once for the
//! whole group ([`local`]), those that are near, which are summed over the rows one by one, and the rows of the cells that are too near
//! for that ([`kernel`]). Only sources are a hierarchy: no number goes from one group to another, so any thread may take any group.
//!
//! Why no hierarchy of groups: it would save far cells and steps of the walk, which are the smaller part. Instructions of 16 lanes:
//! a pair takes 13 for 16 rows; a near cell 40 with quadrupoles, 75 with octupoles; a far cell 130 to 600 (orders 3 to 5) for 16
//! groups, that is 4 to 20 for 16 rows. What is left are the rows and cells at hand, so the order is as high as makes these few, and
//! cells are taken by their weight ([`walk`]). Measured, sphere of 10^5 rows, f32, error 10^-3: order and tree take a fifteenth of the
//! time, the walk an eighth. Groups of 16 to 64 rows and cells of 32 to 64 differ by less than a tenth.

mod accuracy;
mod calibrate;
mod fast;
mod frame;
mod kernel;
mod local;
mod moments;
mod order;
mod rows;
mod sum;
mod terms;
#[cfg(test)]
mod tests;
mod tree;
mod walk;

use crate::real::{Isa, Scalar};
use frame::Frame;
use moments::Moments;
use rows::{GROUP, Groups};
use std::sync::{Mutex, PoisonError};
use sum::{Call, Out};
use terms::{Fifth, Fourth, Third};
use tree::Tree;

pub(crate) use accuracy::{Accuracy, Effort, pays};

/// Whoever runs work on threads.
pub(crate) trait Parts {
    /// Calls the work for every number below `count`, once each, in any order, and comes back when all is done.
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync));

    /// Calls the work with every one of these, once each, in any order.
    fn each<T: Send>(&self, parts: impl Iterator<Item = T>, work: impl Fn(usize, &mut T) + Sync) {
        // Each part is locked once: nobody waits.
        let parts: Vec<Mutex<T>> = parts.map(Mutex::new).collect();
        self.run(parts.len(), &|part| {
            // Poisoned only where another part panicked, which ends the evaluation anyway.
            work(part, &mut parts[part].lock().unwrap_or_else(PoisonError::into_inner));
        });
    }
}

/// One part after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneThread;

impl Parts for OneThread {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(work);
    }
}

/// A method for far rows, which keeps its arrays between evaluations.
#[derive(Debug)]
pub(crate) struct Far<P> {
    /// Requested: root of the mean square of the field's relative error.
    error: f64,
    effort: Effort,
    /// In the units of the frame, in the order of the caller.
    sources: Vec<Source<P>>,
    tree: Tree<P>,
    groups: Groups<P>,
    moments: Moments<P>,
    /// Results in the order of the tree: field, potential.
    sums: [Vec<P>; 4],
}

/// A row in the units of the frame: its place and its strength. One line of a cache holds it, in whatever order rows are taken.
type Source<P> = [P; 4];

/// Rows that one part of the work takes where each of them takes little.
const SHARE: usize = 1 << 13;

/// Groups that one part of the work sums for: as many as the widest lanes hold.
const PART: usize = crate::real::MAX_WIDTH;

impl<P: Scalar> Far<P> {
    /// A method of a requested error: root of the mean square, relative.
    pub(crate) fn new(error: f64) -> Self {
        Far {
            error,
            effort: Effort::first(error),
            sources: Vec::new(),
            tree: Tree::default(),
            groups: Groups::default(),
            moments: Moments::default(),
            sums: Default::default(),
        }
    }

    /// The error that is asked for.
    pub(crate) fn requested(&self) -> f64 {
        self.error
    }

    /// What says how large the error is.
    pub(crate) fn effort(&self) -> Effort {
        self.effort
    }

    /// Takes what another calibration gave.
    pub(crate) fn set_effort(&mut self, effort: Effort) {
        self.effort = effort;
    }

    /// Writes the field of every row.
    pub(crate) fn field(
        &mut self,
        isa: Isa,
        places: [&[P]; 3],
        strength: &[P],
        softening_squared: P,
        out: [&mut [P]; 3],
        threads: &impl Parts,
    ) {
        if strength.is_empty() {
            return;
        }
        let Some(frame) = self.prepare(places, strength, softening_squared, threads) else {
            // A sum over all pairs has NaN in every row, too.
            out.into_iter().for_each(|out| out.fill(P::from_f64(f64::NAN)));
            return;
        };
        self.sum_all::<false>(isa, &frame, softening_squared, threads);
        for (out, sums) in out.into_iter().zip(&self.sums) {
            for (&origin, &sum) in self.tree.rows.origin.iter().zip(sums) {
                out[origin as usize] = frame.field.times(sum);
            }
        }
    }

    /// Writes the potential of every row.
    pub(crate) fn potential(
        &mut self,
        isa: Isa,
        places: [&[P]; 3],
        strength: &[P],
        softening_squared: P,
        out: &mut [P],
        threads: &impl Parts,
    ) {
        if strength.is_empty() {
            return;
        }
        let Some(frame) = self.prepare(places, strength, softening_squared, threads) else {
            out.fill(P::from_f64(f64::NAN));
            return;
        };
        self.sum_all::<true>(isa, &frame, softening_squared, threads);
        for (&origin, &sum) in self.tree.rows.origin.iter().zip(&self.sums[3]) {
            out[origin as usize] = frame.potential.times(sum);
        }
    }

    /// Takes a scene into the frame and makes the tree; none where a number is not finite.
    fn prepare(
        &mut self,
        places: [&[P]; 3],
        strength: &[P],
        softening_squared: P,
        threads: &impl Parts,
    ) -> Option<Frame<P>> {
        let frame = Frame::new(places, strength, softening_squared)?;
        self.sources.resize(strength.len(), [P::from_f64(0.0); 4]);
        let [xs, ys, zs] = places.map(|axis| axis.chunks(SHARE));
        let columns = xs.zip(ys).zip(zs.zip(strength.chunks(SHARE)));
        threads.each(self.sources.chunks_mut(SHARE).zip(columns), |_, (to, ((xs, ys), (zs, strengths)))| {
            for ((to, (x, y)), (z, strength)) in to.iter_mut().zip(xs.iter().zip(*ys)).zip(zs.iter().zip(*strengths)) {
                let [x, y, z] = [x, y, z].map(|&place| frame.length.times(place));
                *to = [x, y, z, frame.strength.times(*strength)];
            }
        });
        self.tree.build(&self.sources, frame.around(), threads);
        self.groups.find(&self.tree.rows, threads);
        self.find_moments(threads);
        Some(frame)
    }

    fn find_moments(&mut self, threads: &impl Parts) {
        match self.effort.degree {
            3 => self.moments.find::<Third>(&self.tree, threads),
            4 => self.moments.find::<Fourth>(&self.tree, threads),
            _ => self.moments.find::<Fifth>(&self.tree, threads),
        }
    }

    fn call(&self, frame: &Frame<P>, softening_squared: P) -> Call<'_, P> {
        Call {
            tree: &self.tree,
            groups: &self.groups,
            moments: &self.moments,
            opening: self.effort.opening(),
            softening_squared: frame.square.times(softening_squared),
        }
    }

    /// Sums for all groups.
    fn sum_all<const POTENTIAL: bool>(
        &mut self,
        isa: Isa,
        frame: &Frame<P>,
        softening_squared: P,
        threads: &impl Parts,
    ) {
        let mut sums = core::mem::take(&mut self.sums);
        for sums in &mut sums {
            sums.clear();
            sums.resize(self.groups.count * GROUP, P::from_f64(0.0));
        }
        let call = self.call(frame, softening_squared);
        let [x, y, z, w] = &mut sums;
        let size = PART * GROUP;
        let parts = x.chunks_mut(size).zip(y.chunks_mut(size)).zip(z.chunks_mut(size).zip(w.chunks_mut(size)));
        let parts = parts.map(|((x, y), (z, w))| [x, y, z, w]);
        threads.each(parts, |part, out: &mut Out<'_, P>| {
            let count = out[0].len() / GROUP;
            let mut list = [0; PART];
            for (group, at) in list.iter_mut().zip(part * PART..) {
                *group = at as u32;
            }
            call.sum::<POTENTIAL>(self.effort.degree, isa, &list[..count], out);
        });
        self.sums = sums;
    }
}
