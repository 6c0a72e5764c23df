//! Units written out with a prefix before them: "msec", "kilometres".
//!
//! In: what is wrong with a unit, and its text. Out: words that never suggest a unit of another size: the library looks for
//! the fewest edits, and would take the prefix for one of them. Never: a unit that is right.

use vesper_dimension::{Unit, UnitError};

const PREFIXES: [(&str, &str); 21] = [
    ("nano", "n"),
    ("micro", "µ"),
    ("milli", "m"),
    ("centi", "c"),
    ("kilo", "k"),
    ("mega", "M"),
    ("giga", "G"),
    ("tera", "T"),
    ("n", "n"),
    ("u", "µ"),
    ("µ", "µ"),
    ("m", "m"),
    ("c", "c"),
    ("k", "k"),
    ("K", "k"),
    ("M", "M"),
    ("G", "G"),
    ("g", "G"),
    ("T", "T"),
    ("Kilo", "k"),
    ("Mega", "M"),
];

const NAMES: [(&str, &str); 21] = [
    ("sec", "s"),
    ("second", "s"),
    ("metre", "m"),
    ("meter", "m"),
    ("gram", "g"),
    ("yr", "yr"),
    ("year", "yr"),
    ("newton", "N"),
    ("joule", "J"),
    ("watt", "W"),
    ("pascal", "Pa"),
    ("hertz", "Hz"),
    ("hz", "Hz"),
    ("coulomb", "C"),
    ("volt", "V"),
    ("tesla", "T"),
    ("amp", "A"),
    ("ampere", "A"),
    ("kelvin", "K"),
    ("parsec", "pc"),
    ("electronvolt", "eV"),
];

/// The message for the unit `text`, and help where that stands apart.
pub(super) fn message(error: UnitError, text: &str) -> (String, Option<String>) {
    let (start, end) = error.range();
    let piece = text.get(start..end).unwrap_or(text);
    let prefixed = if let UnitError::Unknown { .. } = error { prefixed(piece) } else { None };
    let Some((prefix, symbol)) = prefixed else { return (error.message(text), None) };
    let unknown = format!("unknown unit `{piece}` in \"{text}\"");
    let meant = format!("{prefix}{symbol}");
    match Unit::parse(&meant) {
        Ok(_) => (format!("{unknown}: did you mean `{meant}`?"), None),
        Err(_) => (unknown, Some(format!("`{symbol}` takes no prefix: write the number in {symbol}"))),
    }
}

/// The symbols of a prefix and of the unit behind it.
fn prefixed(piece: &str) -> Option<(&'static str, &'static str)> {
    PREFIXES.iter().find_map(|(word, prefix)| {
        let rest = piece.strip_prefix(word)?.to_lowercase();
        let known = |name: &str| NAMES.iter().find(|(known, _)| *known == name);
        let (_, symbol) = known(&rest).or_else(|| known(rest.strip_suffix('s')?))?;
        Some((*prefix, *symbol))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suggestion_has_the_size_that_was_meant() {
        for (text, expected) in [
            ("msec", "did you mean `ms`?"),
            ("m/usecs^2", "did you mean `µs`?"),
            ("kilometres", "did you mean `km`?"),
            ("Megaparsec", "did you mean `Mpc`?"),
            ("MHertz", "did you mean `MHz`?"),
            ("sec", "did you mean `s`?"),
            ("meter", "did you mean `m`?"),
        ] {
            let (said, help) = message(Unit::parse(text).unwrap_err(), text);
            assert!(said.ends_with(expected) && help.is_none(), "{text}: {said}");
        }
        let (said, help) = message(Unit::parse("Gyear").unwrap_err(), "Gyear");
        assert_eq!(said, "unknown unit `Gyear` in \"Gyear\"");
        assert_eq!(help.as_deref(), Some("`yr` takes no prefix: write the number in yr"));
    }
}
