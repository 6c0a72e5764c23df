//! Handles that are null, freed, in another thread's hands, or busy.

use super::support::*;
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering};

#[test]
fn a_freed_handle_is_an_error_also_when_its_place_is_taken() {
    let first = falling();
    ok(free(first));
    assert_eq!(step(first, 1, 0.1), VESPER_ERROR_HANDLE);
    let second = falling();
    assert_ne!(first, second, "the place is the same, the handle is not");
    assert_eq!(step(first, 1, 0.1), VESPER_ERROR_HANDLE);
    assert!(last_error().ends_with("was freed, or never was one"), "{}", last_error());
    assert_eq!(free(first), VESPER_ERROR_HANDLE);
    ok(step(second, 1, 0.1));
    ok(free(second));
    for id in [0, 1, u64::MAX, 1 << 32, u64::MAX << 32 | 7, 12_345] {
        assert_eq!(step(EngineId { id }, 1, 0.1), VESPER_ERROR_HANDLE, "{id:#x}");
        // SAFETY: no pointer is given.
        assert_eq!(unsafe { vesper_builder_free(BuilderId { id }) }, VESPER_ERROR_HANDLE, "{id:#x}");
    }
    assert_eq!(step(EngineId { id: 0 }, 1, 0.1), VESPER_ERROR_HANDLE);
    assert_eq!(last_error(), "the engine is null: it was never made, or could not be");
}

#[test]
fn a_builder_is_gone_when_it_was_built() {
    let builder = builder(VESPER_F64);
    ok(free(built(builder)));
    assert_eq!(domain(builder, c"bodies", 1), VESPER_ERROR_HANDLE);
    assert_eq!(build(builder), Err(VESPER_ERROR_HANDLE));
}

#[test]
fn an_engine_belongs_to_one_thread_at_a_time() {
    let engine = falling();
    let elsewhere = |engine| std::thread::spawn(move || (step(engine, 1, 0.0625), last_error())).join().unwrap();
    let (status, text) = elsewhere(engine);
    assert_eq!(status, VESPER_ERROR_THREAD);
    assert_eq!(text, "this engine belongs to another thread: let go of it there first");
    // SAFETY: no pointer is given.
    ok(unsafe { vesper_engine_let_go(engine) });
    assert_eq!(elsewhere(engine).0, VESPER_OK, "the next one that calls has it");
    ok(step(engine, 1, 0.0625));
    assert_eq!(elsewhere(engine).0, VESPER_ERROR_THREAD, "the other thread ended, and let go");
    ok(free(engine));
    assert_eq!(elsewhere(engine).0, VESPER_ERROR_HANDLE);
}

#[test]
fn many_threads_that_want_one_engine_never_have_it_at_once() {
    let engine = falling();
    // SAFETY: no pointer is given.
    ok(unsafe { vesper_engine_let_go(engine) });
    let taken = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut done = 0;
                while done < 500 {
                    match step(engine, 1, 0.0625) {
                        VESPER_OK => {
                            done += 1;
                            taken.fetch_add(1, Ordering::Relaxed);
                            // SAFETY: no pointer is given.
                            ok(unsafe { vesper_engine_let_go(engine) });
                        }
                        VESPER_ERROR_THREAD => std::thread::yield_now(),
                        other => panic!("{other}: {}", last_error()),
                    }
                }
            });
        }
    });
    let mut steps = 0;
    // SAFETY: the place is a variable, or null.
    ok(unsafe { vesper_engine_time(engine, ptr::null_mut(), &raw mut steps) });
    assert_eq!((steps, taken.into_inner()), (2000, 2000), "each step was taken once");
    ok(free(engine));
}

/// The engine that the callback calls, and what came of it.
static ENGINE: AtomicU64 = AtomicU64::new(0);
static CAME: AtomicI32 = AtomicI32::new(-1);
static HEARD: AtomicU64 = AtomicU64::new(0);

