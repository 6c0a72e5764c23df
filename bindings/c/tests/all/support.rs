//! Calls of the interface with the types of Rust, for tests.

pub use core::ffi::{CStr, c_char, c_void};
pub use core::ptr;
pub use vesper_c::interface::*;

/// The text of this thread's last failure.
pub fn last_error() -> String {
    // SAFETY: the text ends, and is there until the next failure.
    unsafe { CStr::from_ptr(vesper_last_error()) }.to_str().unwrap().to_owned()
}

/// Asserts that a call did what it should.
#[track_caller]
pub fn ok(status: Status) {
    assert_eq!(status, VESPER_OK, "{}", last_error());
}

pub fn builder(precision: Type) -> BuilderId {
    let mut builder = BuilderId { id: 0 };
    // SAFETY: the place is a variable.
    ok(unsafe { vesper_builder_new(precision, &raw mut builder) });
    builder
}

pub fn domain(builder: BuilderId, name: &CStr, rows: usize) -> Status {
    // SAFETY: the text ends.
    unsafe { vesper_builder_domain(builder, name.as_ptr(), rows) }
}

pub fn column(builder: BuilderId, domain: &CStr, property: &CStr, numbers: &[f64]) -> Status {
    let (start, count) = (numbers.as_ptr().cast(), numbers.len());
    // SAFETY: texts end, and the array has so many numbers.
    unsafe { vesper_builder_column(builder, domain.as_ptr(), property.as_ptr(), VESPER_F64, start, count) }
}

/// The array has to outlive the engine.
pub fn lend(builder: BuilderId, domain: &CStr, property: &CStr, numbers: &mut [f64]) -> Status {
    let (start, count) = (numbers.as_mut_ptr().cast(), numbers.len());
    // SAFETY: texts end, and the array has so many numbers.
    unsafe { vesper_builder_lend(builder, domain.as_ptr(), property.as_ptr(), VESPER_F64, start, count) }
}

pub fn link(builder: BuilderId, domain: &CStr, property: &CStr, target: &CStr, rows: &[u32]) -> Status {
    let (start, count) = (rows.as_ptr(), rows.len());
    // SAFETY: texts end, and the array has so many rows.
    unsafe { vesper_builder_link(builder, domain.as_ptr(), property.as_ptr(), target.as_ptr(), start, count) }
}

pub fn law(builder: BuilderId, name: &CStr, parameters: &CStr) -> Status {
    // SAFETY: texts end.
    unsafe { vesper_builder_law(builder, name.as_ptr(), parameters.as_ptr()) }
}

pub fn settings(builder: BuilderId, text: &CStr) -> Status {
    // SAFETY: the text ends.
    unsafe { vesper_builder_settings(builder, text.as_ptr()) }
}

pub fn build(builder: BuilderId) -> Result<EngineId, Status> {
    let mut engine = EngineId { id: 0 };
    // SAFETY: the place is a variable.
    match unsafe { vesper_builder_build(builder, &raw mut engine) } {
        VESPER_OK => Ok(engine),
        status => {
            assert_eq!(engine.id, 0, "no handle where nothing was built");
            Err(status)
        }
    }
}

pub fn built(builder: BuilderId) -> EngineId {
    build(builder).unwrap_or_else(|status| panic!("{status}: {}", last_error()))
}

pub fn get(engine: EngineId, domain: &CStr, property: &CStr, count: usize) -> Vec<f64> {
    let mut numbers = vec![0.0_f64; count];
    let start = numbers.as_mut_ptr().cast();
    // SAFETY: texts end, and the array has so many numbers.
    ok(unsafe { vesper_engine_get(engine, domain.as_ptr(), property.as_ptr(), VESPER_F64, start, count) });
    numbers
}

pub fn set(engine: EngineId, domain: &CStr, property: &CStr, numbers: &[f64]) -> Status {
    let (start, count) = (numbers.as_ptr().cast(), numbers.len());
    // SAFETY: texts end, and the array has so many numbers.
    unsafe { vesper_engine_set(engine, domain.as_ptr(), property.as_ptr(), VESPER_F64, start, count) }
}

pub fn view(engine: EngineId, domain: &CStr, property: &CStr, access: u32) -> Result<ColumnView, Status> {
    let mut view = core::mem::MaybeUninit::<ColumnView>::zeroed();
    // SAFETY: texts end, and the place is a variable.
    let status = unsafe { vesper_engine_column(engine, domain.as_ptr(), property.as_ptr(), access, view.as_mut_ptr()) };
    // SAFETY: zeros are a view of nothing.
    if status == VESPER_OK { Ok(unsafe { view.assume_init() }) } else { Err(status) }
}

pub fn step(engine: EngineId, count: u64, step: f64) -> Status {
    // SAFETY: no pointer is given.
    unsafe { vesper_engine_step(engine, count, step) }
}

pub fn advance(engine: EngineId, frame: f64) -> Status {
    // SAFETY: no pointer is given.
    unsafe { vesper_engine_advance(engine, frame) }
}

pub fn text(engine: EngineId, which: u32) -> String {
    let mut text = ptr::null();
    // SAFETY: the place is a variable; the text ends, and is there until the next call.
    unsafe {
        ok(vesper_engine_text(engine, which, &raw mut text));
        CStr::from_ptr(text).to_str().unwrap().to_owned()
    }
}

pub fn free(engine: EngineId) -> Status {
    // SAFETY: no pointer is given.
    unsafe { vesper_engine_free(engine) }
}

/// A body that falls from 10 m, and the engine's handle.
pub fn falling() -> EngineId {
    let builder = builder(VESPER_F64);
    ok(domain(builder, c"bodies", 1));
    ok(column(builder, c"bodies", c"position", &[0.0, 0.0, 10.0]));
    ok(column(builder, c"bodies", c"velocity", &[0.0; 3]));
    ok(column(builder, c"bodies", c"mass", &[2.0]));
    ok(column(builder, c"scene", c"gravity", &[0.0, 0.0, -8.0]));
    ok(law(builder, c"uniform_gravity", c""));
    ok(law(builder, c"motion", c""));
    ok(settings(builder, c"step = 0.0625"));
    built(builder)
}
