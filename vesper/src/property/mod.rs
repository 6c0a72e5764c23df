//! What a row can have: a quantity with a name, a kind and a unit.
//!
//! In: declarations, made with [`property!`](crate::property!). Out: [`Property`], the type-level name of a quantity,
//! and [`PropertyInfo`], the same as plain data, so that properties can also be made at run time. Never: a value.

mod kind;
mod standard;

pub(crate) use kind::{Give, Take};
pub use kind::{Kind, KindOf, Link, Numeric, Quaternion, Scalar, Vector};
pub use standard::*;

use crate::dimension::Unit;
use crate::error::Fault;
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// A quantity that rows can have. Declare one with [`property!`](crate::property!).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a property",
    note = "declare it: `property! {{ /// what it is\\n pub {Self}: Scalar, \"unit\"; }}`"
)]
pub trait Property: Copy + Send + Sync + 'static {
    /// Scalar, vector, quaternion or link.
    type Kind: KindOf;
    /// Name, kind, unit and role, as data.
    const INFO: PropertyInfo;
    /// The name that columns, scenes and messages use.
    const NAME: &'static str = Self::INFO.name;
}

/// The value of property `Q` in a kernel over the numbers `R`.
pub type ValueOf<Q, R> = <<Q as Property>::Kind as Numeric>::Value<R>;

/// What a property is to an integrator and to the laws that add to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A quantity without a special role.
    Plain,
    /// A state that an integrator drifts: a place, an angle.
    Coordinate,
    /// A state that an integrator kicks: it moves the coordinate of this name.
    Momentum(&'static str),
    /// A sum that laws add to, anew in every evaluation.
    Sum {
        /// The property whose values it starts from where the domain has them; else it starts from zero.
        start: Option<&'static str>,
    },
    /// A sum of what turns a momentum: a force velocity x turn. A row law that adds to it and to the sum `of` says that its
    /// share of `of` is one without the velocity `by`, and `by` x its share of the turn: with `by` zero it is the first
    /// alone. Integrators that rotate ask for both apart; others have no use for it, and it costs them nothing.
    Turn {
        /// The sum that the turning adds to: "force".
        of: &'static str,
        /// What is turned: "velocity".
        by: &'static str,
    },
    /// Which case of its own a law is in: it sets the property, and looks at the value that was there when the step began,
    /// `reads(previous ..)`. The sign of a scalar is what counts: an integrator ends its step where the sign turns, so that
    /// no step goes across a jump. Each law that sets one has it to itself; its column is named after both.
    Switch,
}

impl Role {
    /// Whether laws add to it.
    pub const fn is_sum(&self) -> bool {
        matches!(self, Role::Sum { .. } | Role::Turn { .. })
    }

    /// "a coordinate", "a sum": for messages.
    pub(crate) fn word(&self) -> String {
        match self {
            Role::Plain => "without a role".to_owned(),
            Role::Coordinate => "a coordinate".to_owned(),
            Role::Momentum(of) => format!("which moves {of}"),
            Role::Sum { start: None } => "a sum".to_owned(),
            Role::Sum { start: Some(start) } => format!("a sum from {start}"),
            Role::Turn { of, by } => format!("a turn of {of} by {by}"),
            Role::Switch => "a switch".to_owned(),
        }
    }
}

/// A property as plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PropertyInfo {
    /// The name: `snake_case` of the property's type.
    pub name: &'static str,
    /// Scalar, vector, quaternion or link.
    pub kind: Kind,
    /// The unit as written; columns hold values in it.
    pub unit: &'static str,
    /// The unit's dimension, and its size in SI.
    pub size: Unit,
    /// What integrators and adding laws make of it.
    pub role: Role,
}

impl PropertyInfo {
    /// A property of this name, kind and unit, without a special role. For declarations: an unknown unit stops the
    /// compiler.
    pub const fn new(name: &'static str, kind: Kind, unit: &'static str) -> Self {
        PropertyInfo { name, kind, unit, size: Unit::expect(unit), role: Role::Plain }
    }

    /// A property made at run time. Its name and unit are kept for the life of the program.
    ///
    /// # Errors
    /// The unit is unknown.
    pub fn at_run_time(name: &str, kind: Kind, unit: &str) -> Result<Self, Fault> {
        let size = Unit::parse(unit).map_err(|error| Fault::Unit {
            place: name.to_owned(),
            unit: unit.to_owned(),
            reason: error.message(unit),
        })?;
        Ok(PropertyInfo { name: intern(name), kind, unit: intern(unit), size, role: Role::Plain })
    }

    /// The same as a state that an integrator drifts.
    #[must_use]
    pub const fn coordinate(self) -> Self {
        PropertyInfo { role: Role::Coordinate, ..self }
    }

    /// The same as a state that an integrator kicks, and that moves `coordinate`.
    #[must_use]
    pub const fn momentum_of(self, coordinate: &'static str) -> Self {
        PropertyInfo { role: Role::Momentum(coordinate), ..self }
    }

    /// The same as a sum that starts from zero.
    #[must_use]
    pub const fn sum(self) -> Self {
        PropertyInfo { role: Role::Sum { start: None }, ..self }
    }

    /// The same as a sum that starts from the values of `start` where the domain has them.
    #[must_use]
    pub const fn sum_from(self, start: &'static str) -> Self {
        PropertyInfo { role: Role::Sum { start: Some(start) }, ..self }
    }

    /// The same as a sum of turns: a law that adds to it adds `by` x turn to `of`.
    #[must_use]
    pub const fn turn_of(self, of: &'static str, by: &'static str) -> Self {
        PropertyInfo { role: Role::Turn { of, by }, ..self }
    }

    /// The same as a switch of the law that sets it.
    #[must_use]
    pub const fn switch(self) -> Self {
        PropertyInfo { role: Role::Switch, ..self }
    }

    /// "vector \[m\]", or "link to 2 rows" for what has no unit.
    pub(crate) fn measured(&self) -> String {
        if self.unit.is_empty() { self.kind.to_string() } else { format!("{} [{}]", self.kind, self.unit) }
    }

    /// `position [m]`, or "ends" for what has no unit.
    pub fn described(&self) -> String {
        if self.unit.is_empty() { self.name.to_string() } else { format!("{} [{}]", self.name, self.unit) }
    }
}

/// The one copy of a name that lives as long as the program. Distinct names are few; each is kept once.
pub(crate) fn intern(name: &str) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.get(name) {
        return known;
    }
    let kept: &'static str = Box::leak(name.to_owned().into_boxed_str());
    names.insert(kept);
    kept
}
