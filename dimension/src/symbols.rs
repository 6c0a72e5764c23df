//! In: nothing. Out: the closed tables of unit symbols and prefixes, and their look-up. Never: products; see `parse`.

/// A unit symbol: its exponents of m, kg, s, A, K, mol, cd, and its size `mantissa * 10^decimal` in SI base units.
///
/// The power of ten stands apart so that it is applied once, at the end: "g/cm^3" is exactly 1000 kg/m^3.
#[derive(Clone, Copy)]
pub(crate) struct Symbol {
    pub(crate) text: &'static str,
    pub(crate) exponents: [i8; 7],
    pub(crate) mantissa: f64,
    pub(crate) decimal: i32,
    /// Whether prefixes stand before it.
    pub(crate) prefixed: bool,
}

const fn symbol(text: &'static str, exponents: [i8; 7], mantissa: f64, decimal: i32, prefixed: bool) -> Symbol {
    Symbol { text, exponents, mantissa, decimal, prefixed }
}

/// A coherent SI unit: size 1, takes prefixes.
const fn coherent(text: &'static str, exponents: [i8; 7]) -> Symbol {
    symbol(text, exponents, 1.0, 0, true)
}

const LENGTH: [i8; 7] = [1, 0, 0, 0, 0, 0, 0];
const MASS: [i8; 7] = [0, 1, 0, 0, 0, 0, 0];
const TIME: [i8; 7] = [0, 0, 1, 0, 0, 0, 0];
const ENERGY: [i8; 7] = [2, 1, -2, 0, 0, 0, 0];
const PRESSURE: [i8; 7] = [-1, 1, -2, 0, 0, 0, 0];
const RESISTANCE: [i8; 7] = [2, 1, -3, -2, 0, 0, 0];
const NUMBER: [i8; 7] = [0; 7];

/// Seconds of a Julian year, 365.25 days.
const JULIAN_YEAR: f64 = 31_557_600.0;

/// Every symbol. Sizes: SI brochure, 9th edition; IAU 2012 resolution B2 (au) and 2015 resolution B2 (pc); CODATA 2022 (u).
pub(crate) const SYMBOLS: [Symbol; 36] = [
    coherent("m", LENGTH),
    symbol("kg", MASS, 1.0, 0, false),
    symbol("g", MASS, 1.0, -3, true),
    coherent("s", TIME),
    coherent("A", [0, 0, 0, 1, 0, 0, 0]),
    coherent("K", [0, 0, 0, 0, 1, 0, 0]),
    coherent("mol", [0, 0, 0, 0, 0, 1, 0]),
    coherent("cd", [0, 0, 0, 0, 0, 0, 1]),
    coherent("N", [1, 1, -2, 0, 0, 0, 0]),
    coherent("J", ENERGY),
    coherent("W", [2, 1, -3, 0, 0, 0, 0]),
    coherent("Pa", PRESSURE),
    coherent("Hz", [0, 0, -1, 0, 0, 0, 0]),
    coherent("C", [0, 0, 1, 1, 0, 0, 0]),
    coherent("V", [2, 1, -3, -1, 0, 0, 0]),
    coherent("Ohm", RESISTANCE),
    coherent("\u{3a9}", RESISTANCE),  // the Greek letter
    coherent("\u{2126}", RESISTANCE), // the ohm sign
    coherent("T", [0, 1, -2, -1, 0, 0, 0]),
    coherent("Wb", [2, 1, -2, -1, 0, 0, 0]),
    coherent("F", [-2, -1, 4, 2, 0, 0, 0]),
    coherent("H", [2, 1, -2, -2, 0, 0, 0]),
    coherent("rad", NUMBER),
    symbol("deg", NUMBER, std::f64::consts::PI / 180.0, 0, false),
    symbol("min", TIME, 60.0, 0, false),
    symbol("h", TIME, 3600.0, 0, false),
    symbol("d", TIME, 86_400.0, 0, false),
    symbol("a", TIME, JULIAN_YEAR, 0, false),
    symbol("yr", TIME, JULIAN_YEAR, 0, false),
    symbol("au", LENGTH, 149_597_870_700.0, 0, false),
    symbol("ly", LENGTH, 9_460_730_472_580_800.0, 0, true),
    symbol("pc", LENGTH, 149_597_870_700.0 * 648_000.0 / std::f64::consts::PI, 0, true),
    symbol("eV", ENERGY, 1.602_176_634e-19, 0, true),
    symbol("u", MASS, 1.660_539_068_92e-27, 0, false),
    symbol("L", [3, 0, 0, 0, 0, 0, 0], 1.0, -3, true),
    symbol("bar", PRESSURE, 1.0, 5, true),
];

/// The prefixes and their powers of ten. "da" stands before "d" so that "dam" is the decametre.
pub(crate) const PREFIXES: [(&str, i32); 22] = [
    ("da", 1),
    ("Y", 24),
    ("Z", 21),
    ("E", 18),
    ("P", 15),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("\u{b5}", -6),  // the micro sign
    ("\u{3bc}", -6), // the Greek letter
    ("n", -9),
    ("p", -12),
    ("f", -15),
    ("a", -18),
    ("z", -21),
    ("y", -24),
];

const TEXTS: [&str; SYMBOLS.len()] = {
    let mut texts = [""; SYMBOLS.len()];
    let mut i = 0;
    while i < SYMBOLS.len() {
        texts[i] = SYMBOLS[i].text;
        i += 1;
    }
    texts
};

/// The unit symbols, without prefixes, for help texts.
pub fn known() -> &'static [&'static str] {
    &TEXTS
}

/// The symbol that `text[start..end]` spells, with the power of ten of its prefix.
pub(crate) const fn find(text: &[u8], start: usize, end: usize) -> Option<(Symbol, i32)> {
    let mut i = 0;
    while i < SYMBOLS.len() {
        if spells(text, start, end, SYMBOLS[i].text) {
            return Some((SYMBOLS[i], 0));
        }
        i += 1;
    }
    let mut p = 0;
    while p < PREFIXES.len() {
        let (prefix, decimal) = PREFIXES[p];
        let after = start + prefix.len();
        if after < end && spells(text, start, after, prefix) {
            let mut i = 0;
            while i < SYMBOLS.len() {
                if SYMBOLS[i].prefixed && spells(text, after, end, SYMBOLS[i].text) {
                    return Some((SYMBOLS[i], decimal));
                }
                i += 1;
            }
        }
        p += 1;
    }
    None
}

/// Whether `text[start..end]` is `word`.
const fn spells(text: &[u8], start: usize, end: usize, word: &str) -> bool {
    let word = word.as_bytes();
    if end - start != word.len() {
        return false;
    }
    let mut i = 0;
    while i < word.len() {
        if text[start + i] != word[i] {
            return false;
        }
        i += 1;
    }
    true
}
