//! `--measure DOMAIN.PROPERTY[WHICH].COMPONENT`: a number that is told of each run, as it is at the end.
//!
//! In: the argument; columns at the end of a run. Out: a [`Measure`], and its number, in SI; or what is wrong with the
//! argument, at its place. Never: a number of a run that did not come to its end.
//!
//! | | |
//! |---|---|
//! | WHICH | a row by its number from 0, or by its label; or `min`, `max`, `mean` over all rows |
//! | COMPONENT | `x`, `y`, `z` (`w` of a quaternion), or `length`; a scalar has none |

use vesper::prelude::*;

use crate::fault::{SceneFault, help_for};
use crate::run::snapshot::{Shown, ShownDomain};
use crate::scene::Scene;

/// Of which rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Which {
    /// This one, by its number.
    Row(usize),
    /// This one, by its label.
    Label(String),
    /// The least of all.
    Min,
    /// The largest of all.
    Max,
    /// The mean of all.
    Mean,
}

/// Of which part of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// The only number of a scalar.
    Whole,
    /// One of several.
    Part(usize),
    /// The root of the sum of their squares.
    Length,
}

/// A number that is told of each run.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// As it was asked for.
    pub text: String,
    /// The domain.
    pub domain: String,
    /// The property.
    pub property: String,
    /// Of which rows.
    pub which: Which,
    /// Of which part of a value.
    pub component: Component,
    /// Its SI unit, once a [check](super::check()) has looked at it.
    pub unit: String,
}

/// The option, for faults.
const OPTION: &str = "--measure";
const USUAL: &str = "as in --measure bodies.position[0].x, or [min], [max], [mean] over all rows";
const PARTS: [&str; 4] = ["x", "y", "z", "w"];

impl Measure {
    /// Reads an argument.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(argument: &str) -> Result<Self, SceneFault> {
        let argument = argument.trim();
        let wrong =
            |piece: &str, text: String| SceneFault::of_argument(OPTION, argument, piece, text, Some(USUAL.to_owned()));
        let Some((place, rest)) = argument.split_once('[') else {
            return Err(wrong(argument, format!("expected DOMAIN.PROPERTY[WHICH].COMPONENT, found `{argument}`")));
        };
        let Some((which, rest)) = rest.rsplit_once(']') else {
            return Err(wrong(rest, "the bracket has no `]`".to_owned()));
        };
        let Some((domain, property)) = place.split_once('.').filter(|(a, b)| !a.is_empty() && !b.is_empty()) else {
            return Err(wrong(place, format!("expected DOMAIN.PROPERTY before the bracket, found `{place}`")));
        };
        let which = match which.trim() {
            "" => return Err(wrong(which, "the bracket is empty".to_owned())),
            "min" => Which::Min,
            "max" => Which::Max,
            "mean" => Which::Mean,
            row => row.parse().map_or_else(|_| Which::Label(row.to_owned()), Which::Row),
        };
        let component = match rest.strip_prefix('.') {
            None if rest.is_empty() => Component::Whole,
            None => return Err(wrong(rest, format!("expected `.COMPONENT` behind the bracket, found `{rest}`"))),
            Some("length") => Component::Length,
            Some(part) => match PARTS.iter().position(|known| *known == part) {
                Some(part) => Component::Part(part),
                None => {
                    let text = format!("a component is x, y, z, w or length, found `{part}`");
                    return Err(wrong(if part.is_empty() { rest } else { part }, text));
                }
            },
        };
        let (domain, property) = (domain.to_owned(), property.to_owned());
        Ok(Self { text: argument.to_owned(), domain, property, which, component, unit: String::new() })
    }

    /// Whether there is such a number at the start of a run; its unit.
    ///
    /// # Errors
    /// What there is not, with the nearest name that there is.
    pub fn look<P: Precision>(&self, scene: &Scene, engine: &Engine<P>) -> Result<String, SceneFault> {
        let argument = self.text.as_str();
        let wrong = |piece: &str, text: String, help| Err(SceneFault::of_argument(OPTION, argument, piece, text, help));
        // The parts as they stand in the argument, so that carets find them.
        let (place, rest) = argument.split_once('[').unwrap_or((argument, ""));
        let (domain, property) = place.split_once('.').unwrap_or((place, ""));
        let (which, component) = rest.rsplit_once(']').unwrap_or((rest, ""));
        let state = engine.state();
        let Ok(on) = state.domain(domain) else {
            let help = help_for(domain, state.domains().iter().map(|domain| domain.name()));
            return wrong(domain, format!("the scene has no domain `{domain}`"), help);
        };
        // Also those that laws compute, which a client may look at once they are observed.
        let Some(column) = on.columns().iter().find(|column| column.property().name == property) else {
            let help = help_for(property, on.columns().iter().map(|column| column.property().name));
            return wrong(property, format!("`{domain}` has no `{property}`"), help);
        };
        let kind = column.property().kind;
        let width = kind.width();
        match self.component {
            _ if matches!(kind, Kind::Link(_)) => {
                return wrong(property, format!("`{property}` names rows of a domain, which are no quantity"), None);
            }
            Component::Whole if width > 1 => {
                let text = format!("`{property}` is a {kind}, and one number of it is wanted");
                let parts: Vec<&str> = PARTS.into_iter().take(width).chain(["length"]).collect();
                return wrong(argument, text, Some(format!("add one of .{}", parts.join(", ."))));
            }
            Component::Part(_) | Component::Length if width == 1 => {
                return wrong(component, format!("`{property}` is a {kind}, and has no components"), None);
            }
            Component::Part(part) if part >= width => {
                return wrong(component, format!("`{property}` is a {kind} of {width} components"), None);
            }
            _ => {}
        }
        let rows = on.rows();
        let row = match &self.which {
            Which::Row(row) if *row >= rows => {
                let help = rows.checked_sub(1).map(|last| format!("rows count from 0 to {last}"));
                return wrong(which, format!("`{domain}` has no row {row}: it has {rows}"), help);
            }
            Which::Row(row) => Some(*row),
            Which::Label(label) => match row_of(scene, domain, label) {
                Some(row) => Some(row),
                None => {
                    let labels = scene.domain(domain).and_then(|domain| domain.labels.as_deref()).unwrap_or_default();
                    let known = labels.iter().map(String::as_str).chain(["min", "max", "mean"]);
                    let help = help_for(label, known);
                    return wrong(which, format!("`{domain}` has no row `{label}`"), help);
                }
            },
            Which::Min | Which::Max | Which::Mean => None,
        };
        if let (Some(row), Some(subset)) = (row, column.subset())
            && !subset.iter().any(|known| *known as usize == row)
        {
            return wrong(property, format!("row {row} of `{domain}` has no `{property}`: only some rows do"), None);
        }
        Ok(column.property().unit.to_owned())
    }

    /// The number at the end of a run; none where it has no such row, or where it is not finite.
    pub fn of(&self, scene: &Scene, domains: &[ShownDomain]) -> Option<f64> {
        let domain = domains.iter().find(|domain| domain.name == self.domain)?;
        let column = domain.columns.iter().find(|column| column.property.name == self.property)?;
        let of_row = |row: usize| column.row(row).and_then(|numbers| self.part(numbers));
        let number = match &self.which {
            Which::Row(row) => of_row(*row)?,
            Which::Label(label) => of_row(row_of(scene, &self.domain, label)?)?,
            Which::Min => self.all(column)?.into_iter().fold(f64::INFINITY, f64::min),
            Which::Max => self.all(column)?.into_iter().fold(f64::NEG_INFINITY, f64::max),
            Which::Mean => {
                let all = self.all(column)?;
                all.iter().sum::<f64>() / all.len() as f64
            }
        };
        number.is_finite().then_some(number)
    }

    fn part(&self, numbers: &[f64]) -> Option<f64> {
        match self.component {
            Component::Whole => numbers.first().copied(),
            Component::Part(part) => numbers.get(part).copied(),
            Component::Length => Some(numbers.iter().map(|number| number * number).sum::<f64>().sqrt()),
        }
    }

    /// Of every row that has a value; none where one is not finite, which a least or largest number would hide.
    fn all(&self, column: &Shown) -> Option<Vec<f64>> {
        let parts = column.numbers.chunks(column.width().max(1)).map(|numbers| self.part(numbers));
        parts.map(|part| part.filter(|number| number.is_finite())).collect()
    }
}

