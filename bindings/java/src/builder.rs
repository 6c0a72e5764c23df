//! The native methods of `vesper.Builder`.
//!
//! In: the handle of what is being put together, names, arrays, direct buffers. Out: in the end the handle of an engine. Never: an
//! exception for what does not fit: faults are kept, so that building tells all of them at once.

use crate::arguments::{memory, numbers, rows, text, text_or_empty};
use crate::failure::{Failure, argument, caught, in_java, told};
use crate::held::{Held, HeldAssembly};
use jni::objects::{JByteBuffer, JDoubleArray, JIntArray, JObject, JString};
use jni::sys::{jboolean, jlong};
use jni::{Env, EnvUnowned, jni_mangle};
use std::path::Path;
use vesper_c::session::{Assembly, NumberType, Numbers, Trouble};

/// A call on what is being put together: trouble with its arguments is kept, as that of the assembly itself is.
fn described<'local, A>(
    env: &mut EnvUnowned<'local>,
    handle: jlong,
    read: impl FnOnce(&mut Env<'local>) -> Result<A, Failure>,
    add: impl FnOnce(&mut Assembly, A) -> Result<(), Trouble>,
) {
    in_java(env, |env| {
        let arguments = read(env);
        // SAFETY: `vesper.Builder` has the handle only while it builds, in a variable of the method that does.
        let held = unsafe { HeldAssembly::of(handle) };
        held.call(|assembly| {
            match arguments {
                Ok(arguments) => _ = add(assembly, arguments),
                Err(Failure::Trouble(trouble)) => assembly.note(&trouble),
                Err(other) => return Err(other),
            }
            Ok(())
        })
    });
}

/// Begins an engine that computes in f32 or f64.
#[jni_mangle("vesper.Builder")]
pub fn native_begin<'local>(mut env: EnvUnowned<'local>, _builder: JObject<'local>, single: jboolean) -> jlong {
    let precision = if single { NumberType::F32 } else { NumberType::F64 };
    let assembly = Assembly::new(precision).map_err(Failure::Trouble);
    told(&mut env, assembly.map(Held::handle))
}

/// Keeps a fault that Java found.
#[jni_mangle("vesper.Builder")]
pub fn native_note<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    fault: JString<'local>,
) {
    let read = |env: &mut Env<'local>| -> Result<(), Failure> { argument(text(env, &fault, "the fault")?) };
    described(&mut env, handle, read, |_, ()| Ok(()));
}

/// A set of rows.
#[jni_mangle("vesper.Builder")]
pub fn native_domain<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    rows: jlong,
) {
    let read = |env: &mut Env<'local>| {
        let domain = text(env, &domain, "the domain")?;
        match usize::try_from(rows) {
            Ok(rows) => Ok((domain, rows)),
            Err(_) => argument(format!("domain {domain} has {rows} rows: give 0 or more")),
        }
    };
    described(&mut env, handle, read, |assembly, (domain, rows)| assembly.domain(&domain, rows));
}

/// A column, copied.
#[jni_mangle("vesper.Builder")]
pub fn native_column<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    values: JDoubleArray<'local>,
) {
    let read = |env: &mut Env<'local>| {
        let property = text(env, &property, "the property")?;
        let domain = text(env, &domain, "the domain")?;
        let values = numbers(env, &values, &format!("{domain}.{property}"))?;
        Ok((domain, property, values))
    };
    described(&mut env, handle, read, |assembly, (domain, property, values)| {
        assembly.column(&domain, &property, Numbers::F64(&values))
    });
}

/// A column in a direct buffer, which `vesper.Engine` keeps until the engine is closed.
#[jni_mangle("vesper.Builder")]
pub fn native_lend<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    single: jboolean,
    domain: JString<'local>,
    property: JString<'local>,
    buffer: JByteBuffer<'local>,
) {
    let precision = if single { NumberType::F32 } else { NumberType::F64 };
    let read = |env: &mut Env<'local>| {
        let property = text(env, &property, "the property")?;
        let domain = text(env, &domain, "the domain")?;
        let what = format!("{domain}.{property}");
        let memory = memory(env, &buffer, precision, &what)?;
        Ok((domain, property, memory))
    };
    described(&mut env, handle, read, |assembly, (domain, property, memory)| {
        // SAFETY: the buffer has so many numbers, and is kept by Java while the engine is there. Its other threads touch it
        // at times of their own, as the documents of Java's half forbid; what they would break are numbers.
        unsafe { assembly.lend(&domain, &property, memory) }
    });
}

/// A link.
#[jni_mangle("vesper.Builder")]
pub fn native_link<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    target: JString<'local>,
    ends: JIntArray<'local>,
) {
    let read = |env: &mut Env<'local>| {
        let property = text(env, &property, "the property")?;
        let domain = text(env, &domain, "the domain")?;
        let ends = rows(env, &ends, &format!("{domain}.{property}"))?;
        Ok((domain, property, text(env, &target, "the target")?, ends))
    };
    described(&mut env, handle, read, |assembly, (domain, property, target, ends)| {
        assembly.link(&domain, &property, &target, &ends)
    });
}

/// A folder with modules of laws.
#[jni_mangle("vesper.Builder")]
pub fn native_laws_from<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    folder: JString<'local>,
) {
    let read = |env: &mut Env<'local>| text(env, &folder, "the folder");
    described(&mut env, handle, read, |assembly, folder| assembly.laws_from(Path::new(&folder)));
}

/// A law.
#[jni_mangle("vesper.Builder")]
pub fn native_law<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    law: JString<'local>,
    parameters: JString<'local>,
) {
    let read =
        |env: &mut Env<'local>| Ok((text(env, &law, "the law")?, text_or_empty(env, &parameters, "the parameters")?));
    described(&mut env, handle, read, |assembly, (law, parameters)| assembly.law(&law, &parameters));
}

/// Integrator, step, threads, observers.
#[jni_mangle("vesper.Builder")]
pub fn native_settings<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    settings: JString<'local>,
) {
    let read = |env: &mut Env<'local>| text(env, &settings, "the settings");
    described(&mut env, handle, read, |assembly, settings| assembly.settings(&settings));
}

/// A scene.
#[jni_mangle("vesper.Builder")]
pub fn native_scene<'local>(
    mut env: EnvUnowned<'local>,
    _builder: JObject<'local>,
    handle: jlong,
    scene: JString<'local>,
    folder: JString<'local>,
) {
    let read =
        |env: &mut Env<'local>| Ok((text(env, &scene, "the scene")?, text_or_empty(env, &folder, "the folder")?));
    described(&mut env, handle, read, |assembly, (scene, folder)| assembly.scene(&scene, Path::new(&folder)));
}

/// Checks all of it and makes the engine; the handle is none from then on, whatever comes of it.
#[jni_mangle("vesper.Builder")]
pub fn native_build<'local>(mut env: EnvUnowned<'local>, _builder: JObject<'local>, handle: jlong) -> jlong {
    // SAFETY: as in `described`; Java forgets the handle before it calls.
    let assembly = unsafe { HeldAssembly::take(handle) };
    let session = caught(|| assembly.build().map_err(Failure::Trouble)).and_then(|session| session);
    told(&mut env, session.map(Held::handle))
}

/// Forgets what was not built.
#[jni_mangle("vesper.Builder")]
pub fn native_forget<'local>(mut env: EnvUnowned<'local>, _builder: JObject<'local>, handle: jlong) {
    // SAFETY: as in `native_build`.
    told(&mut env, caught(|| drop(unsafe { HeldAssembly::take(handle) })));
}
