//! What went wrong, as an exception of Java.
//!
//! In: trouble of a session, a panic, a mishap of Java itself. Out: a pending `vesper.VesperException`, or the exception that Java
//! has pending already. Never: a panic that goes on into Java.

use jni::errors::ErrorPolicy;
use jni::objects::{JThrowable, JValue};
use jni::{Env, EnvUnowned, jni_sig, jni_str};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use vesper_c::session::{Trouble, panicked};

/// Why a call failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The session could not do it.
    Trouble(Trouble),
    /// A mistake inside the library, or of a law.
    Panic(String),
    /// Java could not do it: most often it has an exception pending.
    Java(jni::errors::Error),
}

impl Failure {
    /// The place of its kind in `vesper.VesperException.Kind`, and the text.
    fn told(&self) -> (i32, String) {
        match self {
            Failure::Trouble(Trouble::Argument(text)) => (0, text.clone()),
            Failure::Trouble(Trouble::Fault(text)) => (1, text.clone()),
            Failure::Trouble(Trouble::Run(text)) => (2, text.clone()),
            Failure::Panic(text) => (5, text.clone()),
            Failure::Java(error) => (5, format!("a call of Java failed: {error}")),
        }
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        Failure::Trouble(trouble)
    }
}

impl From<jni::errors::Error> for Failure {
    fn from(error: jni::errors::Error) -> Self {
        Failure::Java(error)
    }
}

/// An argument that makes no sense by itself.
pub(crate) fn argument<T>(text: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Trouble(Trouble::Argument(text.into())))
}

/// Runs something that may panic.
#[inline]
pub(crate) fn caught<T>(call: impl FnOnce() -> T) -> Result<T, Failure> {
    // What a panic may leave half done is not used again: the engine can only be closed then.
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| Failure::Panic(panicked(&*payload)))
}

/// Throws `vesper.VesperException` for what failed, and gives Java a zero, which it does not look at.
#[derive(Debug)]
pub(crate) struct Thrown;

impl<T: Default> ErrorPolicy<T, Failure> for Thrown {
    type Captures<'local: 'method, 'method> = ();

    fn on_error<'local: 'method, 'method>(
        env: &mut Env<'local>,
        (): &mut Self::Captures<'local, 'method>,
        failure: Failure,
    ) -> jni::errors::Result<T> {
        if !env.exception_check() {
            let (kind, text) = failure.told();
            let class = env.find_class(jni_str!("vesper/VesperException"))?;
            let text = env.new_string(text)?;
            let parts = [JValue::Int(kind), JValue::Object(&text)];
            let thrown = env.new_object(class, jni_sig!((jint, JString)), &parts)?;
            let thrown = JThrowable::cast_local(env, thrown)?;
            // What comes back says that an exception is pending now, as it should.
            _ = env.throw(thrown);
        }
        Ok(T::default())
    }

    fn on_panic<'local: 'method, 'method>(
        env: &mut Env<'local>,
        captures: &mut Self::Captures<'local, 'method>,
        payload: Box<dyn Any + Send + 'static>,
    ) -> jni::errors::Result<T> {
        Self::on_error(env, captures, Failure::Panic(panicked(&*payload)))
    }
}

/// Runs a native method that needs Java for its arguments or its result.
pub(crate) fn in_java<'local, T: Default>(
    env: &mut EnvUnowned<'local>,
    call: impl FnOnce(&mut Env<'local>) -> Result<T, Failure>,
) -> T {
    env.with_env(call).resolve::<Thrown>()
}

/// The result of a native method that needed nothing from Java, unless it failed.
#[inline]
pub(crate) fn told<T: Default>(env: &mut EnvUnowned<'_>, done: Result<T, Failure>) -> T {
    match done {
        Ok(value) => value,
        Err(failure) => thrown(env, failure),
    }
}

#[cold]
fn thrown<T: Default>(env: &mut EnvUnowned<'_>, failure: Failure) -> T {
    in_java(env, |_| Err(failure))
}
