//! Names of properties with a unit behind them, as messages print them: `velocity [km/s]`.
//!
//! In: the text, how many numbers there are for how many rows. Out: the property that laws mean by the name, or a new one,
//! and the unit of the values. Never: a guess: a unit of another dimension is refused.

use super::Trouble;
use vesper::prelude::*;
use vesper_cli::assemble::properties;
use vesper_dimension::Unit;

/// A property, and the unit that its values are given in.
pub(super) struct Named<'a> {
    pub(super) info: PropertyInfo,
    pub(super) unit: Option<&'a str>,
}

/// Name and unit of `velocity [km/s]`.
pub(super) fn apart(text: &str) -> Result<(&str, Option<&str>), Trouble> {
    let (name, unit) = match text.split_once('[') {
        None => (text, None),
        Some((name, rest)) => match rest.trim_end().strip_suffix(']') {
            Some(unit) => (name, Some(unit.trim())),
            None => return Err(Trouble::fault(format!("property `{text}`: close the unit with `]`"))),
        },
    };
    match name.trim() {
        "" => Err(Trouble::fault(format!("property `{text}` has no name: write it before the unit, `mass [kg]`"))),
        name => Ok((name, unit)),
    }
}

/// The property of a column with `count` numbers for `rows` rows.
pub(super) fn column<'a>(domain: &str, text: &'a str, count: usize, rows: usize) -> Result<Named<'a>, Trouble> {
    let (name, unit) = apart(text)?;
    let info = match properties::known(name) {
        Some(info) => info,
        None => properties::unknown(name, width_of(domain, name, count, rows)?, unit)
            .map_err(|reason| Trouble::fault(format!("{domain}.{name}: {reason}")))?,
    };
    if matches!(info.kind, Kind::Link(_)) {
        return Err(Trouble::fault(format!("{domain}.{name} is a {}: give it as a link, with its target", info.kind)));
    }
    let expected = rows.saturating_mul(info.kind.width());
    if count != expected {
        let of = format!("{rows} rows of a {} are {expected}", info.kind);
        return Err(Trouble::fault(format!("{domain}.{name} has {count} numbers, but {of}: give as many")));
    }
    factor(domain, &info, unit)?;
    Ok(Named { info, unit })
}

/// What numbers in this unit are multiplied by to be in the property's own.
pub(super) fn factor(domain: &str, info: &PropertyInfo, unit: Option<&str>) -> Result<f64, Trouble> {
    let Some(unit) = unit else { return Ok(1.0) };
    let name = info.name;
    let size =
        Unit::parse(unit).map_err(|error| Trouble::fault(format!("{domain}.{name}: {}", error.message(unit))))?;
    size.factor_to(info.size).ok_or_else(|| {
        let expected = if info.unit.is_empty() { "no unit" } else { info.unit };
        let text = format!("{domain}.{name} is given in {unit}, but it is measured in {expected}");
        Trouble::fault(text + ": give it in a unit of that dimension")
    })
}

/// The property of a link with `count` rows of its target for `rows` rows.
pub(super) fn link(domain: &str, name: &str, count: usize, rows: usize) -> Result<PropertyInfo, Trouble> {
    let info = match properties::known(name) {
        Some(info) => info,
        None => properties::unknown_link(name, width_of(domain, name, count, rows)?).map_err(Trouble::fault)?,
    };
    let Kind::Link(arity) = info.kind else {
        return Err(Trouble::fault(format!("{domain}.{name} is a {}, no link: give it as a column", info.kind)));
    };
    if count != rows.saturating_mul(arity) {
        let text = format!("{domain}.{name} has {count} ends, but {rows} rows with {arity} each");
        return Err(Trouble::fault(text + " are another number: give as many"));
    }
    Ok(info)
}

/// How many numbers a row has of a property that nobody knows.
fn width_of(domain: &str, name: &str, count: usize, rows: usize) -> Result<usize, Trouble> {
    match (count.checked_rem(rows), rows) {
        (Some(0), _) => Ok(count / rows),
        (None, _) if count == 0 => Ok(1),
        _ => {
            let text = format!("{domain}.{name} has {count} numbers, which {rows} rows cannot share evenly");
            Err(Trouble::fault(text + ": give as many for each row"))
        }
    }
}
