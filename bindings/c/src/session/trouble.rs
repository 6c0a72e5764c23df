//! What went wrong, for whoever speaks another language: what kind of thing, and the whole text.

use std::any::Any;
use vesper::prelude::{Fault, Faults};
use vesper_cli::fault::SceneFault;

/// Why something was not done. Every text names who, what, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// An argument makes no sense by itself: numbers of the wrong type, memory at an odd address.
    Argument(String),
    /// What was described or asked for does not fit the rest: all faults, a line or a few for each.
    Fault(String),
    /// A step could not be taken, or its numbers are none; or a law of a module failed in it, and it was taken without that law.
    Run(String),
}

impl Trouble {
    /// The text.
    pub fn text(&self) -> &str {
        match self {
            Trouble::Argument(text) | Trouble::Fault(text) | Trouble::Run(text) => text,
        }
    }

    pub(super) fn fault(text: impl Into<String>) -> Trouble {
        Trouble::Fault(text.into())
    }
}

/// What is said of a panic, in the words of whoever panicked.
#[cold]
pub fn panicked(payload: &(dyn Any + Send)) -> String {
    let said = payload.downcast_ref::<&str>().copied();
    let said = said.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a word");
    format!("a mistake inside of vesper, or of a law: panicked: {said}")
}

impl core::fmt::Display for Trouble {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.text())
    }
}

impl std::error::Error for Trouble {}

impl From<Faults> for Trouble {
    fn from(faults: Faults) -> Self {
        Trouble::Fault(faults.to_string())
    }
}

impl From<Fault> for Trouble {
    fn from(fault: Fault) -> Self {
        Trouble::Fault(fault.to_string())
    }
}

impl From<Vec<SceneFault>> for Trouble {
    fn from(faults: Vec<SceneFault>) -> Self {
        let texts: Vec<String> = faults.iter().map(SceneFault::to_string).collect();
        Trouble::Fault(texts.join("\n"))
    }
}
