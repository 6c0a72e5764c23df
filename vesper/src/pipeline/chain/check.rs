//! The registry's rules that need no state, in constants: what the compiler says about `pipeline![...]`.

use super::layout::{List, before, one_quantity, same};
use crate::law::{Mode, Place};

/// Stops the compiler at declarations that contradict each other, naming laws and property.
pub(super) const fn check(list: &List) {
    let mut one = 0;
    while one < list.len {
        let mut other = one + 1;
        while other < list.len {
            pair(list, one, other);
            other += 1;
        }
        one += 1;
    }
    circle(list);
}

const fn pair(list: &List, one: usize, other: usize) {
    let (first, second) = (list.signature(one), list.signature(other));
    if same(first.name, second.name) {
        fail(&["law ", first.name, " is in the pipeline twice: keep one, or list the other with a label"]);
    }
    let mut a = 0;
    while a < first.ports.len() {
        let mut b = 0;
        while b < second.ports.len() {
            let (mine, its) = (first.ports[a], second.ports[b]);
            b += 1;
            let name = mine.property.name;
            if !same(name, its.property.name) || matches!(mine.place, Place::Field) != matches!(its.place, Place::Field)
            {
                continue;
            }
            let one_unit = mine.property.size.dimension.equals(its.property.size.dimension)
                && mine.property.size.scale == its.property.size.scale;
            if !mine.property.kind.same_as(its.property.kind) || !one_unit {
                fail(&["property ", name, " has one kind and unit in ", first.name, " and another in ", second.name]);
            }
            if !one_quantity(&first, &mine, &second, &its) {
                continue;
            }
            match (mine.mode, its.mode) {
                (Mode::Sets, Mode::Sets) => {
                    fail(&[first.name, " and ", second.name, " both set ", name, ": keep one"]);
                }
                (Mode::Rates, Mode::Rates) => {
                    fail(&[first.name, " and ", second.name, " both give the rate of ", name, ": keep one"]);
                }
                (Mode::Rates, Mode::Sets | Mode::Adds) | (Mode::Sets | Mode::Adds, Mode::Rates) => {
                    fail(&[
                        name,
                        " is a state for one of ",
                        first.name,
                        " and ",
                        second.name,
                        ", and computed by the other",
                    ]);
                }
                _ => {}
            }
        }
        a += 1;
    }
}

/// A law that must run before itself, by way of others.
const fn circle(list: &List) {
    // Take away, again and again, a law that waits for none of those left; what is left at the end is a circle.
    let mut left = [true; super::layout::LAWS];
    let mut count = list.len;
    loop {
        let mut taken = false;
        let mut law = 0;
        while law < list.len {
            if left[law] {
                let mut free = true;
                let mut other = 0;
                while other < list.len {
                    if left[other] && other != law && before(&list.signature(other), &list.signature(law)) {
                        free = false;
                    }
                    other += 1;
                }
                if free {
                    left[law] = false;
                    count -= 1;
                    taken = true;
                }
            }
            law += 1;
        }
        if count == 0 {
            return;
        }
        if !taken {
            break;
        }
    }
    let (mut first, mut second) = ("", "");
    let mut law = 0;
    while law < list.len {
        if left[law] {
            if first.is_empty() {
                first = list.signature(law).name;
            } else if second.is_empty() {
                second = list.signature(law).name;
            }
        }
        law += 1;
    }
    fail(&["the laws close a circle, ", first, " and ", second, " among them: each sets what the other reads"]);
}

/// Stops the compiler with a message put together from parts.
const fn fail(parts: &[&str]) -> ! {
    let mut text = [b' '; 256];
    let (mut part, mut at) = (0, 0);
    while part < parts.len() {
        let bytes = parts[part].as_bytes();
        let mut k = 0;
        while k < bytes.len() && at < text.len() {
            text[at] = bytes[k];
            at += 1;
            k += 1;
        }
        part += 1;
    }
    match core::str::from_utf8(text.split_at(at).0) {
        Ok(text) => panic!("{}", text),
        Err(_) => panic!("the laws of the pipeline contradict each other"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Port, Shape, Signature};
    use crate::property::{Kind, Position, Property, PropertyInfo, Velocity};
    use std::panic::catch_unwind;

    const TRACE: PropertyInfo = PropertyInfo::new("trace", Kind::Scalar, "1");
    const ECHO: PropertyInfo = PropertyInfo::new("echo", Kind::Scalar, "1");
    const SPEED: PropertyInfo = PropertyInfo::new("velocity", Kind::Vector, "km/h");

    fn law(name: &'static str, domain: Option<&'static str>, ports: &[(Mode, PropertyInfo)]) -> Signature {
        let port = |&(mode, property): &(Mode, PropertyInfo)| {
            let field = property.name;
            Port { field, property, mode, place: Place::Own, optional: false, default: None, from: u64::MAX }
        };
        let ports: Vec<Port> = ports.iter().map(port).collect();
        let ports = Vec::leak(ports);
        Signature {
            name,
            doc: "",
            domain,
            ports,
            parameters: &[],
            link: None,
            second_order: false,
            translation_invariant: false,
            antisymmetric: false,
            estimates: false,
            cutoff: None,
            file: "",
            line: 0,
        }
    }

    fn message(laws: [Signature; 2]) -> Option<String> {
        let list = laws.iter().rev().fold(List::EMPTY, |list, law| list.with_first(*law, Shape::Row));
        let panic = catch_unwind(|| check(&list)).err()?;
        panic.downcast_ref::<String>().cloned()
    }

    #[test]
    fn contradictions_name_laws_and_property() {
        use Mode::{Rates, Reads, Sets};
        let sets = |name| law(name, None, &[(Sets, TRACE)]);
        let moves = |name| law(name, None, &[(Reads, Velocity::INFO), (Rates, Position::INFO)]);
        let places = law("places", None, &[(Sets, Position::INFO)]);
        let odd = law("odd", None, &[(Reads, SPEED), (Sets, TRACE)]);
        let there = law("there", None, &[(Reads, TRACE), (Sets, ECHO)]);
        let back = law("back", None, &[(Reads, ECHO), (Sets, TRACE)]);
        let table = [
            ([sets("a"), sets("a")], "law a is in the pipeline twice: keep one, or list the other with a label"),
            ([sets("a"), sets("b")], "a and b both set trace: keep one"),
            ([moves("a"), moves("b")], "a and b both give the rate of position: keep one"),
            ([moves("a"), places], "position is a state for one of a and places, and computed by the other"),
            ([moves("a"), odd], "property velocity has one kind and unit in a and another in odd"),
            ([there, back], "the laws close a circle, there and back among them: each sets what the other reads"),
        ];
        for (laws, expected) in table {
            assert_eq!(message(laws).as_deref(), Some(expected));
        }
    }

    #[test]
    fn laws_of_different_domains_do_not_contradict_each_other() {
        let sets = |name, domain| law(name, domain, &[(Mode::Sets, TRACE)]);
        assert_eq!(message([sets("a", Some("stars")), sets("b", Some("moons"))]), None);
        assert!(message([sets("a", Some("stars")), sets("b", None)]).is_some());
    }
}
