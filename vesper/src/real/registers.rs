//! How a lane type is written, whatever its registers are. A file that uses it allows `unused_unsafe`: where the registers
//! are always there, their operations are safe.

/// One lane type: `$count` registers of `$register`, each with `$per` numbers of `$scalar`.
///
/// Everything is written out for each register, and lanes are never touched in a closure: a closure cannot be told to be
/// inlined, and whatever is not is compiled without the instructions of its lanes, as calls of them, 50 times slower.
macro_rules! lanes {
    (
        $name:ident, $mask:ident, $narrow:ident, $scalar:ident, $register:ty, $truth:ty, $count:literal [$($i:literal)+], $per:literal,
        $set1:path, $load:path, $store:path, $add:path, $sub:path, $mul:path, $div:path, $sqrt:path, $min:path, $max:path, $sum:path,
        |$a:ident, $b:ident, $m:ident| neg $neg:expr, abs $abs:expr, less $less:expr, less_or_equal $less_eq:expr,
        equal $equal:expr, select $select:expr, and $and:expr, or $or:expr, not $not:expr
    ) => {
        #[doc = concat!("Lanes of `", stringify!($scalar), "` in `", stringify!($register), "`.")]
        #[derive(Clone, Copy, Debug)]
        pub struct $name([$register; $count]);

        #[doc = concat!("Truth values for [`", stringify!($name), "`].")]
        #[derive(Clone, Copy, Debug)]
        pub struct $mask([$truth; $count]);

        impl Mask for $mask {
            #[inline(always)]
            fn bits(self) -> u32 {
                let mut bits = 0;
                $(bits |= Truth::bits(self.0[$i]) << ($i * $per);)+
                bits
            }
        }

        impl $name {
            /// Lane by lane, through memory once: no register is taken apart.
            #[inline(always)]
            fn each(self, f: impl Fn($scalar, usize) -> $scalar) -> Self {
                let mut numbers = [0.0; $count * $per];
                // SAFETY: the array has a number for every lane.
                unsafe { self.store(numbers.as_mut_ptr()) };
                for (lane, number) in numbers.iter_mut().enumerate() {
                    *number = f(*number, lane);
                }
                // SAFETY: as above.
                unsafe { Self::load(numbers.as_ptr()) }
            }
        }

        // About the safety of every block in these operators: a value of this type exists only inside `with_lanes`, that is
        // after the processor was asked for the instructions; they have no other condition.
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $add(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $sub(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $mul(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $div(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see above.
                $name([$({
                    let $a = self.0[$i];
                    // SAFETY: see above.
                    unsafe { $neg }
                }),+])
            }
        }
        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl SubAssign for $name {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe {
                        $and
                    }
                }),+])
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe {
                        $or
                    }
                }),+])
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                $mask([$({
                    let $a = self.0[$i];
                    // SAFETY: see above.
                    unsafe {
                        $not
                    }
                }),+])
            }
        }

        impl Real for $name {
            type Vec3 = Vec3<Self>;
            type Mask = $mask;
            #[inline(always)]
            fn lit(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $sqrt(self.0[$i]) }),+])
            }
            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: see above.
                $name([$({
                    let $a = self.0[$i];
                    // SAFETY: see above.
                    unsafe { $abs }
                }),+])
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $min(self.0[$i], other.0[$i]) }),+])
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $max(self.0[$i], other.0[$i]) }),+])
            }
            #[inline(always)]
            fn sin(self) -> Self {
                self.each(|number, _| number.sin())
            }
            #[inline(always)]
            fn cos(self) -> Self {
                self.each(|number, _| number.cos())
            }
            #[inline(always)]
            fn exp(self) -> Self {
                self.each(|number, _| number.exp())
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.each(|number, _| number.ln())
            }
            #[inline(always)]
            fn powf(self, exponent: Self) -> Self {
                let mut exponents = [0.0; $count * $per];
                // SAFETY: the array has a number for every lane.
                unsafe { exponent.store(exponents.as_mut_ptr()) };
                self.each(|number, lane| number.powf(exponents[lane]))
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $less }
                }),+])
            }
            #[inline(always)]
            fn less_or_equal(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $less_eq }
                }),+])
            }
            #[inline(always)]
            fn equal(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $equal }
                }),+])
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                $name([$({
                    let ($m, $a, $b) = (mask.0[$i], yes.0[$i], no.0[$i]);
                    // SAFETY: see above.
                    unsafe { $select }
                }),+])
            }
        }

        impl Lanes<$scalar> for $name {
            const WIDTH: usize = $count * $per;
            type Narrow = $narrow;
            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                // SAFETY: the caller promises WIDTH readable numbers; the instruction takes any alignment.
                $name([$(unsafe { $load(from.add($i * $per)) }),+])
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                // SAFETY: the caller promises WIDTH writable numbers; the instruction takes any alignment.
                unsafe { $($store(to.add($i * $per), self.0[$i]);)+ }
            }
            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                // SAFETY: see above.
                $name([unsafe { $set1(value) }; $count])
            }
            #[inline(always)]
            fn from_lanes(mut lane: impl FnMut(usize) -> $scalar) -> Self {
                // Not `array::from_fn`, which is not always inlined: a loop over springs was twice as slow with it.
                let mut lanes = [0.0; $count * $per];
                for (index, number) in lanes.iter_mut().enumerate() {
                    *number = lane(index);
                }
                // SAFETY: the array has WIDTH numbers.
                unsafe { Self::load(lanes.as_ptr()) }
            }
            #[inline(always)]
            fn lane(self, index: usize) -> $scalar {
                let mut lanes: [$scalar; $count * $per] = [0.0; $count * $per];
                // SAFETY: the array has WIDTH numbers.
                unsafe { self.store(lanes.as_mut_ptr()) };
                lanes[index]
            }
            #[inline(always)]
            fn sum(self) -> $scalar {
                // SAFETY: see above.
                unsafe { $sum(self.0) }
            }
        }
    };
}
pub(super) use lanes;
