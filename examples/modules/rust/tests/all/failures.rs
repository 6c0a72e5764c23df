//! A law that fails while it runs is switched off and named, and everything else goes on.

use super::compiler::{opened, wings};
use core::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;
use vesper::module::{abi, exported};
use vesper::prelude::*;
use vesper::real::Mask as _;
use vesper_laws::Motion;

/// A law in C whose body is `BODY`, beside one that is right.
pub const ONE: &str = r#"
#include "vesper_law.h"
static int32_t create(const vesper_host *host, const double *p, size_t n, void **self) { (void)p, (void)n; *self = (void *)host; return 0; }
static int32_t apply(void *self, const vesper_call *call) {
    double *force = call->slots[4], *mass = call->slots[0];
    const vesper_host *host = self;
    (void)host, (void)force, (void)mass;
    BODY
    return 0;
}
static int32_t right(void *self, const vesper_call *call) {
    (void)self;
    for (size_t i = call->begin; i < call->end; i++) ((double *)call->slots[6])[i] += 1;
    return 0;
}
static const vesper_port ports[] = {{.property = "mass", .si = {0, 1}, .kind = 1, .mode = VESPER_READS},
    {.property = "velocity", .si = {1, 0, -1}, .kind = 3, .mode = VESPER_READS},
    {.property = "force", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS}};
#define LAW(law, f) static const vesper_law law = {.struct_size = sizeof(vesper_law), .port_size = sizeof *ports, .parameter_size = sizeof(vesper_parameter), \
    .shape = VESPER_ROWS, .precisions = VESPER_LAW_F64, .name = #law, .port_count = 3, .ports = ports, .create = create, .apply = f}
LAW(wrong, apply);
LAW(fine, right);
static const vesper_law *const laws[] = {&wrong, &fine};
static const vesper_module module = {VESPER_LAW_ABI, sizeof module, 0, 2, laws};
const vesper_module *vesper_module_v1(void) { return &module; }
"#;

fn bodies() -> Domain<f64> {
    Domain::new("bodies").with(Position, [[0.0; 3]; 3]).with(Velocity, [[1.0, 0.0, 0.0]; 3]).with(Mass, [1.0, 2.0, 3.0])
}

fn engine(name: &str, body: &str) -> Result<Engine<f64>, Faults> {
    let module = opened(name, &ONE.replace("BODY", body))?;
    let builder = Engine::builder().domain(bodies()).law(Motion).law(module.law("wrong")?).law(module.law("fine")?);
    builder.step(0.1).build()
}

#[test]
fn a_law_that_fails_is_switched_off_and_all_else_goes_on() {
    let body =
        "if (mass[0] == 1.0 && call->end == 3) { host->log(host->context, VESPER_ERROR, \"no air\"); return 7; }";
    let mut engine = engine("fails", body).unwrap();
    let fault = engine.advance(0.1).unwrap_err();
    assert_eq!(
        fault.to_string(),
        "wrong failed and is switched off: `apply` returned 7: no air; all else goes on without it. Mend it, and build the engine again"
    );
    let height = |engine: &Engine<f64>| engine.state().get("bodies", Position, 0).unwrap().z;
    let first = height(&engine);
    for _ in 0..9 {
        engine.advance(0.1).unwrap();
    }
    assert!(first > 0.0 && (height(&engine) - 0.5).abs() < 1e-12, "{}", height(&engine));
    assert!(engine.explain().contains("wrong"), "{}", engine.explain());
    assert!(matches!(engine.enable("wrong", true), Err(Fault::LawFailed { .. })));
    engine.advance(0.1).unwrap();
}

#[test]
fn a_frame_in_which_a_law_fails_is_a_frame() {
    let mut engine = engine("fails_in_a_frame", "if (mass[0] == 1.0 && call->end == 3) return 7;").unwrap();
    assert!(engine.advance(0.25).is_err());
    assert_eq!((engine.steps(), engine.advance(0.05).is_ok(), engine.steps()), (2, true, 3));
    let saved = engine.checkpoint().unwrap();
    assert_eq!(saved.laws.iter().filter(|law| law.failed.as_deref() == Some("`apply` returned 7")).count(), 1);
    let mut other = super::failures::engine("fails_in_a_frame", "").unwrap();
    other.restore(&saved).unwrap();
    assert!(other.report().laws.iter().any(|law| matches!(law.status, Status::Failed { .. })), "{}", other.report());
    other.advance(0.1).unwrap();
    engine.advance(0.1).unwrap();
    assert_eq!(engine.state().hash(), other.state().hash());
}

#[test]
fn a_number_that_is_none_is_traced_to_the_law_that_gave_it() {
    let mut engine =
        engine("gives_nan", "for (size_t i = call->begin; i < call->end; i++) force[i] += 0.0 / (mass[i] - 2);")
            .unwrap();
    engine.trace_blow_ups(true);
    let fault = engine.advance(0.1).unwrap_err().to_string();
    assert!(fault.contains("row 1") && fault.contains("wrong"), "{fault}");
}

