//! The native methods of `vesper.Engine`.
//!
//! In: the handle of an engine, names, arrays. Out: numbers, texts, exceptions. Never: a call of Java on the way of a step, unless
//! it fails: that is what keeps a step as cheap as it is.

use crate::arguments::{memory, numbers, range, room, room_in, rows, text, texts};
use crate::failure::{Failure, argument, caught, in_java, told};
use crate::held::HeldSession;
use jni::objects::{JByteBuffer, JClass, JDoubleArray, JIntArray, JObject, JObjectArray, JString};
use jni::refs::IntoAuto;
use jni::sys::{jboolean, jdouble, jint, jlong};
use jni::{Env, EnvUnowned, jni_mangle};
use vesper_c::session::{Numbers, NumbersMut, Session, Words, is_lent};

/// A call that needs nothing from Java.
#[inline]
fn on<T: Default>(env: &mut EnvUnowned<'_>, handle: jlong, call: impl FnOnce(&mut Session) -> Result<T, Failure>) -> T {
    // SAFETY: `vesper/Held.java` gives the handle of an engine that is not closed, to the one thread that has it.
    told(env, unsafe { HeldSession::of(handle) }.call(call))
}

/// A call with arguments or a result of Java's.
fn with<'local, T: Default>(
    env: &mut EnvUnowned<'local>,
    handle: jlong,
    call: impl FnOnce(&mut Env<'local>, &mut Session) -> Result<T, Failure>,
) -> T {
    // SAFETY: as in `on`.
    in_java(env, |env| unsafe { HeldSession::of(handle) }.call(|session| call(env, session)))
}

/// The names of a column.
fn names(env: &Env<'_>, domain: &JString<'_>, property: &JString<'_>) -> Result<(String, String), Failure> {
    let property = text(env, property, "the property")?;
    Ok((text(env, domain, "the domain")?, property))
}

/// Takes steps.
#[jni_mangle("vesper.Engine")]
pub fn native_step<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    count: jlong,
    step: jdouble,
) {
    on(&mut env, handle, |session| match u64::try_from(count) {
        Ok(count) => Ok(session.step(count, step)?),
        Err(_) => argument(format!("{count} steps cannot be taken: give 0 or more")),
    });
}

/// Goes on by a frame.
#[jni_mangle("vesper.Engine")]
pub fn native_advance<'local>(mut env: EnvUnowned<'local>, _engine: JObject<'local>, handle: jlong, frame: jdouble) {
    on(&mut env, handle, |session| Ok(session.advance(frame)?));
}

/// The time, in s.
#[jni_mangle("vesper.Engine")]
pub fn native_time<'local>(mut env: EnvUnowned<'local>, _engine: JObject<'local>, handle: jlong) -> jdouble {
    on(&mut env, handle, |session| Ok(session.time()))
}

/// Steps taken.
#[jni_mangle("vesper.Engine")]
pub fn native_steps<'local>(mut env: EnvUnowned<'local>, _engine: JObject<'local>, handle: jlong) -> jlong {
    on(&mut env, handle, |session| Ok(session.steps().cast_signed()))
}

/// How many numbers a column has.
#[jni_mangle("vesper.Engine")]
pub fn native_count<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
) -> jlong {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        let view = session.column(&domain, &property)?;
        Ok((view.rows * view.width) as jlong)
    })
}

/// Where the first number of a column is.
#[jni_mangle("vesper.Engine")]
pub fn native_address<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
) -> jlong {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        Ok(session.column(&domain, &property)?.components[0].addr() as jlong)
    })
}

/// Copies the numbers of a column to an array.
#[jni_mangle("vesper.Engine")]
pub fn native_get<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    values: JDoubleArray<'local>,
) {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        let mut numbers = room(env, &values, &format!("{domain}.{property}"))?;
        session.get(&domain, &property, NumbersMut::F64(&mut numbers))?;
        Ok(values.set_region(env, 0, &numbers)?)
    });
}

/// Copies the numbers of a column to a direct buffer.
#[jni_mangle("vesper.Engine")]
pub fn native_get_direct<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    buffer: JByteBuffer<'local>,
) {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        let what = format!("{domain}.{property}");
        let memory = memory(env, &buffer, session.precision(), &what)?;
        if is_lent(&range(memory)) {
            return argument(format!("the buffer for {what} is lent to an engine: read it as it is, or give another"));
        }
        // SAFETY: Java has the buffer during the call, and no engine has some of its memory.
        Ok(session.get(&domain, &property, unsafe { room_in(memory, &what) }?)?)
    });
}

