//! The native methods of `vesper.Library`.
//!
//! In: the class, once it has loaded this library; the level of its logger. Out: the version that the Java half looks for; what is
//! logged, to `Library.say`, on the thread that has something to say. Never: a thread that keeps the machine of Java from ending.

use crate::failure::in_java;
use jni::errors::Error;
use jni::objects::{JClass, JString, JValue};
use jni::refs::Global;
use jni::sys::jint;
use jni::{Env, EnvUnowned, JavaVM, jni_mangle, jni_sig, jni_str};
use log::{LevelFilter, Log, Metadata, Record};
use std::sync::OnceLock;

/// The class that hears what is logged.
static HEARS: OnceLock<Global<JClass<'static>>> = OnceLock::new();

struct Forward;

impl Log for Forward {
    /// Vesper's own words only: the way to Java has words of its own, which would go that way again.
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("vesper")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let (Some(class), Ok(machine)) = (HEARS.get(), JavaVM::singleton()) else { return };
        let say = |env: &mut Env<'_>| -> Result<(), Error> {
            let text = env.new_string(record.args().to_string())?;
            let parts = [JValue::Int(record.level() as jint), JValue::Object(&text)];
            env.call_static_method(class, jni_str!("say"), jni_sig!((jint, JString)), &parts)?;
            Ok(())
        };
        // A thread of an engine is let go afterwards: Java waits at its end for threads that are attached. A logger that throws
        // keeps what it was told.
        _ = machine.attach_current_thread_for_scope(say);
    }

    fn flush(&self) {}
}

/// The version of this library.
#[jni_mangle("vesper.Library")]
pub fn native_version<'local>(mut env: EnvUnowned<'local>, class: JClass<'local>) -> JString<'local> {
    in_java(&mut env, |env| {
        let class = env.new_global_ref(class)?;
        if HEARS.set(class).is_ok() {
            // A program that has a logger in Rust already keeps it.
            _ = log::set_logger(&Forward);
        }
        Ok(env.new_string(env!("CARGO_PKG_VERSION"))?)
    })
}

/// Says up to which level somebody listens: 0 for nobody, 5 for everything.
#[jni_mangle("vesper.Library")]
pub fn native_listen<'local>(_env: EnvUnowned<'local>, _class: JClass<'local>, level: jint) {
    log::set_max_level(match level {
        0 => LevelFilter::Off,
        1 => LevelFilter::Error,
        2 => LevelFilter::Warn,
        3 => LevelFilter::Info,
        4 => LevelFilter::Debug,
        _ => LevelFilter::Trace,
    });
}
