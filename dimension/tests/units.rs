//! The closed table of units, their use in constants, and every kind of fault.

use vesper_dimension::{Dimension, Unit, UnitError, known};

const G: Unit = Unit::expect("m^3 kg^-1 s^-2");

fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap_or_else(|error| panic!("{}", error.message(text)))
}

#[test]
fn every_symbol_has_its_dimension_and_size() {
    let table: &[(&str, &str, f64)] = &[
        ("m", "m", 1.0),
        ("kg", "kg", 1.0),
        ("g", "kg", 1e-3),
        ("s", "s", 1.0),
        ("A", "A", 1.0),
        ("K", "K", 1.0),
        ("mol", "mol", 1.0),
        ("cd", "cd", 1.0),
        ("N", "m kg s^-2", 1.0),
        ("J", "m^2 kg s^-2", 1.0),
        ("W", "m^2 kg s^-3", 1.0),
        ("Pa", "m^-1 kg s^-2", 1.0),
        ("Hz", "s^-1", 1.0),
        ("C", "s A", 1.0),
        ("V", "m^2 kg s^-3 A^-1", 1.0),
        ("Ohm", "m^2 kg s^-3 A^-2", 1.0),
        ("\u{3a9}", "m^2 kg s^-3 A^-2", 1.0),
        ("\u{2126}", "m^2 kg s^-3 A^-2", 1.0),
        ("T", "kg s^-2 A^-1", 1.0),
        ("Wb", "m^2 kg s^-2 A^-1", 1.0),
        ("F", "m^-2 kg^-1 s^4 A^2", 1.0),
        ("H", "m^2 kg s^-2 A^-2", 1.0),
        ("rad", "1", 1.0),
        ("deg", "1", std::f64::consts::PI / 180.0),
        ("min", "s", 60.0),
        ("h", "s", 3600.0),
        ("d", "s", 86_400.0),
        ("a", "s", 365.25 * 86_400.0),
        ("yr", "s", 365.25 * 86_400.0),
        ("au", "m", 149_597_870_700.0),
        ("ly", "m", 299_792_458.0 * 365.25 * 86_400.0),
        ("pc", "m", 3.085_677_581_491_367e16),
        ("eV", "m^2 kg s^-2", 1.602_176_634e-19),
        ("u", "kg", 1.660_539_068_92e-27),
        ("L", "m^3", 1e-3),
        ("bar", "m^-1 kg s^-2", 1e5),
    ];
    let listed: Vec<&str> = table.iter().map(|row| row.0).collect();
    assert_eq!(listed, known(), "the table above and the symbols are the same list");
    for &(text, dimension, scale) in table {
        let found = unit(text);
        assert_eq!(found.dimension.to_string(), dimension, "{text}");
        assert!((found.scale / scale - 1.0).abs() < 1e-15, "{text}: {} is not {scale}", found.scale);
        assert_eq!(unit(dimension).dimension, found.dimension, "{dimension} parses back");
    }
}

#[test]
fn products_quotients_and_prefixes() {
    let table: &[(&str, &str, f64)] = &[
        ("", "1", 1.0),
        ("1", "1", 1.0),
        ("  ", "1", 1.0),
        ("1/s", "s^-1", 1.0),
        ("m^3 kg^-1 s^-2", "m^3 kg^-1 s^-2", 1.0),
        ("kg m/s^2", "m kg s^-2", 1.0),
        ("kg*m / s^2", "m kg s^-2", 1.0),
        ("kg\u{b7}m\u{b7}s^-2", "m kg s^-2", 1.0),
        ("N m^2/C^2", "m^3 kg s^-4 A^-2", 1.0),
        ("kg/m^3/s", "m^-3 kg s^-1", 1.0),
        ("J/kg K", "m^2 s^-2 K", 1.0),
        ("J/(kg K)", "m^2 s^-2 K^-1", 1.0),
        ("N/(m/s)", "kg s^-1", 1.0),
        ("(km/s)^2", "m^2 s^-2", 1e6),
        ("((m))^-1", "m^-1", 1.0),
        ("m^+2", "m^2", 1.0),
        ("m^0", "1", 1.0),
        ("km/s", "m s^-1", 1000.0),
        ("g/cm^3", "m^-3 kg", 1000.0),
        ("mm^-1", "m^-1", 1000.0),
        ("ms", "s", 1e-3),
        ("min", "s", 60.0),
        ("dam", "m", 10.0),
        ("daN", "m kg s^-2", 10.0),
        ("um", "m", 1e-6),
        ("\u{b5}m", "m", 1e-6),
        ("\u{3bc}m", "m", 1e-6),
        ("us", "s", 1e-6),
        ("kpc/Mpc", "1", 1e-3),
        ("MeV", "m^2 kg s^-2", 1.602_176_634e-13),
        ("hPa", "m^-1 kg s^-2", 100.0),
        ("mbar", "m^-1 kg s^-2", 100.0),
        ("mL", "m^3", 1e-6),
        ("mcd", "cd", 1e-3),
        ("mmol", "mol", 1e-3),
        ("Mg", "kg", 1000.0),
        ("kOhm", "m^2 kg s^-3 A^-2", 1000.0),
        ("au/d", "m s^-1", 149_597_870_700.0 / 86_400.0),
        ("deg/s", "s^-1", std::f64::consts::PI / 180.0),
        ("ym", "m", 1e-24),
        ("Ym", "m", 1e24),
    ];
    for &(text, dimension, scale) in table {
        let found = unit(text);
        assert_eq!(found.dimension.to_string(), dimension, "{text}");
        assert!((found.scale / scale - 1.0).abs() < 1e-15, "{text}: {} is not {scale}", found.scale);
    }
}

