//! Builders: what an engine is put together from.
//!
//! In: handles, names, arrays. Out: status codes, and in the end an engine's handle. Never: an engine that lacks what a call
//! before could not add, whether the client looked at its status or not.

use super::arguments::{array, number_type, numbers, place, text, text_or_empty};
use super::columns::{Type, VESPER_F32, VESPER_F64};
use super::declare::{functions, records};
use super::engine::{EngineId, Held};
use super::failure::{Status, guarded};
use super::handles::{ASSEMBLIES, ENGINES};
use crate::session::{Assembly, Memory, NumberType, Trouble};
use core::ffi::{c_char, c_void};
use core::ptr::NonNull;
use std::path::Path;

records! {
    /// The structures of builders.
    BUILDER_RECORDS;

    /// The handle of a builder.
    struct BuilderId = vesper_builder {
        /// Not to be looked at; 0 for none.
        id: u64,
    }
}

/// A call on a builder: what `read` finds wrong with its arguments is kept, as what `add` finds is.
fn described<A>(
    builder: BuilderId,
    read: impl FnOnce() -> Result<A, Trouble>,
    add: impl FnOnce(&mut Assembly, A) -> Result<(), Trouble>,
) -> Status {
    guarded(|| {
        ASSEMBLIES.with(builder.id, |assembly| {
            let arguments = read().inspect_err(|trouble| assembly.note(trouble))?;
            Ok(add(assembly, arguments)?)
        })
    })
}

functions! {
    /// The functions of builders.
    BUILDER_FUNCTIONS;

    /// Begins an engine.
    fn vesper_builder_new(precision: Type, builder: *mut BuilderId) -> Status {
        guarded(|| {
            // SAFETY: as the header says.
            let builder = unsafe { place(builder, BuilderId { id: 0 }, "the place for the builder")? };
            builder.id = ASSEMBLIES.insert(Assembly::new(number_type(precision)?)?)?;
            Ok(())
        })
    }

    /// A set of rows.
    fn vesper_builder_domain(builder: BuilderId, domain: *const c_char, rows: usize) -> Status {
        // SAFETY: as the header says.
        described(builder, || unsafe { text(domain, "the domain") }, |assembly, name| assembly.domain(name, rows))
    }

    /// A column, copied.
    fn vesper_builder_column(
        builder: BuilderId,
        domain: *const c_char,
        property: *const c_char,
        type_: Type,
        values: *const c_void,
        count: usize,
    ) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe {
            let what = text(property, "the property")?;
            Ok((text(domain, "the domain")?, what, numbers(type_, values, count, what)?))
        };
        described(builder, read, |assembly, (domain, property, values)| assembly.column(domain, property, values))
    }

    /// A column in the client's memory.
    fn vesper_builder_lend(
        builder: BuilderId,
        domain: *const c_char,
        property: *const c_char,
        type_: Type,
        values: *mut c_void,
        count: usize,
    ) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe {
            let what = text(property, "the property")?;
            Ok((text(domain, "the domain")?, what, memory(type_, values, count, what)?))
        };
        described(builder, read, |assembly, (domain, property, memory)| {
            // SAFETY: the client keeps the memory, as the header says.
            unsafe { assembly.lend(domain, property, memory) }
        })
    }

    /// A link.
    fn vesper_builder_link(
        builder: BuilderId,
        domain: *const c_char,
        property: *const c_char,
        target: *const c_char,
        rows: *const u32,
        count: usize,
    ) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe {
            let what = text(property, "the property")?;
            let rows = array::<u32>(rows.cast(), count, what)?;
            Ok((text(domain, "the domain")?, what, text(target, "the target")?, rows))
        };
        described(builder, read, |assembly, (domain, property, target, rows)| {
            assembly.link(domain, property, target, rows)
        })
    }

    /// A folder of modules of laws.
    fn vesper_builder_laws_from(builder: BuilderId, folder: *const c_char) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe { text(folder, "the folder") };
        described(builder, read, |assembly, folder| assembly.laws_from(std::path::Path::new(folder)))
    }

    /// A law.
    fn vesper_builder_law(builder: BuilderId, law: *const c_char, parameters: *const c_char) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe { Ok((text(law, "the law")?, text_or_empty(parameters, "the parameters")?)) };
        described(builder, read, |assembly, (law, parameters)| assembly.law(law, parameters))
    }

    /// Integrator, step, threads, observers.
    fn vesper_builder_settings(builder: BuilderId, settings: *const c_char) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe { text(settings, "the settings") };
        described(builder, read, |assembly, settings| assembly.settings(settings))
    }

    /// A scene.
    fn vesper_builder_scene(builder: BuilderId, scene: *const c_char, folder: *const c_char) -> Status {
        // SAFETY: as the header says.
        let read = || unsafe { Ok((text(scene, "the scene")?, text_or_empty(folder, "the folder")?)) };
        described(builder, read, |assembly, (scene, folder)| assembly.scene(scene, Path::new(folder)))
    }

    /// Checks all of it, and makes the engine. The builder is freed, whatever comes of it.
    fn vesper_builder_build(builder: BuilderId, engine: *mut EngineId) -> Status {
        guarded(|| {
            // SAFETY: as the header says.
            let engine = unsafe { place(engine, EngineId { id: 0 }, "the place for the engine") };
            let assembly = ASSEMBLIES.remove_whole(builder.id)?;
            // Nothing is built that nobody could free.
            let engine = engine?;
            engine.id = ENGINES.insert(Held::new((*assembly).build()?))?;
            Ok(())
        })
    }

    /// Frees a builder that was not built.
    fn vesper_builder_free(builder: BuilderId) -> Status {
        guarded(|| ASSEMBLIES.remove(builder.id).map(drop))
    }
}

/// Memory to be lent; what it holds is checked by the assembly, which knows the rows.
fn memory(type_: Type, start: *mut c_void, count: usize, what: &str) -> Result<Memory, Trouble> {
    let Some(start) = NonNull::new(start) else {
        if count == 0 {
            return memory(type_, NonNull::<f64>::dangling().as_ptr().cast(), 0, what);
        }
        return Err(Trouble::Argument(format!("{what} is null, and not {count} numbers: lend an array")));
    };
    match number_type(type_)? {
        NumberType::F32 => Ok(Memory::F32(start.cast(), count)),
        NumberType::F64 => Ok(Memory::F64(start.cast(), count)),
        NumberType::Rows => {
            let text =
                format!("{what} cannot be lent as rows: give VESPER_F32 ({VESPER_F32}) or VESPER_F64 ({VESPER_F64})");
            Err(Trouble::Argument(text))
        }
    }
}
