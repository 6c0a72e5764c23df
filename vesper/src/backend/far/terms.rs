//! The terms of Cartesian expansions, and the orders that there are.
//!
//! In: nothing. Out: tables of the powers `x^a y^b z^c` by degree, and [`Order`], which says how many of them an expansion has. Never:
//! a number of a scene.
//!
//! The terms are those of Taylor's series, traces included, and not harmonic functions: with a softening the potential is not
//! harmonic, and the series in the softened distance is exact for any.

/// The highest order.
pub(super) const HIGHEST: usize = 5;
/// Terms up to that order.
pub(super) const TERMS: usize = count(HIGHEST);

/// Terms up to a degree.
pub(super) const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) * (degree + 3) / 6
}

/// Where the term of three powers stands: degree by degree, first the high powers of x, then those of y.
pub(super) const fn index(powers: [usize; 3]) -> usize {
    let [a, b, c] = powers;
    let (degree, rest) = (a + b + c, b + c);
    degree * (degree + 1) * (degree + 2) / 6 + rest * (rest + 1) / 2 + c
}

/// The powers of each term.
pub(super) const POWERS: [[usize; 3]; TERMS] = {
    let mut powers = [[0; 3]; TERMS];
    let mut degree = 0;
    while degree <= HIGHEST {
        let mut rest = 0;
        while rest <= degree {
            let mut c = 0;
            while c <= rest {
                let own = [degree - rest, rest - c, c];
                powers[index(own)] = own;
                c += 1;
            }
            rest += 1;
        }
        degree += 1;
    }
    powers
};

/// The degree of each term.
pub(super) const DEGREES: [usize; TERMS] = {
    let mut degrees = [0; TERMS];
    let mut k = 0;
    while k < TERMS {
        degrees[k] = POWERS[k][0] + POWERS[k][1] + POWERS[k][2];
        k += 1;
    }
    degrees
};

/// Where the product of two terms stands; 0 where it has too high a degree.
pub(super) const PRODUCT: [[u8; TERMS]; TERMS] = {
    let mut product = [[0; TERMS]; TERMS];
    let mut n = 0;
    while n < TERMS {
        let mut m = 0;
        while m < TERMS {
            if DEGREES[n] + DEGREES[m] <= HIGHEST {
                let [a, b] = [POWERS[n], POWERS[m]];
                product[n][m] = index([a[0] + b[0], a[1] + b[1], a[2] + b[2]]) as u8;
            }
            m += 1;
        }
        n += 1;
    }
    product
};

/// How a term is made of those of lower degree: along the axis that it has the lowest power of, but not none.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// 0 to 2.
    pub(super) axis: usize,
    /// The term with one power less.
    pub(super) less: usize,
    /// The term with two powers less, if there is one.
    pub(super) twice_less: usize,
    /// Its factor: the power left, or 0 if there is none.
    pub(super) factor: usize,
}

/// The step to each term but the first.
pub(super) const STEPS: [Step; TERMS] = {
    let mut steps = [Step { axis: 0, less: 0, twice_less: 0, factor: 0 }; TERMS];
    let mut k = 1;
    while k < TERMS {
        let powers = POWERS[k];
        let mut axis = 3;
        let mut i = 0;
        while i < 3 {
            if powers[i] > 0 && (axis == 3 || powers[i] < powers[axis]) {
                axis = i;
            }
            i += 1;
        }
        let mut less = powers;
        less[axis] -= 1;
        let mut twice_less = 0;
        let factor = less[axis];
        if factor > 0 {
            let mut twice = less;
            twice[axis] -= 1;
            twice_less = index(twice);
        }
        steps[k] = Step { axis, less: index(less), twice_less, factor };
        k += 1;
    }
    steps
};

/// One over the factorials of the powers of each term.
pub(super) const BY_FACTORIALS: [f64; TERMS] = {
    let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0];
    let mut by = [0.0; TERMS];
    let mut k = 0;
    while k < TERMS {
        let [a, b, c] = POWERS[k];
        by[k] = 1.0 / (factorial[a] * factorial[b] * factorial[c]);
        k += 1;
    }
    by
};

/// How far expansions go.
pub(super) trait Order: Copy + Send + Sync + 'static {
    /// The degree of the highest derivative of the potential that they have.
    const DEGREE: usize;
    /// The degree of the highest moment: that of the field, whose derivatives begin with the first, needs no higher one.
    const MOMENTS: usize = Self::DEGREE - 1;
    /// Numbers for all terms.
    type Terms<T: Copy>: AsRef<[T]> + AsMut<[T]> + Copy;
    /// All terms alike.
    fn all<T: Copy>(number: T) -> Self::Terms<T>;
}

macro_rules! orders {
    ($($(#[$doc:meta])* $name:ident $degree:literal,)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $name;

        impl Order for $name {
            const DEGREE: usize = $degree;
            type Terms<T: Copy> = [T; count($degree)];
            #[inline(always)]
            fn all<T: Copy>(number: T) -> Self::Terms<T> {
                [number; count($degree)]
            }
        }
    )*};
}
orders! {
    /// Third derivatives, quadrupoles.
    Third 3,
    /// Fourth derivatives, octupoles.
    Fourth 4,
    /// Fifth derivatives, moments of the fourth degree.
    Fifth 5,
}

/// Writes a body out once for each term below a number that is known when a body is compiled for an order: then no number is fetched
/// through a table, and most derivatives stay in registers (measured: a third of the time of a loop).
macro_rules! each_term {
    ($k:ident below $count:expr, $body:block) => {
        $crate::backend::far::terms::each_term! { @ $k, $count, $body,
            0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37
            38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55
        }
    };
    ($k:ident down from $count:expr, $body:block) => {
        $crate::backend::far::terms::each_term! { @ $k, $count, $body,
            55 54 53 52 51 50 49 48 47 46 45 44 43 42 41 40 39 38 37 36 35 34 33 32 31 30 29 28 27 26 25 24 23 22 21
            20 19 18 17 16 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1
        }
    };
    (@ $k:ident, $count:expr, $body:block, $($number:literal)+) => {$(
        {
            const $k: usize = $number;
            if $k < $count $body
        }
    )+};
}
pub(super) use each_term;
