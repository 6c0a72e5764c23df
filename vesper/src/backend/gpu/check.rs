//! Whether a text does what its law has declared.
//!
//! In: a program. Out: nothing, or what is wrong: the text is parsed and validated, and what its entry point does to each buffer, as naga
//! finds it by following the code, is compared with the access that the layout has from the signature. Never: a device.

use super::layout::Access;
use super::wgsl::{Numbers, Program};
use wgpu::naga;
use wgpu::naga::valid::{Capabilities, GlobalUse, ValidationFlags, Validator};

/// A text that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Wrong {
    #[error("its text is not WGSL: {0}")]
    Text(String),
    #[error("its text {does} `{buffer}`, which the law declares to {declared}")]
    Access { buffer: String, does: &'static str, declared: &'static str },
}

/// Compares the text with the declaration.
pub(crate) fn check(program: &Program) -> Result<(), Wrong> {
    let module = naga::front::wgsl::parse_str(&program.text)
        .map_err(|error| Wrong::Text(error.emit_to_string(&program.text)))?;
    let mut can = Capabilities::IMMEDIATES;
    can.set(Capabilities::FLOAT64, program.precision == Numbers::F64);
    let info = Validator::new(ValidationFlags::all(), can)
        .validate(&module)
        .map_err(|error| Wrong::Text(error.emit_to_string(&program.text)))?;
    let entry = info.get_entry_point(0);
    for (handle, global) in module.global_variables.iter() {
        let Some(place) = global.binding else { continue };
        // Behind the buffers of the layout are the lists, which the text declares to read.
        let Some(binding) = program.layout.bindings.get(place.binding as usize) else { continue };
        let found = entry[handle] & (GlobalUse::READ | GlobalUse::WRITE);
        let (expected, declared) = match binding.access {
            Access::Read => (GlobalUse::READ, "read only"),
            Access::Write => (GlobalUse::WRITE, "write only"),
            Access::Update => (GlobalUse::READ | GlobalUse::WRITE, "read and write"),
        };
        let wrong = |does| Err(Wrong::Access { buffer: binding.name.clone(), does, declared });
        // A body need not look at all that it may look at; but what it is to write it does.
        match (found - expected, expected - found) {
            (more, _) if more.contains(GlobalUse::WRITE) => return wrong("writes"),
            (more, _) if more.contains(GlobalUse::READ) => return wrong("reads"),
            (_, less) if less.contains(GlobalUse::WRITE) => return wrong("does not write"),
            _ => {}
        }
    }
    Ok(())
}
