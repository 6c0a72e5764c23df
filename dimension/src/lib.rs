//! Physical dimensions and units.
//!
//! In: a unit's text, as people write it ("m^3 kg^-1 s^-2"). Out: its [`Dimension`] and its size in SI base units, at
//! compile time or at run time, by the same code. Never: numbers with units attached; values stay plain `f64`.
//!
//! ```
//! use vesper_dimension::Unit;
//! const GRAVITATION: Unit = Unit::expect("m^3 kg^-1 s^-2");
//! let kilometre_per_hour = Unit::parse("km/h").unwrap();
//! let factor = kilometre_per_hour.factor_to(Unit::expect("m/s")).unwrap();
//! assert!((36.0 * factor - 10.0).abs() < 1e-12);
//! assert_eq!(GRAVITATION.dimension.to_string(), "m^3 kg^-1 s^-2");
//! ```
//!
//! # Grammar
//!
//! A unit is a product of factors: `kg m`, `kg*m` and `kg·m` are the same. **A `/` divides by the one factor after
//! it**, as in ordinary arithmetic: `kg/m/s^2` is kg m^-1 s^-2, and `J/kg K` is (J/kg) K; write `J/(kg K)` or
//! `J kg^-1 K^-1` where both divide. A factor is a symbol, `1`, or a product in parentheses, each with an optional
//! integer exponent: `s^-2`, `(m/s)^2`. The empty text is dimensionless, as `1` is.
//!
//! A symbol means itself first (`min` is the minute, `cd` the candela, `Pa` the pascal) and only then a prefix and a
//! symbol that takes prefixes (`ms`, `daN`, `kpc`). [`known`] lists the symbols.

mod dimension;
mod parse;
mod suggest;
mod symbols;
mod unit;

pub use dimension::Dimension;
pub use symbols::known;
pub use unit::{Unit, UnitError};