/// Copies the rows of a link.
#[jni_mangle("vesper.Engine")]
pub fn native_links<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    ends: JIntArray<'local>,
) {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        let mut links = vec![0; ends.len(env)?];
        session.get(&domain, &property, NumbersMut::Rows(&mut links))?;
        let links: Vec<jint> = links.into_iter().map(u32::cast_signed).collect();
        Ok(ends.set_region(env, 0, &links)?)
    });
}

/// Changes the numbers of a column.
#[jni_mangle("vesper.Engine")]
pub fn native_set<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
    values: JDoubleArray<'local>,
) {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        let values = numbers(env, &values, &format!("{domain}.{property}"))?;
        Ok(session.set(&domain, &property, Numbers::F64(&values))?)
    });
}

/// Adds rows; of each property either numbers or rows of its target are there.
#[jni_mangle("vesper.Engine")]
pub fn native_add_rows<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    count: jlong,
    properties: JObjectArray<'local, JString<'local>>,
    values: JObjectArray<'local, JDoubleArray<'local>>,
    links: JObjectArray<'local, JIntArray<'local>>,
) {
    /// Values for a property.
    enum Given {
        Numbers(Vec<f64>),
        Links(Vec<u32>),
    }
    with(&mut env, handle, |env, session| {
        let domain = text(env, &domain, "the domain")?;
        let Ok(count) = usize::try_from(count) else {
            return argument(format!("{count} new rows of {domain}: give 0 or more"));
        };
        let properties = texts(env, &properties, "a property")?;
        let mut given = Vec::new();
        for (place, property) in properties.iter().enumerate() {
            let what = format!("{domain}.{property}");
            let values = values.get_element(env, place)?.auto();
            let links = links.get_element(env, place)?.auto();
            given.push(if links.is_null() {
                Given::Numbers(numbers(env, &values, &what)?)
            } else {
                Given::Links(rows(env, &links, &what)?)
            });
        }
        let each = properties.iter().zip(&given).map(|(property, given)| {
            let numbers = match given {
                Given::Numbers(numbers) => Numbers::F64(numbers),
                Given::Links(rows) => Numbers::Rows(rows),
            };
            (property.as_str(), numbers)
        });
        Ok(session.add_rows(&domain, count, &each.collect::<Vec<_>>())?)
    });
}

/// Removes rows.
#[jni_mangle("vesper.Engine")]
pub fn native_remove_rows<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    removed: JIntArray<'local>,
) {
    with(&mut env, handle, |env, session| {
        let domain = text(env, &domain, "the domain")?;
        let removed = rows(env, &removed, &domain)?;
        Ok(session.remove_rows(&domain, &removed)?)
    });
}

/// Switches a law on or off.
#[jni_mangle("vesper.Engine")]
pub fn native_enable<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    law: JString<'local>,
    enabled: jboolean,
) {
    with(&mut env, handle, |env, session| Ok(session.enable(&text(env, &law, "the law")?, enabled)?));
}

/// Looks at one more property.
#[jni_mangle("vesper.Engine")]
pub fn native_observe<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    domain: JString<'local>,
    property: JString<'local>,
) {
    with(&mut env, handle, |env, session| {
        let (domain, property) = names(env, &domain, &property)?;
        Ok(session.observe(&domain, &property)?)
    });
}

/// What the engine has to say.
#[jni_mangle("vesper.Engine")]
pub fn native_text<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    which: jint,
) -> JString<'local> {
    with(&mut env, handle, |env, session| {
        let words = match which {
            0 => Words::Report,
            1 => Words::Explain,
            2 => Words::Dot,
            _ => Words::Checkpoint,
        };
        Ok(env.new_string(session.words(words)?)?)
    })
}

/// Goes on from a checkpoint.
#[jni_mangle("vesper.Engine")]
pub fn native_restore<'local>(
    mut env: EnvUnowned<'local>,
    _engine: JObject<'local>,
    handle: jlong,
    checkpoint: JString<'local>,
) {
    with(&mut env, handle, |env, session| Ok(session.restore(&text(env, &checkpoint, "the checkpoint")?)?));
}

/// Frees the engine; lent buffers are Java's alone from then on.
#[jni_mangle("vesper.Held")]
pub fn native_free<'local>(mut env: EnvUnowned<'local>, _class: JClass<'local>, handle: jlong) {
    // SAFETY: `vesper/Held.java` gives up the handle before it calls, once.
    told(&mut env, caught(|| drop(unsafe { HeldSession::take(handle) })));
}
