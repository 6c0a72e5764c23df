//! Zero copies and no allocation in a step: a counting allocator stands below everything.

#[path = "all/support.rs"]
#[allow(unused, reason = "the other tests use the rest")]
mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use support::*;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
static FREED: AtomicU64 = AtomicU64::new(0);

/// The system's allocator, which counts what all threads ask of it.
struct Counting;

// SAFETY: hands everything on to the system's allocator; the counter needs no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: passed on from the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        FREED.fetch_add(1, Ordering::Relaxed);
        // SAFETY: passed on from the caller.
        unsafe { System.realloc(memory, layout, size) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        FREED.fetch_add(1, Ordering::Relaxed);
        // SAFETY: passed on from the caller.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

const ROWS: usize = 1_000_000;

/// One test, so that no other one allocates meanwhile.
#[test]
fn memory_is_counted() {
    a_million_lent_rows_take_no_copy_and_no_memory();
    nothing_is_left_of_what_was_freed_or_refused();
}

/// Builds that succeed, that fail, and that have no place for their engine.
fn nothing_is_left_of_what_was_freed_or_refused() {
    let build = |column: &[f64], place: *mut EngineId| {
        let builder = builder(VESPER_F64);
        ok(domain(builder, c"bodies", 1));
        _ = support::column(builder, c"bodies", c"position", column);
        ok(support::column(builder, c"bodies", c"velocity", &[0.0; 3]));
        ok(law(builder, c"kinematics", c""));
        // SAFETY: the place is a variable, or null.
        unsafe { vesper_builder_build(builder, place) }
    };
    let round = || {
        let mut engine = EngineId { id: 0 };
        assert_eq!(build(&[0.0; 3], &raw mut engine), VESPER_OK);
        ok(step(engine, 2, 0.1));
        text(engine, VESPER_CHECKPOINT);
        ok(free(engine));
        assert_eq!(build(&[0.0; 2], &raw mut engine), VESPER_ERROR_FAULT);
        assert_eq!(build(&[0.0; 3], ptr::null_mut()), VESPER_ERROR_ARGUMENT);
    };
    let live = || ALLOCATIONS.load(Ordering::Relaxed) - FREED.load(Ordering::Relaxed);
    (0..3).for_each(|_| round());
    let before = live();
    (0..50).for_each(|_| round());
    assert_eq!(live(), before);
}

fn a_million_lent_rows_take_no_copy_and_no_memory() {
    let mut position = vec![0.0; ROWS * 3];
    let mut velocity = vec![4.0; ROWS * 3];
    let mut mass = vec![1.0; ROWS];
    let builder = builder(VESPER_F64);
    ok(domain(builder, c"bodies", ROWS));
    ok(lend(builder, c"bodies", c"position", &mut position));
    ok(lend(builder, c"bodies", c"velocity", &mut velocity));
    ok(lend(builder, c"bodies", c"mass", &mut mass));
    ok(column(builder, c"scene", c"gravity", &[0.0, 0.0, -8.0]));
    ok(law(builder, c"uniform_gravity", c""));
    ok(law(builder, c"motion", c""));
    ok(settings(builder, c"threads = 1"));
    let engine = built(builder);
    for (property, numbers, width) in [(c"position", &position, 3), (c"velocity", &velocity, 3), (c"mass", &mass, 1)] {
        for access in [VESPER_READ, VESPER_WRITE] {
            let view = view(engine, c"bodies", property, access).unwrap();
            assert_eq!(view.component[0].cast_const(), numbers.as_ptr().cast(), "{property:?} is where it was lent");
            assert_eq!((view.rows, view.stride, view.width), (ROWS, width, width as u32));
        }
    }
    ok(step(engine, 1, 0.0625));
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let mut failed = VESPER_OK;
    for _ in 0..7 {
        failed |= step(engine, 2, 0.0625);
    }
    failed |= advance(engine, 0.0625);
    let asked = ALLOCATIONS.load(Ordering::Relaxed) - before;
    println!("asked for memory {asked} times in 15 steps of a million rows");
    assert_eq!((failed, asked), (VESPER_OK, 0));
    // After 1 s the velocity along z is turned round, and the height is where it was.
    assert!(position.chunks(3).all(|place| place == [4.0, 4.0, 0.0]));
    assert!(velocity.chunks(3).all(|velocity| velocity == [4.0, 4.0, -4.0]));
    // The program writes its own memory, and the next step sees it.
    velocity[5] = 100.0;
    ok(step(engine, 1, 0.0625));
    assert_eq!(position[5], (100.0 - 0.25) * 0.0625);
    ok(free(engine));
    assert_eq!(step(engine, 1, 0.0625), VESPER_ERROR_HANDLE);
}
