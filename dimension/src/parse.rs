//! In: a unit's text. Out: its exponents and size, or the byte range of the piece that is wrong. All of it `const`, so
//! it is plain loops over bytes. Never: help texts; see `suggest`.

use crate::symbols::find;
use crate::{Dimension, Unit, UnitError};

/// Parentheses nest no deeper than this: recursion stays bounded for any text.
const DEEPEST: u32 = 8;

/// A partial product: exponents, and the size as `mantissa * 10^decimal`.
#[derive(Clone, Copy)]
struct Product {
    exponents: [i32; 7],
    mantissa: f64,
    decimal: i32,
}

impl Product {
    const ONE: Self = Self { exponents: [0; 7], mantissa: 1.0, decimal: 0 };

    /// `self * factor^power`, or `None` where an exponent leaves the range of `i8`.
    const fn times(mut self, factor: Self, power: i32) -> Option<Self> {
        let mut i = 0;
        while i < 7 {
            self.exponents[i] += factor.exponents[i] * power;
            if self.exponents[i] < i8::MIN as i32 || self.exponents[i] > i8::MAX as i32 {
                return None;
            }
            i += 1;
        }
        self.decimal += factor.decimal * power;
        let mut size = 1.0;
        let mut n = 0;
        while n < power.abs() {
            size *= factor.mantissa;
            n += 1;
        }
        self.mantissa = if power < 0 { self.mantissa / size } else { self.mantissa * size };
        // Beyond this the size is no f64 any more, whatever follows; and `decimal` cannot overflow.
        if self.decimal.abs() > 100_000 || !self.mantissa.is_normal() { None } else { Some(self) }
    }
}

/// Where a parse stands after a piece, and what it has so far.
type Step = Result<(Product, usize), UnitError>;

pub(crate) const fn unit(text: &str) -> Result<Unit, UnitError> {
    let text = text.as_bytes();
    match product(text, 0, 0) {
        Err(error) => Err(error),
        Ok((_, at)) if at < text.len() => Err(UnitError::Unexpected { start: at, end: after_character(text, at) }),
        Ok((whole, _)) => {
            let scale = scaled(whole.mantissa, whole.decimal);
            if !scale.is_normal() {
                return Err(UnitError::Range { start: 0, end: text.len() });
            }
            let mut exponents = [0; 7];
            let mut i = 0;
            while i < 7 {
                exponents[i] = whole.exponents[i] as i8;
                i += 1;
            }
            Ok(Unit { dimension: Dimension::new(exponents), scale })
        }
    }
}

/// Factors from `at` to the end of the text or to a closing parenthesis.
const fn product(text: &[u8], mut at: usize, depth: u32) -> Step {
    let mut whole = Product::ONE;
    let mut first = true;
    loop {
        at = skip_spaces(text, at);
        if at == text.len() || text[at] == b')' {
            return Ok((whole, at));
        }
        let mut sign = 1;
        let operator = at;
        let wide = dot(text, at);
        if wide || text[at] == b'*' || text[at] == b'/' {
            let end = if wide { at + 2 } else { at + 1 };
            sign = if text[at] == b'/' { -1 } else { 1 };
            at = skip_spaces(text, end);
            if first || at == text.len() {
                return Err(UnitError::Unexpected { start: operator, end });
            }
        }
        first = false;
        let start = at;
        let (one, next) = match factor(text, at, depth) {
            Ok(found) => found,
            Err(error) => return Err(error),
        };
        at = next;
        whole = match whole.times(one, sign) {
            Some(product) => product,
            None => return Err(UnitError::Range { start, end: at }),
        };
    }
}

