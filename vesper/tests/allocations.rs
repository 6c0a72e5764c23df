//! No allocation in `advance`: a counting allocator stands below everything.

#[path = "core/common.rs"]
mod common;

use common::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use vesper::prelude::*;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, which counts what the own thread asks of it.
struct Counting;

impl Counting {
    fn count() {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
    }
}

// SAFETY: hands everything on to the system's allocator; the counter needs no memory and no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::count();
        // SAFETY: passed on from the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::count();
        // SAFETY: passed on from the caller.
        unsafe { System.realloc(memory, layout, size) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: passed on from the caller.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// How often `work` asks for memory on this thread.
fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

/// Asserts that frames after the first one ask for none.
fn frames_take_no_memory(name: &str, mut engine: Engine<f64>) {
    // In its first frame an integrator may still prepare.
    engine.advance(0.01).unwrap();
    let count = allocations(|| (0..100).for_each(|_| engine.advance(0.01).unwrap()));
    assert_eq!(count, 0, "{name}");
    assert_eq!(engine.steps(), 202, "{name}: the steps were taken");
}

fn all_shapes(integrator: impl Integrator + 'static) -> Builder<f64> {
    let bodies = cloud::<f64>(600, 7).subset(Cooling, [3, 300, 599], [1.0, 2.0, 3.0]);
    let bodies = bodies.with(Temperature, vec![300.0; 600]);
    Engine::builder()
        .domain(bodies)
        .domain(springs(600))
        .field(ElectricField, |at: DVec3, time: f64| at * time)
        .law(Coulomb)
        .law(Cool)
        .law(Drag.every(3))
        .law(Echo)
        .law(Electric)
        .law(Floor)
        .law(Herd)
        .law(Motion)
        .law(Recorder)
        .law(Remember)
        .law(Spring)
        .law(Weight)
        .observe("bodies", Trace)
        .backend(Backend::Cpu)
        .integrator(integrator)
        .step(0.005)
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 1);
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0_u8; 100]))), 1);
}

#[test]
fn laws_of_all_shapes_under_all_integrators() {
    frames_take_no_memory("semi-implicit Euler", all_shapes(SemiImplicitEuler).build().unwrap());
    frames_take_no_memory("Runge-Kutta 4", all_shapes(RungeKutta4).build().unwrap());
    let warm = |builder: Builder<f64>| builder.law(Weight).law(Coulomb).law(Spring).law(Motion).step(0.005);
    let bodies = Engine::builder().domain(cloud(600, 7)).domain(springs(600)).backend(Backend::Cpu);
    frames_take_no_memory("leapfrog", warm(bodies).integrator(Leapfrog::default()).build().unwrap());
}

#[test]
fn composed_laws() {
    let bodies = Engine::builder().domain(cloud(600, 7)).backend(Backend::Cpu).integrator(SemiImplicitEuler);
    frames_take_no_memory("pipeline!", bodies.laws(pipeline![Weight, Drag, Motion]).step(0.005).build().unwrap());
}

#[test]
fn lent_memory() {
    let start = Lent::new(vec![[1.0, 2.0, 3.0]; 700]);
    let domain = Domain::new("bodies").lend(Position, &start).with(Velocity, vec![[1.0, 0.0, 0.0]; 700]);
    let domain = domain.with(Mass, vec![2.0; 700]);
    let engine = Engine::builder().domain(domain).law(Weight).law(Motion).backend(Backend::Cpu);
    frames_take_no_memory("lent", engine.step(0.005).build().unwrap());
}

#[test]
fn nothing_to_do() {
    frames_take_no_memory("no law", Engine::builder().step(0.005).build().unwrap());
}

#[test]
fn a_frame_after_the_client_changed_values() {
    let mut engine = all_shapes(SemiImplicitEuler).build().unwrap();
    engine.advance(0.01).unwrap();
    let count = allocations(|| {
        engine.state_mut().set("bodies", Velocity, 3, DVec3::ONE).unwrap();
        engine.advance(0.01).unwrap();
    });
    assert_eq!(count, 0);
}