#[test]
fn a_product_of_powers_of_ten_is_exact() {
    for (text, scale) in [("g/cm^3", 1000.0), ("km/ms", 1e6), ("1/um", 1e6), ("mm", 1e-3), ("nm", 1e-9), ("g", 1e-3)] {
        assert_eq!(unit(text).scale, scale, "{text}");
    }
}

#[test]
fn constants_are_parsed_by_the_compiler() {
    const { assert!(G.dimension.equals(Dimension::new([3, -1, -2, 0, 0, 0, 0]))) }
    assert_eq!(Unit::ONE, unit("1"));
}

#[test]
fn factors_convert_between_units_of_one_dimension() {
    assert_eq!(unit("km").factor_to(unit("m")), Some(1000.0));
    assert_eq!(unit("d").factor_to(unit("h")), Some(24.0));
    assert_eq!(unit("N m").factor_to(unit("J")), Some(1.0));
    assert_eq!(unit("km").factor_to(unit("kg")), None);
}

#[test]
fn a_fault_points_at_its_piece_and_says_what_to_write() {
    let table: &[(&str, UnitError, &str)] = &[
        ("kg mter", UnitError::Unknown { start: 3, end: 7 }, "unknown unit `mter` in \"kg mter\": did you mean `m`?"),
        ("meters/s", UnitError::Unknown { start: 0, end: 6 }, "did you mean `m`?"),
        ("m/sec", UnitError::Unknown { start: 2, end: 5 }, "did you mean `s`?"),
        ("KG", UnitError::Unknown { start: 0, end: 2 }, "did you mean `kg`?"),
        ("KM/s", UnitError::Unknown { start: 0, end: 2 }, "did you mean `km`?"),
        ("m2", UnitError::Unknown { start: 0, end: 2 }, "did you mean `m^2`?"),
        ("kd", UnitError::Unknown { start: 0, end: 2 }, "did you mean"),
        ("kkg", UnitError::Unknown { start: 0, end: 3 }, "did you mean `kg`?"),
        (
            "10 m",
            UnitError::Unknown { start: 0, end: 2 },
            "number `10` in unit \"10 m\": the only number in a unit is 1",
        ),
        ("m^x", UnitError::Exponent { start: 2, end: 3 }, "exponent `x` in unit \"m^x\" is not an integer"),
        ("m^0.5", UnitError::Exponent { start: 2, end: 5 }, "exponent `0.5`"),
        ("m^", UnitError::Exponent { start: 1, end: 2 }, "exponent `^`"),
        ("m^-", UnitError::Exponent { start: 2, end: 3 }, "exponent `-`"),
        ("m^128", UnitError::Range { start: 2, end: 5 }, "out of range"),
        ("m^100 m^100", UnitError::Range { start: 6, end: 11 }, "out of range"),
        ("Ym^20", UnitError::Range { start: 0, end: 5 }, "out of range"),
        ("au^100", UnitError::Range { start: 0, end: 6 }, "out of range"),
        ("/s", UnitError::Unexpected { start: 0, end: 1 }, "unexpected `/`"),
        ("m/", UnitError::Unexpected { start: 1, end: 2 }, "unexpected `/`"),
        ("m//s", UnitError::Unexpected { start: 2, end: 3 }, "unexpected `/`"),
        ("m)", UnitError::Unexpected { start: 1, end: 2 }, "unexpected `)`"),
        ("(m", UnitError::Unexpected { start: 0, end: 1 }, "unexpected `(`"),
        ("m+s", UnitError::Unexpected { start: 1, end: 2 }, "unexpected `+`"),
        ("\u{20ac}", UnitError::Unknown { start: 0, end: 3 }, "unknown unit `\u{20ac}`"),
        ("(((((((((m)))))))))", UnitError::Unexpected { start: 8, end: 9 }, "unexpected `(`"),
    ];
    for &(text, error, words) in table {
        assert_eq!(Unit::parse(text), Err(error), "{text}");
        let message = error.message(text);
        assert!(message.contains(words), "{text}: {message}");
    }
}

#[test]
fn no_text_panics() {
    let pieces = ["m", "1", "^", "-", "/", "*", "(", ")", " ", "\u{b7}", "\u{b5}", "\u{20ac}", "9", ".", "kg"];
    for a in pieces {
        for b in pieces {
            for c in pieces {
                for d in pieces {
                    let text = format!("{a}{b}{c}{d}");
                    match Unit::parse(&text) {
                        Ok(unit) => assert!(unit.scale > 0.0 && unit.scale.is_finite(), "{text}"),
                        Err(error) => {
                            let (start, end) = error.range();
                            assert!(text.get(start..end).is_some_and(|piece| !piece.is_empty()), "{text}");
                            assert!(!error.message(&text).is_empty());
                        }
                    }
                }
            }
        }
    }
}
