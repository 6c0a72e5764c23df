//! Several rows side by side: the lane trait, and the choice of an instruction set at run time.

use super::Real;

/// The most lanes that there are.
pub(crate) const MAX_WIDTH: usize = 16;

/// A [`Real`] that holds `WIDTH` numbers of precision `P`, one row in each lane.
pub trait Lanes<P>: Real {
    /// Numbers side by side.
    const WIDTH: usize;
    /// The lanes for rows that do not fill half of these, of the same processor.
    type Narrow: Lanes<P>;
    /// Whether they fuse products with sums, and estimate roots.
    const ESTIMATES: bool = false;
    /// Reads `WIDTH` neighbouring numbers.
    ///
    /// # Safety
    /// `from` points to `WIDTH` readable numbers; no alignment is needed.
    unsafe fn load(from: *const P) -> Self;
    /// Writes `WIDTH` neighbouring numbers.
    ///
    /// # Safety
    /// `to` points to `WIDTH` writable numbers; no alignment is needed.
    unsafe fn store(self, to: *mut P);
    /// The same number in every lane.
    fn splat(value: P) -> Self;
    /// Each lane from its index.
    fn from_lanes(lane: impl FnMut(usize) -> P) -> Self;
    /// The number in one lane.
    fn lane(self, index: usize) -> P;
    /// The sum of all lanes: that of one half and that of the other one are added lane by lane, until one lane is left.
    fn sum(self) -> P;
}

/// Work that can be done in any lanes; a [`super::Scalar`] picks them and calls [`WithLanes::with`].
pub trait WithLanes<P> {
    /// What the work gives.
    type Output;
    /// Does the work in lanes of type `R`. Implementations must be `#[inline(always)]`, else the body is compiled
    /// without the instructions it was chosen for.
    fn with<R: Lanes<P>>(self) -> Self::Output;
}

/// An instruction set, chosen once at start from what the processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// One row at a time: the reference that the others are compared with.
    Scalar,
    /// The registers that every processor of the architecture has, 128 bits: SSE2 on x86-64, NEON on aarch64, the one of these that
    /// has estimates; elsewhere as many numbers side by side, for the compiler to put in registers.
    Baseline,
    /// x86-64 with AVX2 and FMA: 256-bit registers.
    #[cfg(target_arch = "x86_64")]
    #[non_exhaustive]
    Avx2,
    /// x86-64 with AVX-512: 512-bit registers.
    #[cfg(target_arch = "x86_64")]
    #[non_exhaustive]
    Avx512,
}

impl Isa {
    /// The widest that this processor has.
    pub fn detect() -> Isa {
        Isa::available().pop().unwrap_or(Isa::Scalar)
    }