unsafe extern "C" fn call_back(level: u32, text: *const c_char, user: *mut c_void) {
    // SAFETY: the text ends.
    let text = unsafe { CStr::from_ptr(text) }.to_str().unwrap();
    if level == VESPER_LOG_WARN && text.starts_with("uniform_gravity is dormant") && user as usize == 77 {
        HEARD.fetch_add(1, Ordering::Relaxed);
        let id = ENGINE.load(Ordering::Relaxed);
        CAME.store(step(EngineId { id }, 1, 0.1), Ordering::Relaxed);
    }
}

#[test]
fn a_callback_is_told_that_the_engine_is_busy() {
    // SAFETY: the callback lives as long as the program.
    unsafe { ok(vesper_set_log(Some(call_back), ptr::without_provenance_mut(77), VESPER_LOG_WARN)) };
    let engine = falling();
    ENGINE.store(engine.id, Ordering::Relaxed);
    let builder = builder(VESPER_F64);
    // A law without its constant sleeps beside one that runs.
    ok(domain(builder, c"bodies", 1));
    ok(column(builder, c"bodies", c"position", &[0.0; 3]));
    ok(column(builder, c"bodies", c"velocity", &[0.0; 3]));
    ok(law(builder, c"kinematics", c""));
    ok(law(builder, c"uniform_gravity", c""));
    let other = built(builder);
    assert_eq!(HEARD.load(Ordering::Relaxed), 1, "the law that sleeps is told");
    assert_eq!(CAME.load(Ordering::Relaxed), VESPER_OK, "another engine is free");
    ENGINE.store(other.id, Ordering::Relaxed);
    // What wakes and sleeps again is told again, while the engine works.
    // SAFETY: texts end; no pointer is given.
    unsafe {
        ok(vesper_engine_enable(other, c"uniform_gravity".as_ptr(), 0));
        ok(step(other, 1, 0.1));
        ok(vesper_engine_enable(other, c"uniform_gravity".as_ptr(), 1));
        ok(step(other, 1, 0.1));
        assert_eq!(HEARD.load(Ordering::Relaxed), 2);
        assert_eq!(CAME.load(Ordering::Relaxed), VESPER_ERROR_THREAD, "this one is not");
        ok(vesper_set_log(None, ptr::null_mut(), VESPER_LOG_OFF));
        assert_eq!(vesper_set_log(None, ptr::null_mut(), 9), VESPER_ERROR_ARGUMENT);
    }
    ok(step(other, 1, 0.1));
    ok(free(other));
    ok(free(engine));
}

#[test]
fn every_status_has_words() {
    for status in STATUSES {
        // SAFETY: static text.
        let words = unsafe { CStr::from_ptr(vesper_status_text(Status::try_from(status.value).unwrap())) };
        assert!(!words.is_empty() && words != c"no status of this library", "{}", status.name);
    }
    // SAFETY: static text.
    assert_eq!(unsafe { CStr::from_ptr(vesper_status_text(99)) }, c"no status of this library");
}

#[test]
fn results_of_a_call_that_fails_are_zero() {
    let engine = falling();
    ok(free(engine));
    // SAFETY: texts end, and places are variables, filled with what is no zero.
    unsafe {
        let mut view: ColumnView = core::mem::transmute([0xAA_u8; size_of::<ColumnView>()]);
        let (mut time, mut steps, mut text) = (7.0, 7, ptr::dangling());
        let status = vesper_engine_column(engine, c"bodies".as_ptr(), c"mass".as_ptr(), VESPER_READ, &raw mut view);
        assert_eq!((status, view.rows, view.component), (VESPER_ERROR_HANDLE, 0, [ptr::null_mut(); 4]));
        assert_eq!(vesper_engine_time(engine, &raw mut time, &raw mut steps), VESPER_ERROR_HANDLE);
        assert_eq!((time, steps), (0.0, 0));
        assert_eq!(vesper_engine_text(engine, VESPER_REPORT, &raw mut text), VESPER_ERROR_HANDLE);
        assert!(text.is_null());
    }
}
