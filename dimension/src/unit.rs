//! In: a unit's text. Out: a [`Unit`], or a [`UnitError`] that points at the piece that is wrong.

use std::fmt;

use crate::{Dimension, parse, suggest};

/// A unit: its dimension and its size in SI base units. "km/s" is 1000 m s^-1.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Unit {
    /// What it measures.
    pub dimension: Dimension,
    /// How many SI base units one of it is; always finite and positive when parsed.
    pub scale: f64,
}

impl Unit {
    /// The unit of a pure number.
    pub const ONE: Self = Self { dimension: Dimension::NONE, scale: 1.0 };

    /// The unit that `text` means; the [grammar](crate) is in the crate's documentation.
    pub const fn parse(text: &str) -> Result<Self, UnitError> {
        parse::unit(text)
    }

    /// The unit that `text` means, for constants: a wrong text stops the compilation with the reason.
    ///
    /// # Panics
    /// Where `text` is no unit. Use [`Unit::parse`] for text that comes at run time.
    pub const fn expect(text: &str) -> Self {
        match Self::parse(text) {
            Ok(unit) => unit,
            Err(UnitError::Unknown { .. }) => panic!("unknown unit symbol in a unit"),
            Err(UnitError::Exponent { .. }) => panic!("an exponent in a unit is not an integer"),
            Err(UnitError::Range { .. }) => panic!("an exponent or the size of a unit is out of range"),
            Err(UnitError::Unexpected { .. }) => panic!("unexpected character in a unit"),
        }
    }

    /// The number by which a value in this unit is multiplied to be in unit `to`; `None` where dimensions differ.
    pub fn factor_to(self, to: Self) -> Option<f64> {
        self.dimension.equals(to.dimension).then(|| self.scale / to.scale)
    }
}

/// What is wrong with a unit's text; `start..end` is the byte range of the piece.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum UnitError {
    /// A piece is no known symbol, nor a prefix and a symbol that takes prefixes.
    Unknown {
        /// First byte of the piece.
        start: usize,
        /// The byte after the piece.
        end: usize,
    },
    /// The exponent after `^` is missing or no integer.
    Exponent {
        /// First byte of the piece.
        start: usize,
        /// The byte after the piece.
        end: usize,
    },
    /// An exponent is beyond -128..127, or the size beyond the range of `f64`.
    Range {
        /// First byte of the piece.
        start: usize,
        /// The byte after the piece.
        end: usize,
    },
    /// A character has no place here: an operator without a factor, a parenthesis without its partner (or nested deeper
    /// than eight), a sign that units do not have.
    Unexpected {
        /// First byte of the piece.
        start: usize,
        /// The byte after the piece.
        end: usize,
    },
}

impl UnitError {
    /// First byte of the wrong piece, and the byte after it.
    pub const fn range(self) -> (usize, usize) {
        match self {
            Self::Unknown { start, end }
            | Self::Exponent { start, end }
            | Self::Range { start, end }
            | Self::Unexpected { start, end } => (start, end),
        }
    }

    /// The fault in words: the piece of `text` that is wrong, and what to write instead.
    pub fn message(&self, text: &str) -> String {
        let (start, end) = self.range();
        let piece = text.get(start..end).unwrap_or(text);
        match self {
            Self::Unknown { .. } if piece.bytes().all(|byte| byte.is_ascii_digit()) => {
                format!("number `{piece}` in unit \"{text}\": the only number in a unit is 1")
            }
            Self::Unknown { .. } => {
                let nearest = suggest::nearest(piece);
                format!("unknown unit `{piece}` in \"{text}\": did you mean `{nearest}`?")
            }
            Self::Exponent { .. } => {
                format!("exponent `{piece}` in unit \"{text}\" is not an integer: write it as in \"m^2\" or \"s^-1\"")
            }
            Self::Range { .. } => format!("`{piece}` in unit \"{text}\" is out of range: use smaller exponents"),
            Self::Unexpected { .. } => {
                format!("unexpected `{piece}` in unit \"{text}\": write a unit as in \"kg m/s^2\" or \"J/(kg K)\"")
            }
        }
    }
}

/// The fault without its text; [`UnitError::message`] says more.
impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (start, end) = self.range();
        let what = match self {
            Self::Unknown { .. } => "unknown unit",
            Self::Exponent { .. } => "exponent that is not an integer",
            Self::Range { .. } => "exponent or size out of range",
            Self::Unexpected { .. } => "unexpected character",
        };
        write!(f, "{what} at bytes {start}..{end} of a unit")
    }
}

impl std::error::Error for UnitError {}
