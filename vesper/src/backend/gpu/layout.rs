//! Where a program finds the numbers of a law.
//!
//! In: a signature, and what is there. Out: buffers with the access that the law has declared to each, and the place of every component.
//! Never: a buffer of two laws' opinions: what may be read and written is what the signature says, and `check` compares the text with it.

use crate::law::{Mode, Place, Signature};

/// What a program does to a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// Looks at it.
    Read,
    /// Writes a number for every row, whatever is there: nothing need be brought before.
    Write,
    /// Looks at it, and writes.
    Update,
}

/// One buffer: a component's numbers after the other's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Binding {
    /// Its name in the text.
    pub(crate) name: String,
    pub(crate) access: Access,
}

impl Binding {
    /// A buffer, with a name that WGSL takes: letters and digits of this one, and the number that keeps it apart from others.
    pub(crate) fn new(name: &str, access: Access, number: usize) -> Self {
        let letters = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
        let name = letters.collect::<String>();
        Binding { name: format!("{}_{number}", name.trim_matches('_')), access }
    }
}

/// How a result goes where it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Store {
    /// In place of what is there.
    Set,
    /// Added to what is there.
    Add,
    /// Added to what is there, times the step.
    Advance,
}

/// Where one component is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    Absent,
    /// A number that is the same for all rows, and comes with each call.
    Constant,
    /// A component of a buffer.
    Input {
        binding: usize,
        component: usize,
    },
    /// A component of a buffer that is written.
    Output {
        binding: usize,
        component: usize,
        store: Store,
    },
}

/// All buffers of a program, and where in them each component is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) bindings: Vec<Binding>,
    pub(crate) slots: Vec<Slot>,
}

impl Layout {
    /// Every port has a buffer of its own, but for what a law reads and amends: that is one.
    pub(crate) fn of(signature: &Signature, there: u64) -> Self {
        let starts = signature.slots();
        let mut layout = Layout::default();
        // Where each port's numbers are.
        let mut bindings: Vec<Option<usize>> = Vec::new();
        for (number, port) in signature.ports.iter().enumerate() {
            let is_constant = port.place == Place::Scene;
            let absent = port.optional && there >> starts[number] & 1 == 0;
            let count = layout.bindings.len();
            let buffer = |name: &str, access| Binding::new(&format!("{}_{name}", port.field), access, count);
            let at_end = if port.place == Place::End { "end_" } else { "" };
            let (own, store) = match port.mode {
                Mode::Reads | Mode::Previous => (buffer(&format!("{at_end}in"), Access::Read), None),
                Mode::Sets => (buffer("out", Access::Write), Some(Store::Set)),
                Mode::Rates => (buffer("rate", Access::Write), Some(Store::Set)),
                Mode::Adds => (buffer(&format!("{at_end}sum"), Access::Update), Some(Store::Add)),
                Mode::Amends => (buffer("out", Access::Write), Some(Store::Set)),
            };
            let same = (port.mode == Mode::Amends)
                .then(|| {
                    let read = |other: &crate::law::Port| other.mode == Mode::Reads && other.place == port.place;
                    let mut earlier = signature.ports[..number].iter();
                    earlier.position(|other| read(other) && other.property.name == port.property.name)
                })
                .flatten()
                .and_then(|other| bindings[other]);
            let binding = if is_constant || absent {
                None
            } else if let Some(same) = same {
                layout.bindings[same].access = Access::Update;
                Some(same)
            } else {
                layout.bindings.push(own);
                Some(layout.bindings.len() - 1)
            };
            bindings.push(binding);
            for component in 0..port.property.kind.width() {
                layout.slots.push(match (binding, store) {
                    _ if absent => Slot::Absent,
                    (None, _) => Slot::Constant,
                    (Some(binding), None) => Slot::Input { binding, component },
                    (Some(binding), Some(store)) => Slot::Output { binding, component, store },
                });
            }
        }
        layout
    }
}
