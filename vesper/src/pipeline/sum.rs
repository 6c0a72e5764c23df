//! A sum of arrays, in lanes. In: factors and pointers. Out: the sum, where it goes, and what rounding took from it. Never: a
//! register, a state.

use crate::real::{Lanes, Scalar, WithLanes};
use core::mem::MaybeUninit;

/// Terms that are summed in one pass; more are added in further ones.
pub(super) const TERMS: usize = 24;

/// Numbers that are summed in f64 side by side.
const WIDE: usize = 8;

/// Arrays by a row of weights, without those whose weight is 0.
#[derive(Clone, Copy)]
pub(super) struct Row<'a, P> {
    pub(super) weights: &'a [f64],
    /// Where each array begins, and which of its numbers is the first one.
    pub(super) starts: &'a [*mut P],
    pub(super) at: usize,
    /// What weights are multiplied by.
    pub(super) factor: f64,
}

impl<P> Row<'_, P> {
    pub(super) const NONE: Self = Row { weights: &[], starts: &[], at: 0, factor: 0.0 };
}

/// Room for factors, and where the numbers begin that they are of.
pub(super) struct Sources<P> {
    /// Not filled with anything first: that took as long as three terms.
    all: [MaybeUninit<(f64, *const P)>; TERMS],
    count: usize,
}

impl<P> Sources<P> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Sources { all: [const { MaybeUninit::uninit() }; TERMS], count: 0 }
    }

    #[inline(always)]
    pub(super) fn take(&mut self, sources: impl Iterator<Item = (f64, *mut P)>) {
        for (factor, from) in sources {
            self.all[self.count].write((factor, from.cast_const()));
            self.count += 1;
        }
    }

    #[inline(always)]
    pub(super) fn as_slice(&self) -> &[(f64, *const P)] {
        // SAFETY: so many are written.
        unsafe { self.all[..self.count].assume_init_ref() }
    }
}

/// # Safety
/// There are so many numbers.
#[inline(always)]
unsafe fn add<P: Scalar, const COUNT: usize>(sums: &mut [f64; COUNT], factor: f64, from: *const P) {
    for (number, sum) in sums.iter_mut().enumerate() {
        // SAFETY: the caller promises the numbers.
        *sum += factor * unsafe { *from.add(number) }.to_f64();
    }
}

/// A sum of arrays of `count` numbers.
pub(super) struct Sum<'a, P> {
    pub(super) to: *mut P,
    /// What is added to, or null: `to` itself, or what a trial begins at.
    pub(super) base: *const P,
    /// The rounding errors of what is added to, or null.
    pub(super) errors: *const P,
    /// Where what rounding takes goes, or null.
    pub(super) lost: [*mut P; 2],
    /// Whether it is summed in f64, of numbers that are none.
    pub(super) wide: bool,
    pub(super) count: usize,
    /// Summed first.
    pub(super) row: Row<'a, P>,
    /// Summed behind it.
    pub(super) sources: &'a [(f64, *const P)],
}