/// A symbol, `1`, or a product in parentheses, with its exponent.
const fn factor(text: &[u8], start: usize, depth: u32) -> Step {
    let (base, end) = if text[start] == b'(' {
        let bad = UnitError::Unexpected { start, end: start + 1 };
        if depth == DEEPEST {
            return Err(bad);
        }
        match product(text, start + 1, depth + 1) {
            Ok((inside, close)) if close < text.len() => (inside, close + 1),
            Ok(_) => return Err(bad),
            Err(error) => return Err(error),
        }
    } else {
        let end = word(text, start);
        if end == start {
            return Err(UnitError::Unexpected { start, end: after_character(text, start) });
        }
        if end == start + 1 && text[start] == b'1' {
            (Product::ONE, end)
        } else {
            match find(text, start, end) {
                None => return Err(UnitError::Unknown { start, end }),
                Some((symbol, decimal)) => {
                    let mut exponents = [0; 7];
                    let mut i = 0;
                    while i < 7 {
                        exponents[i] = symbol.exponents[i] as i32;
                        i += 1;
                    }
                    (Product { exponents, mantissa: symbol.mantissa, decimal: symbol.decimal + decimal }, end)
                }
            }
        }
    };
    if end == text.len() || text[end] != b'^' {
        return Ok((base, end));
    }
    let (power, next) = match exponent(text, end + 1) {
        Ok(found) => found,
        Err(error) => return Err(error),
    };
    match Product::ONE.times(base, power) {
        Some(raised) => Ok((raised, next)),
        None => Err(UnitError::Range { start, end: next }),
    }
}

/// An integer with an optional sign.
const fn exponent(text: &[u8], start: usize) -> Result<(i32, usize), UnitError> {
    let mut at = start;
    let negative = at < text.len() && text[at] == b'-';
    if negative || (at < text.len() && text[at] == b'+') {
        at += 1;
    }
    let digits = at;
    let mut value = 0;
    while at < text.len() && text[at].is_ascii_digit() {
        if value <= 999 {
            value = 10 * value + (text[at] - b'0') as i32;
        }
        at += 1;
    }
    let end = word(text, at);
    let fraction = end < text.len() && text[end] == b'.';
    if at == digits || end > at || fraction {
        let end = if fraction { word(text, end + 1) } else { end };
        // The range of a missing exponent is the `^` before it.
        return Err(UnitError::Exponent { start: if end == start { start - 1 } else { start }, end });
    }
    if value > i8::MAX as i32 {
        return Err(UnitError::Range { start, end: at });
    }
    Ok((if negative { -value } else { value }, at))
}

/// The end of the letters and digits from `at`; all bytes beyond ASCII count, but for those of the dot `·`.
const fn word(text: &[u8], mut at: usize) -> usize {
    while at < text.len() && (text[at].is_ascii_alphanumeric() || (text[at] >= 0x80 && !dot(text, at))) {
        at = after_character(text, at);
    }
    at
}

/// Whether the multiplication dot U+00B7 stands at `at`.
const fn dot(text: &[u8], at: usize) -> bool {
    text[at] == 0xc2 && at + 1 < text.len() && text[at + 1] == 0xb7
}

const fn skip_spaces(text: &[u8], mut at: usize) -> usize {
    while at < text.len() && text[at].is_ascii_whitespace() {
        at += 1;
    }
    at
}

/// The end of the character that starts at `at`.
const fn after_character(text: &[u8], at: usize) -> usize {
    let mut end = at + 1;
    while end < text.len() && text[end] & 0xc0 == 0x80 {
        end += 1;
    }
    end
}

/// `mantissa * 10^decimal`, by one exact power of ten wherever that fits: correctly rounded for mantissa 1.
const fn scaled(mut mantissa: f64, mut decimal: i32) -> f64 {
    while decimal != 0 && mantissa.is_normal() {
        let part = if decimal.abs() > 22 { 22 } else { decimal.abs() };
        let mut power = 1.0;
        let mut i = 0;
        while i < part {
            power *= 10.0;
            i += 1;
        }
        if decimal < 0 {
            mantissa /= power;
            decimal += part;
        } else {
            mantissa *= power;
            decimal -= part;
        }
    }
    mantissa
}