#[test]
fn a_panic_in_a_body_is_contained() {
    let level = wings().law("level").unwrap().with("stiffness", &[-1.0]).unwrap();
    let builder = Engine::builder().domain(bodies()).law(Motion).law(wings().law("lift").unwrap()).law(level);
    let mut engine = builder.step(0.1).build().unwrap();
    let fault = engine.advance(0.1).unwrap_err().to_string();
    assert!(
        fault.starts_with(
            "level failed and is switched off: `apply` returned -2: it panicked: the stiffness is negative"
        ),
        "{fault}"
    );
    engine.advance(0.1).unwrap();
    assert!(engine.state().get("bodies", Position, 0).unwrap().z > 0.0);
}

#[test]
fn a_panic_in_a_row_is_contained_and_its_sums_are_nothing() {
    for threads in [1, 2] {
        let flock = Domain::<f64>::new("bodies").with(Position, vec![[0.0; 3]; 3000]);
        let flock = flock.with(Velocity, vec![[0.0; 3]; 3000]).with(Mass, vec![1.0; 3000]);
        let builder = Engine::builder().domain(flock).law(Motion).law(wings().law("updraft").unwrap());
        let mut engine = builder.integrator(SemiImplicitEuler).step(0.1).threads(threads).build().unwrap();
        engine.advance(0.1).unwrap();
        let velocity = |engine: &Engine<f64>| engine.state().numbers("bodies", Velocity).unwrap();
        let before = velocity(&engine);
        assert!(before.chunks(3).all(|bird| bird[2] == 0.1));
        engine.state_mut().set("bodies", Mass, 3, -1.0).unwrap();
        let fault = engine.advance(0.1).unwrap_err().to_string();
        let words = "updraft failed and is switched off: `apply` returned -2: it panicked: a mass is negative";
        assert!(fault.starts_with(words), "{fault}");
        // Of the rows of that call nothing is left, neither of it nor of the one before.
        let after = velocity(&engine);
        assert!(before[..48] == after[..48], "{:?}", &after[..48]);
        engine.advance(0.1).unwrap();
        assert!(matches!(engine.enable("updraft", true), Err(Fault::LawFailed { .. })));
    }
}

/// A law that nobody can make.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity), adds(force: Force))]
struct Nobody<R = f64> {
    #[law(unit = "kg/s", default = 1.0)]
    slope: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Nobody<R> {
    fn row(&self, body: NobodyRow<R>) -> R::Vec3 {
        assert!(self.slope.less(R::lit(0.0)).bits() == 0, "not so");
        body.velocity * self.slope
    }
}

type Said = Mutex<Vec<(u32, String)>>;

/// Keeps what is said.
unsafe extern "C" fn keep(context: *mut c_void, level: u32, text: *const c_char) {
    // SAFETY: the context is the list below, and the text ends with a zero.
    let (said, text) = unsafe { (&*context.cast_const().cast::<Said>(), CStr::from_ptr(text)) };
    said.lock().unwrap().push((level, text.to_string_lossy().into_owned()));
}

#[test]
fn no_panic_leaves_a_module_and_its_words_do() {
    // Other tests may log: that, too, is forwarded from now on.
    let said: &'static Said = Box::leak(Box::default());
    let context = (&raw const *said).cast_mut().cast();
    let host: &'static abi::Host =
        Box::leak(Box::new(abi::Host { struct_size: size_of::<abi::Host>() as u32, abi: 1, context, log: Some(keep) }));
    let table = exported::<Nobody>();
    let mut this = core::ptr::null_mut();
    let (mut velocity, mut force) = ([[1.0_f64; 64]; 3], [[0.0_f64; 64]; 3]);
    let mut slots: Vec<*mut c_void> = velocity.iter_mut().map(|c| c.as_mut_ptr().cast()).collect();
    slots.extend(force.iter_mut().map(|c| c.as_mut_ptr().cast::<c_void>()));
    let call = abi::Call {
        struct_size: size_of::<abi::Call>() as u32,
        precision: abi::F64,
        begin: 1,
        end: 3,
        others_begin: 0,
        others_end: 0,
        slots: slots.as_ptr(),
        strides: [1_usize; 6].as_ptr(),
        rows: core::ptr::null(),
        links: core::ptr::null(),
        native: core::ptr::null(),
    };
    // SAFETY: the functions get what they ask for: places for two rows, of which there are more.
    let (made, went, other, bad) = unsafe {
        let made = table.create.unwrap()(&raw const *host, [2.0].as_ptr(), 1, &raw mut this);
        let went = table.apply.unwrap()(this, &raw const call);
        let strange = abi::Call { precision: 9, ..call };
        let other = table.apply.unwrap()(this, &raw const strange);
        table.destroy.unwrap()(this);
        _ = table.create.unwrap()(&raw const *host, [-2.0].as_ptr(), 1, &raw mut this);
        let bad = table.apply.unwrap()(this, &raw const call);
        table.destroy.unwrap()(this);
        (made, went, other, bad)
    };
    assert_eq!((made, went, other, bad), (0, 0, -1, -2));
    assert_eq!(force[0][..4], [0.0, 2.0, 2.0, 0.0]);
    let said = said.lock().unwrap();
    let words: Vec<&str> = said.iter().filter(|(level, _)| *level == 1).map(|(_, text)| text.as_str()).collect();
    assert_eq!(words, ["it was called with numbers of precision 9", "it panicked: not so"]);
}