fn row_of(scene: &Scene, domain: &str, label: &str) -> Option<usize> {
    scene.domain(domain)?.labels.as_ref()?.iter().position(|known| known == label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grammar() {
        let read = |argument: &str| Measure::read(argument).unwrap_or_else(|fault| panic!("{fault}"));
        let one = read("bodies.position[3].z");
        assert_eq!((one.domain.as_str(), one.property.as_str()), ("bodies", "position"));
        assert_eq!((one.which, one.component), (Which::Row(3), Component::Part(2)));
        assert_eq!(read("a.b[mean]").which, Which::Mean);
        assert_eq!(read("a.b[earth [1]].length").which, Which::Label("earth [1]".to_owned()));
        let told = |argument: &str| {
            let fault = Measure::read(argument).expect_err(argument);
            format!("{}: {}", fault.column, fault.text)
        };
        assert_eq!(told("a.b"), "1: expected DOMAIN.PROPERTY[WHICH].COMPONENT, found `a.b`");
        assert_eq!(told("a[0].x"), "1: expected DOMAIN.PROPERTY before the bracket, found `a`");
        assert_eq!(told("a.b[0"), "5: the bracket has no `]`");
        assert_eq!(told("a.b[].x"), "5: the bracket is empty");
        assert_eq!(told("a.b[0].q"), "8: a component is x, y, z, w or length, found `q`");
        assert_eq!(told("a.b[0]x"), "7: expected `.COMPONENT` behind the bracket, found `x`");
    }

    #[test]
    fn numbers_over_rows() {
        let numbers = vec![3.0, 4.0, 0.0, -1.0, 0.0, 0.0];
        let column = Shown { property: Position::INFO, subset: None, numbers };
        let shown = [ShownDomain { name: "bodies".to_owned(), rows: 2, columns: vec![column] }];
        let scene = Scene::default();
        let of = |text: &str| Measure::read(text).unwrap().of(&scene, &shown);
        assert_eq!(of("bodies.position[1].x"), Some(-1.0));
        assert_eq!(of("bodies.position[max].length"), Some(5.0));
        assert_eq!(of("bodies.position[min].x"), Some(-1.0));
        assert_eq!(of("bodies.position[mean].y"), Some(2.0));
        assert_eq!(of("bodies.position[2].y"), None);
    }
}