    /// All that this processor has, narrowest first.
    pub fn available() -> Vec<Isa> {
        #[allow(unused_mut, reason = "only one architecture adds to it")]
        let mut sets = vec![Isa::Scalar, Isa::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Isa::Avx2);
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    sets.push(Isa::Avx512);
                }
            }
        }
        sets
    }

    /// Its place among [`Isa::available`].
    #[cfg(feature = "modules")]
    #[inline(always)]
    pub(crate) const fn number(self) -> u32 {
        self as u32
    }

    /// The one of this number, if this processor has it.
    #[cfg(feature = "modules")]
    pub(crate) fn of_number(number: u32) -> Isa {
        static AVAILABLE: std::sync::OnceLock<Vec<Isa>> = std::sync::OnceLock::new();
        AVAILABLE.get_or_init(Isa::available).get(number as usize).copied().unwrap_or(Isa::Baseline)
    }

    /// The one to take for so many numbers: those that half of the widest registers hold need no wider ones, whose loads and stores
    /// then cross lines of the cache (measured with sums over three bodies: a tenth of an evaluation).
    #[inline(always)]
    pub(crate) fn for_few<P>(self, count: usize) -> Isa {
        let few = count * size_of::<P>() <= 32;
        match (self, few) {
            // `available` gives AVX-512 only beside AVX2.
            #[cfg(target_arch = "x86_64")]
            (Isa::Avx512, true) => Isa::Avx2,
            _ => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Mask, Scalar, portable};
    use super::*;
    use core::marker::PhantomData;

    /// Numbers where operations have their corners.
    fn corners<P: Scalar>() -> Vec<P> {
        let infinity = f64::INFINITY;
        [0.0, -0.0, 1.0, -1.0, 0.3, -2.7, 1e-30, 1e30, 700.25, infinity, -infinity, f64::NAN].map(P::from_f64).to_vec()
    }

    /// The results of every operation on two numbers.
    fn results<R: Real>(a: R, b: R) -> [R; 19] {
        let (one, zero) = (R::lit(1.0), R::lit(0.0));
        let truth = |mask| R::select(mask, one, zero);
        let (mut more, mut less) = (a, a);
        more += b;
        less -= b;
        [
            more,
            less,
            a * b,
            a / b,
            -a,
            a.abs(),
            a.sqrt(),
            a.rsqrt(),
            a.over_root_cubed(b),
            a.min(b),
            a.max(b),
            a.sin() + a.cos(),
            a.exp() - a.ln(),
            a.powf(b),
            truth(a.less(b)),
            truth(a.less_or_equal(b)),
            truth(a.equal(b)),
            truth(a.less(b) | !a.equal(b)),
            R::select(a.less(b) & b.less(one), a, b),
        ]
    }

    /// The sum of numbers as [`Lanes::sum`] promises it.
    fn by_halves<P: Scalar>(mut numbers: Vec<P>) -> P {
        while numbers.len() > 1 {
            let upper = numbers.split_off(numbers.len() / 2);
            numbers.iter_mut().zip(upper).for_each(|(number, other)| *number += other);
        }
        numbers[0]
    }

    /// Compares lanes with the scalar, for all pairs of corners.
    struct Compare<P>(String, PhantomData<P>);

    impl<P: Scalar> WithLanes<P> for Compare<P> {
        type Output = ();
        #[inline(always)]
        fn with<R: Lanes<P>>(self) {
            let corners = corners::<P>();
            let all = corners.len();
            for first in 0..all {
                for second in 0..all {
                    // Another pair in each lane.
                    let pair = |lane: usize| (corners[(first + lane) % all], corners[(second + 5 * lane) % all]);
                    let a = R::from_lanes(|lane| pair(lane).0);
                    let b = R::from_lanes(|lane| pair(lane).1);
                    let found = results(a, b);
                    let less = a.less(b).bits();
                    let sum = by_halves((0..R::WIDTH).map(|lane| pair(lane).0).collect());
                    let same = a.sum().bits() == sum.bits() || [a.sum(), sum].iter().all(|n| n.to_f64().is_nan());
                    assert!(same, "{} {}: sum {}, {sum}", P::NAME, self.0, a.sum());
                    for lane in 0..R::WIDTH {
                        let (a, b) = pair(lane);
                        assert_eq!(less >> lane & 1 != 0, a < b, "{} {}: {a} < {b}", P::NAME, self.0);
                        for (number, (found, expected)) in found.iter().zip(results(a, b)).enumerate() {
                            let found = found.lane(lane);
                            // A NaN has no sign that anybody could rely on.
                            let same = found.bits() == expected.bits()
                                || [found, expected].iter().all(|n| n.to_f64().is_nan());
                            assert!(same, "{} {}: result {number} of {a}, {b}: {found}, {expected}", P::NAME, self.0);
                        }
                    }
                }
            }
        }
    }

    fn every_set<P: Scalar>() {
        for isa in Isa::available() {
            P::with_lanes(isa, Compare(format!("{isa:?}"), PhantomData));
        }
    }

    #[test]
    fn every_operation_in_lanes_is_the_scalar_one() {
        every_set::<f32>();
        every_set::<f64>();
        Compare("portable".to_owned(), PhantomData::<f32>).with::<portable::BaselineF32>();
        Compare("portable".to_owned(), PhantomData::<f64>).with::<portable::BaselineF64>();
    }
}
