//! A sum of arrays, in lanes. In: factors, and where vectors begin. Out: the sum, where it goes, and what rounding took from it.
//! Never: a state.

use crate::integrate::{Register, Terms};
use crate::real::{Lanes, Scalar, WithLanes};

/// Terms that are summed in one pass; more are added in further ones.
pub(super) const TERMS: usize = 24;

/// Numbers that are summed in f64 side by side.
const WIDE: usize = 8;

/// Where the vector of a register begins, among those of all.
#[inline(always)]
pub(super) fn start<P>(starts: &[*mut P], register: Register) -> *mut P {
    *starts.get(register.number()).unwrap_or_else(|| too_many(starts.len()))
}

/// Where the vectors of a row of weights begin.
#[inline(always)]
fn work_from<'a, P>(starts: &'a [*mut P], terms: &Terms<'_>) -> &'a [*mut P] {
    let from = Register::Work(terms.first).number();
    starts.get(from..from.saturating_add(terms.weights.len())).unwrap_or_else(|| too_many(starts.len()))
}

#[cold]
pub(super) fn too_many<T>(vectors: usize) -> T {
    panic!("an integrator uses as many vectors as its work_vectors says: {}", vectors.saturating_sub(2))
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
#[derive(Clone, Copy)]
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
    /// Where all vectors begin, by number.
    pub(super) starts: &'a [*mut P],
    /// What is summed: rows of weights first. Which number of each vector is the first one.
    pub(super) terms: [(&'a Terms<'a>, usize); 2],
}

impl<'a, P: Scalar> Sum<'a, P> {
    /// The vectors of a row of weights, each from its first number on, with its weight and what that is multiplied by; without
    /// those whose weight is 0.
    #[inline(always)]
    fn row(&self, (terms, at): (&'a Terms<'a>, usize)) -> impl Iterator<Item = ([f64; 2], *mut P)> {
        let weighed = terms.weights.iter().zip(work_from(self.starts, terms)).filter(|(weight, _)| **weight != 0.0);
        weighed.map(move |(weight, start)| ([*weight, terms.factor], start.wrapping_add(at)))
    }

    /// The single vectors, likewise.
    #[inline(always)]
    fn others(&self, (terms, at): (&'a Terms<'a>, usize)) -> impl Iterator<Item = (f64, *mut P)> {
        terms.others.iter().map(move |(factor, from)| (*factor, start(self.starts, *from).wrapping_add(at)))
    }

    /// What sums begin with: what leaves every other number as it is, zeros with a minus sign, too.
    #[inline(always)]
    fn nothing(&self) -> f64 {
        let [(first, _), (second, _)] = self.terms;
        if first.len() + second.len() == 0 { 0.0 } else { -0.0 }
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
            for terms in self.terms {
                for ([weight, factor], from) in self.row(terms) {
                    let factor = R::splat(P::from_product(weight, factor));
                    for set in 0..SETS {
                        sums[set] += R::load(from.add(starts[set])) * factor;
                    }
                }
            }
            for terms in self.terms {
                for (factor, from) in self.others(terms) {
                    let factor = R::splat(P::from_f64(factor));
                    for set in 0..SETS {
                        sums[set] += R::load(from.add(starts[set])) * factor;
                    }
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
            for terms in self.terms {
                self.row(terms).for_each(|([weight, factor], from)| add(&mut sums, weight * factor, from.add(at)));
            }
            for terms in self.terms {
                self.others(terms).for_each(|(factor, from)| add(&mut sums, factor, from.add(at)));
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

    /// One number at a time, each of the integrator's vectors at its own distance.
    ///
    /// # Safety
    /// All pointers are to `count` numbers, so far apart, which nobody else touches.
    pub(super) unsafe fn strided(&self, stride: usize, strides: &[usize]) {
        let first = Register::Work(0).number();
        for number in 0..self.count {
            let mut starts = [core::ptr::null_mut(); Register::Work(TERMS).number()];
            for ((start, from), stride) in starts[first..].iter_mut().zip(&self.starts[first..]).zip(strides) {
                *start = from.wrapping_add(number * stride);
            }
            // Only what is added to stands at such distances, and where it goes; rounding errors stand one by one.
            let errors = if self.errors.is_null() { self.errors } else { self.errors.wrapping_add(number) };
            let lost = self.lost.map(|to| if to.is_null() { to } else { to.wrapping_add(number) });
            let base = if self.base.is_null() { self.base } else { self.base.wrapping_add(number * stride) };
            let to = self.to.wrapping_add(number * stride);
            let one = Sum { to, base, errors, lost, count: 1, starts: &starts, ..*self };
            // SAFETY: passed on to the caller.
            unsafe { if one.wide { one.in_f64::<1>(0) } else { one.lanes::<P, 1>([0]) } };
        }
    }
}

impl<P: Scalar> WithLanes<P> for &Sum<'_, P> {
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
