//! In: a word that is no unit. Out: the nearest one that is. Runs only when a fault is put into words.

use crate::symbols::{PREFIXES, SYMBOLS};

/// Names that people write out, with their symbols.
const NAMES: [(&str, &str); 44] = [
    ("metre", "m"),
    ("meter", "m"),
    ("kilometre", "km"),
    ("kilometer", "km"),
    ("gram", "g"),
    ("kilogram", "kg"),
    ("kilo", "kg"),
    ("second", "s"),
    ("sec", "s"),
    ("ampere", "A"),
    ("amp", "A"),
    ("kelvin", "K"),
    ("mole", "mol"),
    ("candela", "cd"),
    ("newton", "N"),
    ("joule", "J"),
    ("watt", "W"),
    ("pascal", "Pa"),
    ("hertz", "Hz"),
    ("coulomb", "C"),
    ("volt", "V"),
    ("ohm", "Ohm"),
    ("tesla", "T"),
    ("weber", "Wb"),
    ("farad", "F"),
    ("henry", "H"),
    ("radian", "rad"),
    ("degree", "deg"),
    ("\u{b0}", "deg"),
    ("minute", "min"),
    ("hour", "h"),
    ("hr", "h"),
    ("day", "d"),
    ("year", "yr"),
    ("lightyear", "ly"),
    ("parsec", "pc"),
    ("electronvolt", "eV"),
    ("dalton", "u"),
    ("amu", "u"),
    ("litre", "L"),
    ("liter", "L"),
    ("l", "L"),
    ("myr", "yr"),
    ("gyr", "yr"),
];

/// The unit that `piece` most likely means: its name written out, its exponent without `^`, or the fewest edits.
pub(crate) fn nearest(piece: &str) -> String {
    let lower = piece.to_lowercase();
    let singular = lower.strip_suffix('s').unwrap_or(&lower);
    if let Some((_, symbol)) = NAMES.iter().find(|(name, _)| *name == lower || *name == singular) {
        return (*symbol).to_string();
    }
    let letters = piece.trim_end_matches(|c: char| c.is_ascii_digit());
    if letters.len() < piece.len() && crate::Unit::parse(letters).is_ok() {
        return format!("{letters}^{}", &piece[letters.len()..]);
    }
    // Plain symbols first, so that they win at equal distance; then names written out, then prefixed symbols.
    let plain = SYMBOLS.iter().map(|symbol| (symbol.text.to_string(), symbol.text.to_string()));
    let names = NAMES.iter().map(|(name, symbol)| ((*name).to_string(), (*symbol).to_string()));
    let prefixed = PREFIXES.iter().flat_map(|(prefix, _)| {
        SYMBOLS.iter().filter(|symbol| symbol.prefixed).map(move |symbol| {
            let text = format!("{prefix}{}", symbol.text);
            (text.clone(), text)
        })
    });
    let mut best = (usize::MAX, String::new());
    for (candidate, symbol) in plain.chain(names).chain(prefixed) {
        let distance = distance(piece, &candidate);
        if distance < best.0 {
            best = (distance, symbol);
        }
    }
    best.1
}

/// Levenshtein distance in thirds of a step: an edit costs 3, the same letter in the other case 1.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).map(|j| 3 * j).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = 3 * (i + 1);
        for (j, &y) in b.iter().enumerate() {
            let replace = match (x == y, x.eq_ignore_ascii_case(&y)) {
                (true, _) => 0,
                (false, true) => 1,
                (false, false) => 3,
            };
            let next = (diagonal + replace).min(row[j] + 3).min(row[j + 1] + 3);
            diagonal = row[j + 1];
            row[j + 1] = next;
        }
    }
    row[b.len()]
}
