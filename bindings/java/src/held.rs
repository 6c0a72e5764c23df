//! What a handle of Java stands for.
//!
//! In: a value, and later the number that Java kept for it. Out: the value, for the time of a call, or for good. Never: a value
//! that a panic left half done, but to be closed.

use crate::failure::{Failure, caught};
use core::ptr;
use jni::sys::jlong;
use vesper_c::session::{Assembly, Session};

/// An engine, or what is to become one.
#[derive(Debug)]
pub(crate) struct Held<T> {
    value: T,
    /// A call is under way, or ended in a panic.
    half_done: bool,
}

pub(crate) type HeldAssembly = Held<Assembly>;
pub(crate) type HeldSession = Held<Session>;

/// Engines go from thread to thread.
const _: () = {
    const fn goes<T: Send>() {}
    goes::<HeldSession>();
};

impl<T> Held<T> {
    /// The handle of a value.
    pub(crate) fn handle(value: T) -> jlong {
        let held = Box::new(Held { value, half_done: false });
        Box::into_raw(held).expose_provenance() as jlong
    }

    /// The value of a handle.
    ///
    /// # Safety
    /// The handle came from [`Held::handle`] for this type, was not taken, and no other call has it during `'a`.
    #[inline]
    pub(crate) unsafe fn of<'a>(handle: jlong) -> &'a mut Held<T> {
        // SAFETY: the address is that of a box that is still there, and nobody else looks at it meanwhile.
        unsafe { &mut *ptr::with_exposed_provenance_mut(handle as usize) }
    }

    /// Takes the value of a handle, which is none from then on.
    ///
    /// # Safety
    /// As [`Held::of`].
    pub(crate) unsafe fn take(handle: jlong) -> T {
        // SAFETY: the address came from a box, which is taken once.
        unsafe { Box::from_raw(ptr::with_exposed_provenance_mut::<Held<T>>(handle as usize)) }.value
    }

    /// A call on the value.
    #[inline]
    pub(crate) fn call<R>(&mut self, call: impl FnOnce(&mut T) -> Result<R, Failure>) -> Result<R, Failure> {
        if self.half_done {
            return half_done();
        }
        self.half_done = true;
        let value = &mut self.value;
        let done = caught(|| call(value));
        self.half_done = done.is_err();
        done?
    }
}

#[cold]
fn half_done<R>() -> Result<R, Failure> {
    Err(Failure::Panic("an earlier call left this engine half done when it panicked: close it".to_owned()))
}
