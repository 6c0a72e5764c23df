//! In: exponents. Out: a [`Dimension`] that multiplies, divides and prints. Never: sizes; see `unit`.

use std::fmt;

/// Symbols of the SI base units, in the order of the exponents.
pub(crate) const BASE: [&str; 7] = ["m", "kg", "s", "A", "K", "mol", "cd"];

/// Exponents of the SI base units m, kg, s, A, K, mol, cd.
///
/// Products saturate at the range of `i8`; [`Unit::parse`](crate::Unit::parse) refuses such exponents.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Dimension {
    exponents: [i8; 7],
}

impl Dimension {
    /// The dimension of a pure number.
    pub const NONE: Self = Self { exponents: [0; 7] };

    /// The dimension with these exponents of m, kg, s, A, K, mol, cd.
    pub const fn new(exponents: [i8; 7]) -> Self {
        Self { exponents }
    }

    /// Exponents of m, kg, s, A, K, mol, cd.
    pub const fn exponents(self) -> [i8; 7] {
        self.exponents
    }

    /// The dimension of a product.
    pub const fn times(self, other: Self) -> Self {
        let mut exponents = self.exponents;
        let mut i = 0;
        while i < 7 {
            exponents[i] = exponents[i].saturating_add(other.exponents[i]);
            i += 1;
        }
        Self { exponents }
    }

    /// The dimension of a quotient.
    pub const fn over(self, other: Self) -> Self {
        let mut exponents = self.exponents;
        let mut i = 0;
        while i < 7 {
            exponents[i] = exponents[i].saturating_sub(other.exponents[i]);
            i += 1;
        }
        Self { exponents }
    }

    /// The dimension of the `n`-th power.
    pub const fn power(self, n: i8) -> Self {
        let mut exponents = self.exponents;
        let mut i = 0;
        while i < 7 {
            exponents[i] = exponents[i].saturating_mul(n);
            i += 1;
        }
        Self { exponents }
    }

    /// Whether both are the same dimension; `==` for constants.
    pub const fn equals(self, other: Self) -> bool {
        let mut i = 0;
        while i < 7 {
            if self.exponents[i] != other.exponents[i] {
                return false;
            }
            i += 1;
        }
        true
    }
}

/// "m^3 kg^-1 s^-2"; a pure number prints "1". The text parses back to the same dimension.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        for (symbol, &exponent) in BASE.iter().zip(&self.exponents) {
            let space = if text.is_empty() { "" } else { " " };
            match exponent {
                0 => {}
                1 => text += &format!("{space}{symbol}"),
                n => text += &format!("{space}{symbol}^{n}"),
            }
        }
        f.pad(if text.is_empty() { "1" } else { &text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_of_exponents() {
        const LENGTH: Dimension = Dimension::new([1, 0, 0, 0, 0, 0, 0]);
        const TIME: Dimension = Dimension::new([0, 0, 1, 0, 0, 0, 0]);
        const SPEED: Dimension = LENGTH.over(TIME);
        const { assert!(SPEED.times(TIME).equals(LENGTH)) }
        assert_eq!(SPEED.power(2).exponents(), [2, 0, -2, 0, 0, 0, 0]);
        assert_eq!(SPEED.power(0), Dimension::NONE);
        assert_eq!(LENGTH.power(127).times(LENGTH).exponents()[0], 127);
    }

    #[test]
    fn prints_in_the_order_of_the_base_units() {
        assert_eq!(Dimension::new([3, -1, -2, 0, 0, 0, 0]).to_string(), "m^3 kg^-1 s^-2");
        assert_eq!(Dimension::new([0, 0, 0, 1, 1, 1, 1]).to_string(), "A K mol cd");
        assert_eq!(Dimension::NONE.to_string(), "1");
    }
}
