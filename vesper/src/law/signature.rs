//! A law's declaration as plain data. A derived law has it as a constant; a law made at run time keeps it for the
//! life of the program; nothing else in the system can tell which.

use crate::property::{PropertyInfo, Role};

/// What a law promises about one property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Looks at the value of this evaluation.
    Reads,
    /// Looks at the value that the previous evaluation left.
    Previous,
    /// Computes the property anew. Exactly one law may.
    Sets,
    /// Adds a share to a sum.
    Adds,
    /// Gives the time derivative of a state.
    Rates,
    /// Corrects the state after a step.
    Amends,
}

impl Mode {
    /// Whether the law only looks.
    pub const fn is_input(self) -> bool {
        matches!(self, Mode::Reads | Mode::Previous)
    }

    /// What the law does to a property, in a sentence.
    pub const fn does(self) -> &'static str {
        match self {
            Mode::Reads => "reads",
            Mode::Previous => "reads the previous",
            Mode::Sets => "sets",
            Mode::Adds => "adds to",
            Mode::Rates => "gives the rate of",
            Mode::Amends => "amends",
        }
    }

    /// The word of the declaration.
    pub const fn word(self) -> &'static str {
        match self {
            Mode::Reads => "reads",
            Mode::Previous => "reads previous",
            Mode::Sets => "sets",
            Mode::Adds => "adds",
            Mode::Rates => "rates",
            Mode::Amends => "amends",
        }
    }
}

/// Where a law meets one property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// On the rows of the law's own domain.
    Own,
    /// In the one row of the domain "scene": a constant.
    Scene,
    /// A function of position and time, sampled at the row's position.
    Field,
    /// On the rows that the law's link leads to.
    End,
}

/// One property that a law touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// The name of the value in the law's row.
    pub field: &'static str,
    /// The property.
    pub property: PropertyInfo,
    /// What the law promises about it.
    pub mode: Mode,
    /// Where the law meets it.
    pub place: Place,
    /// Whether the law runs without it.
    pub optional: bool,
    /// The value of a constant that the scene does not give.
    pub default: Option<[f64; 3]>,
    /// For a rate: the ports it depends on, one bit each; all bits where the declaration does not say.
    pub from: u64,
}

/// A parameter of a law: a number (or vector) of its own, not a property of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// The field's name.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Its unit, as written.
    pub unit: &'static str,
    /// 1 for a number, 3 for a vector.
    pub width: usize,
    /// Its value where none is given; without one it must be given.
    pub default: Option<[f64; 3]>,
}

/// Everything that the framework knows about a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signature {
    /// The law's name: `snake_case` of its type.
    pub name: &'static str,
    /// The law's documentation.
    pub doc: &'static str,
    /// The domain it stands on where the builder does not say; without one, the one domain that has what it reads.
    pub domain: Option<&'static str>,
    /// What it touches: inputs first, then outputs.
    pub ports: &'static [Port],
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// The link that a link law follows.
    pub link: Option<PropertyInfo>,
    /// Whether the rate of each coordinate that it gives is that coordinate's momentum, in every row that moves at all.
    pub second_order: bool,
    /// Whether a pair law looks at differences of coordinates alone: what it gives stays as it is where both rows move alike.
    pub translation_invariant: bool,
    /// Whether a pair law takes from row j what it adds to row i: then each pair may be looked at once.
    pub antisymmetric: bool,
    /// Whether many pairs may be computed with fused products and estimated roots: faster, within some roundings of the body as
    /// it is written, and not with the same bits on every processor.
    pub estimates: bool,
    /// For a pair law that ends at a distance, the number of its parameters' component that is this distance, in the unit of the
    /// one coordinate that it reads.
    pub cutoff: Option<usize>,
    /// Source file of the declaration.
    pub file: &'static str,
    /// Line of the declaration.
    pub line: u32,
}

impl Signature {
    /// The ports that the law looks at, with their numbers.
    pub fn inputs(&self) -> impl Iterator<Item = (usize, &Port)> {
        self.ports.iter().enumerate().filter(|(_, port)| port.mode.is_input())
    }

