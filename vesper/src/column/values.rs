//! The forms in which a client gives the values of a column.

use glam::{DVec3, Vec3};

/// Values of a column as the client gives them: `width` numbers for each row.
///
/// Made from arrays, slices and vectors of numbers, of `[f64; 3]`, or of glam's vectors; a function that takes
/// `impl Into<Values>` takes any of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Numbers in one value.
    pub width: usize,
    /// The numbers, one value after the other.
    pub numbers: Vec<f64>,
}

impl Values {
    /// `width` numbers for each row.
    pub fn new(width: usize, numbers: Vec<f64>) -> Self {
        Values { width, numbers }
    }

    /// The same as one value of this width, where there are just as many numbers: for a constant, `[0.0, 0.0, -9.81]` is
    /// one vector and not three scalars.
    #[must_use]
    pub fn as_one(self, width: usize) -> Self {
        if self.numbers.len() == width { Values { width, ..self } } else { self }
    }

    /// How many values there are.
    pub fn rows(&self) -> usize {
        self.numbers.len() / self.width.max(1)
    }
}

macro_rules! from_sequence {
    ($item:ty, $width:expr, |$value:ident| $numbers:expr) => {
        impl From<&[$item]> for Values {
            fn from(rows: &[$item]) -> Self {
                Values::new($width, rows.iter().flat_map(|$value| $numbers).collect())
            }
        }
        impl From<Vec<$item>> for Values {
            fn from(rows: Vec<$item>) -> Self {
                rows.as_slice().into()
            }
        }
        impl From<&Vec<$item>> for Values {
            fn from(rows: &Vec<$item>) -> Self {
                rows.as_slice().into()
            }
        }
        impl<const ROWS: usize> From<[$item; ROWS]> for Values {
            fn from(rows: [$item; ROWS]) -> Self {
                rows.as_slice().into()
            }
        }
    };
}
from_sequence!(f64, 1, |value| [*value]);
from_sequence!(f32, 1, |value| [f64::from(*value)]);
from_sequence!([f64; 3], 3, |value| *value);
from_sequence!([f32; 3], 3, |value| value.map(f64::from));
from_sequence!([f64; 4], 4, |value| *value);
from_sequence!([f32; 4], 4, |value| value.map(f64::from));
from_sequence!(DVec3, 3, |value| value.to_array());
from_sequence!(Vec3, 3, |value| value.to_array().map(f64::from));

/// One number, as a single value.
impl From<f64> for Values {
    fn from(value: f64) -> Self {
        Values::new(1, vec![value])
    }
}
/// One vector, as a single value.
impl From<DVec3> for Values {
    fn from(value: DVec3) -> Self {
        Values::new(3, value.to_array().to_vec())
    }
}
