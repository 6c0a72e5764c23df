//! Names of properties in a scene, as properties.
//!
//! In: a name, the number of components, a unit. Out: the [`PropertyInfo`] that the laws mean by the name, or a new one
//! where nobody declares it: a client may keep what no law knows. Never: a fault about an unknown name; a law that lacks
//! its property says so, with the nearest name.

use vesper::dimension::Unit;
use vesper::prelude::*;
use vesper_laws::catalog::stock_laws;

/// The property that is known by `name`: a standard one, or one that a stock law declares.
pub fn known(name: &str) -> Option<PropertyInfo> {
    let declared = || stock_laws().iter().flat_map(|law| law.signature.ports.iter().map(|port| port.property));
    let links = || stock_laws().iter().filter_map(|law| law.signature.link);
    STANDARD_PROPERTIES.iter().copied().chain(declared()).chain(links()).find(|property| property.name == name)
}

/// A property of this name that nobody declares, in the SI unit of the dimension of `unit`; what is wrong with it, where
/// there is no such kind.
pub fn unknown(name: &str, width: usize, unit: Option<&str>) -> Result<PropertyInfo, String> {
    let kind = match width {
        1 => Kind::Scalar,
        3 => Kind::Vector,
        4 => Kind::Quaternion,
        n => return Err(format!("a value has 1, 3 or 4 components, and here {n}")),
    };
    let si = unit.and_then(|unit| Unit::parse(unit).ok()).map_or(Unit::ONE, |unit| unit).dimension;
    let si = if si == Unit::ONE.dimension { String::new() } else { si.to_string() };
    PropertyInfo::at_run_time(name, kind, &si).map_err(|fault| fault.to_string())
}

/// A link of this name that nobody declares.
pub fn unknown_link(name: &str, arity: usize) -> Result<PropertyInfo, String> {
    PropertyInfo::at_run_time(name, Kind::Link(arity), "").map_err(|fault| fault.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_names_become_properties_in_si() {
        let heat = unknown("boiling_point", 1, Some("mK")).unwrap();
        assert_eq!((heat.unit, heat.kind), ("K", Kind::Scalar));
        assert_eq!(unknown("colour", 3, None).unwrap().unit, "");
        assert!(unknown("uv", 2, None).unwrap_err().contains("1, 3 or 4"));
    }
}