    /// The ports that the law changes, with their numbers.
    pub fn outputs(&self) -> impl Iterator<Item = (usize, &Port)> {
        self.ports.iter().enumerate().filter(|(_, port)| !port.mode.is_input())
    }

    /// What the law touches, and its parameters, a line each: everything that is known of it but its body and its words.
    pub fn declaration(&self) -> String {
        let number = |value: &[f64; 3], width: usize| -> String {
            let numbers: Vec<String> = value[..width.min(3)].iter().map(|number| format!("{number:?}")).collect();
            format!(", default {}", numbers.join(" "))
        };
        let domain = self.domain.map_or(String::new(), |domain| format!(" on {domain}"));
        let second_order = if self.second_order { ", second order" } else { "" };
        let mut text = format!("law {}{domain}{second_order}\n", self.name);
        if let Some(link) = self.link {
            text += &format!("follows {}: {}\n", link.name, link.kind);
        }
        for port in self.ports {
            let place = match port.place {
                Place::Own => "",
                Place::Scene => " of the scene",
                Place::Field => " as a field",
                Place::End => " of the rows linked to",
            };
            let optional = if port.optional { ", optional" } else { "" };
            let default = port.default.map_or(String::new(), |value| number(&value, port.property.kind.width()));
            let from: Vec<&str> = match port.from {
                u64::MAX => Vec::new(),
                bits => {
                    self.inputs().filter(|(bit, _)| bits >> bit & 1 == 1).map(|(_, port)| port.property.name).collect()
                }
            };
            let from = if from.is_empty() { String::new() } else { format!(" from {}", from.join(", ")) };
            let (mode, property, role) = (port.mode.word(), &port.property, port.property.role.word());
            text +=
                &format!("{mode} {}: {}, {role}{place}{optional}{default}{from}\n", property.name, property.measured());
        }
        for parameter in self.parameters {
            let unit = if parameter.unit.is_empty() { String::new() } else { format!(" [{}]", parameter.unit) };
            let kind = if parameter.width == 1 { "number" } else { "vector" };
            let default = parameter.default.map_or(String::new(), |value| number(&value, parameter.width));
            text += &format!("parameter {}: {kind}{unit}{default}\n", parameter.name);
        }
        text
    }

    /// A number for [`Signature::declaration`], which changes where that does (FNV-1a, 64 bits).
    pub fn fingerprint(&self) -> u64 {
        self.declaration()
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
    }

    /// Whether the law samples a field, so that its rows need a position.
    pub fn samples_fields(&self) -> bool {
        self.ports.iter().any(|port| port.place == Place::Field)
    }

    /// The first component of every port, and after the last one their number.
    pub fn slots(&self) -> Vec<usize> {
        let mut slots = vec![0];
        for port in self.ports.iter() {
            slots.push(slots[slots.len() - 1] + port.property.kind.width());
        }
        slots
    }
}

/// Which states an integrator asks the rates of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Part {
    /// Every state.
    All,
    /// The states that are drifted: coordinates.
    Coordinates,
    /// The states that are kicked: momenta, and every state that is no coordinate.
    Momenta,
}

impl Part {
    /// Whether a state of this role belongs to the part.
    pub const fn holds(self, role: &Role) -> bool {
        match self {
            Part::All => true,
            Part::Coordinates => matches!(role, Role::Coordinate),
            Part::Momenta => !matches!(role, Role::Coordinate),
        }
    }
}

/// The shape of a law's body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// One row.
    Row,
    /// One pair of rows.
    Pair,
    /// One link and the rows it leads to.
    Link,
    /// Whole columns.
    Column,
}

impl Shape {
    /// The word for messages.
    pub const fn word(self) -> &'static str {
        match self {
            Shape::Row => "row",
            Shape::Pair => "pair",
            Shape::Link => "link",
            Shape::Column => "column",
        }
    }
}