impl<P: Scalar> Sum<'_, P> {
    /// What sums begin with: what leaves every other number as it is, zeros with a minus sign, too.
    #[inline(always)]
    fn nothing(&self) -> f64 {
        let is_empty = self.sources.is_empty() && self.row.weights.is_empty();
        if is_empty { 0.0 } else { -0.0 }
    }

    /// The lanes that begin at these numbers. All are read before any is written, so that they may overlap. Plain loops over
    /// the sets: with closures and iterators the sums were kept in memory, and some operations became calls.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, which nobody else touches, and the lanes are within them.
    #[inline(always)]
    unsafe fn lanes<R: Lanes<P>, const SETS: usize>(&self, starts: [usize; SETS]) {
        // SAFETY: the caller promises the lanes.
        unsafe {
            let mut sums = [R::lit(self.nothing()); SETS];
            for (weight, start) in self.row.weights.iter().zip(self.row.starts) {
                if *weight == 0.0 {
                    continue;
                }
                let factor = R::splat(P::from_f64(weight * self.row.factor));
                let from = start.add(self.row.at);
                for set in 0..SETS {
                    sums[set] += R::load(from.add(starts[set])) * factor;
                }
            }
            for (factor, from) in self.sources {
                let factor = R::splat(P::from_f64(*factor));
                for set in 0..SETS {
                    sums[set] += R::load(from.add(starts[set])) * factor;
                }
            }
            if !self.base.is_null() {
                let mut before = [R::lit(0.0); SETS];
                for set in 0..SETS {
                    before[set] = R::load(self.base.add(starts[set]));
                }
                if self.errors.is_null() {
                    for set in 0..SETS {
                        sums[set] += before[set];
                    }
                } else {
                    let mut errors = [R::lit(0.0); SETS];
                    for set in 0..SETS {
                        errors[set] = R::load(self.errors.add(starts[set]));
                    }
                    for set in 0..SETS {
                        let (before, sum) = (before[set], sums[set] - errors[set]);
                        let after = before + sum;
                        // Knuth's sum: exact whichever of the two is the larger.
                        let change = after - before;
                        let lost = ((after - change) - before) + (change - sum);
                        for to in self.lost {
                            if !to.is_null() {
                                lost.store(to.add(starts[set]));
                            }
                        }
                        sums[set] = after;
                    }
                }
            }
            for set in 0..SETS {
                sums[set].store(self.to.add(starts[set]));
            }
        }
    }

    /// Numbers from this one on, summed in f64. What is added to the state has there what f32 left out, as far as another f32
    /// holds it: the state has 48 bits.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, which nobody else touches, and these are among them.
    #[inline(always)]
    unsafe fn in_f64<const COUNT: usize>(&self, at: usize) {
        let mut sums = [self.nothing(); COUNT];
        // SAFETY: the caller promises the numbers.
        unsafe {
            let weights = self.row.weights.iter().zip(self.row.starts).filter(|(weight, _)| **weight != 0.0);
            for (weight, start) in weights {
                add(&mut sums, weight * self.row.factor, start.add(self.row.at + at));
            }
            for (factor, from) in self.sources {
                add(&mut sums, *factor, from.add(at));
            }
            for (number, sum) in sums.into_iter().enumerate() {
                let place = at + number;
                let error = if self.errors.is_null() { 0.0 } else { (*self.errors.add(place)).to_f64() };
                let exact = if self.base.is_null() { sum } else { (*self.base.add(place)).to_f64() + (sum - error) };
                let rounded = P::from_f64(exact);
                *self.to.add(place) = rounded;
                for to in self.lost.into_iter().filter(|to| !to.is_null()) {
                    *to.add(place) = P::from_f64(rounded.to_f64() - exact);
                }
            }
        }
    }

    /// One number at a time, at their own distances.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, so far apart, which nobody else touches.
    pub(super) unsafe fn strided(&self, stride: usize, strides: &[usize]) {
        for row in 0..self.count {
            let mut sources = [(0.0, core::ptr::null::<P>()); TERMS];
            for ((source, (factor, from)), stride) in sources.iter_mut().zip(self.sources).zip(strides) {
                *source = (*factor, from.wrapping_add(row * stride));
            }
            // Only what is added to stands at such distances, and where it goes; rounding errors stand one by one.
            let errors = if self.errors.is_null() { self.errors } else { self.errors.wrapping_add(row) };
            let lost = self.lost.map(|to| if to.is_null() { to } else { to.wrapping_add(row) });
            let base = if self.base.is_null() { self.base } else { self.base.wrapping_add(row * stride) };
            let to = self.to.wrapping_add(row * stride);
            let sources = &sources[..self.sources.len()];
            let one = Sum { to, base, errors, lost, count: 1, sources, ..*self };
            // SAFETY: passed on to the caller.
            unsafe { if one.wide { one.in_f64::<1>(0) } else { one.lanes::<P, 1>([0]) } };
        }
    }
}

impl<P: Scalar> WithLanes<P> for Sum<'_, P> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        let count = self.count;
        let width = R::WIDTH;
        let mut at = 0;
        // SAFETY: whoever makes a sum has pointers to that many numbers, and the runner holds the state; the last lanes end
        // with the last number, and overlap those before them.
        unsafe {
            if self.wide {
                while at + WIDE <= count {
                    self.in_f64::<WIDE>(at);
                    at += WIDE;
                }
                return (at..count).for_each(|number| self.in_f64::<1>(number));
            }
            if count < width {
                return (0..count).for_each(|number| self.lanes::<P, 1>([number]));
            }
            // So that what is left for the last lanes is never less than one set of them.
            while at + 5 * width <= count {
                self.lanes::<R, 4>([at, at + width, at + 2 * width, at + 3 * width]);
                at += 4 * width;
            }
            let last = count - width;
            match (count - at).div_ceil(width) {
                1 => self.lanes::<R, 1>([last]),
                2 => self.lanes::<R, 2>([at, last]),
                3 => self.lanes::<R, 3>([at, at + width, last]),
                4 => self.lanes::<R, 4>([at, at + width, at + 2 * width, last]),
                _ => self.lanes::<R, 5>([at, at + width, at + 2 * width, at + 3 * width, last]),
            }
        }
    }
}
