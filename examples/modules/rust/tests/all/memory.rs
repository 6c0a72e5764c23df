//! A law with a memory of its own: it is in checkpoints, and calls do not meet in it.

use super::compiler::opened;
use vesper::prelude::*;

/// A force that grows with every call, in a law that counts them.
const TIRED: &str = r#"
#include "vesper_law.h"
#include <stdlib.h>
#include <string.h>
typedef struct { double calls; } memory;
static int32_t create(const vesper_host *host, const double *p, size_t n, void **self) { (void)host, (void)p, (void)n; *self = calloc(1, sizeof(memory)); return *self ? 0 : 1; }
static int32_t apply(void *self, const vesper_call *call) {
    memory *m = self;
    double *force = call->slots[EXTRA 5];
    m->calls += 1;
    for (size_t i = call->begin; i < call->end; i++) force[i] += m->calls;
    return 0;
}
static int32_t save(void *self, void *to) { memcpy(to, self, sizeof(memory)); return 0; }
static int32_t load(void *self, const void *from) { memcpy(self, from, sizeof(memory)); return 0; }
static const vesper_port ports[] = {{.property = "velocity", .si = {1, 0, -1}, .kind = 3, .mode = VESPER_READS}, MORE
    {.property = "force", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS}};
static const vesper_law tired = {.struct_size = sizeof tired, .port_size = sizeof *ports, .parameter_size = sizeof(vesper_parameter),
    .shape = VESPER_ROWS, .precisions = VESPER_LAW_F64, .name = "tired", .port_count = sizeof ports / sizeof *ports, .ports = ports,
    .create = create, .apply = apply, .destroy = free, .state_size = sizeof(memory), .save = save, .load = load};
static const vesper_law *const laws[] = {&tired};
static const vesper_module module = {VESPER_LAW_ABI, sizeof module, 0, 1, laws};
const vesper_module *vesper_module_v1(void) { return &module; }
"#;

fn engine(name: &str, source: &str) -> Engine<f64> {
    let tired = opened(name, source).unwrap().law("tired").unwrap();
    let bodies = Domain::new("bodies").with(Position, [[0.0; 3]; 2]).with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0; 2]);
    Engine::builder().domain(bodies).law(vesper_laws::Motion).law(tired).step(0.1).build().unwrap()
}

fn plain() -> String {
    TIRED.replace("EXTRA ", "").replace("MORE", "")
}

#[test]
fn what_a_law_remembers_is_in_checkpoints() {
    let bits = |engine: &Engine<f64>| engine.state().get("bodies", Position, 1).unwrap().z.to_bits();
    let mut first = engine("tired", &plain());
    first.advance(0.5).unwrap();
    let saved = first.checkpoint().unwrap();
    assert_eq!(saved.laws.iter().filter(|law| law.memory.len() == 8).count(), 1);
    first.advance(0.5).unwrap();
    let mut second = engine("tired", &plain());
    second.advance(0.2).unwrap();
    second.restore(&saved).unwrap();
    second.advance(0.5).unwrap();
    assert_eq!(bits(&first), bits(&second));
    // Two engines have a law each.
    let mut third = engine("tired", &plain());
    third.advance(1.0).unwrap();
    assert_eq!(bits(&first), bits(&third));
}

#[test]
fn a_law_that_says_something_else_now_is_refused_with_the_difference() {
    let mut old = engine("tired", &plain());
    old.advance(0.5).unwrap();
    let saved = old.checkpoint().unwrap();
    let more = "{.property = \"mass\", .si = {0, 1}, .kind = 1, .mode = VESPER_READS},";
    let mut new = engine("tired_and_heavy", &TIRED.replace("EXTRA 5", "6").replace("MORE", more));
    let refused = new.restore(&saved).unwrap_err().to_string();
    assert_eq!(
        refused,
        "the checkpoint does not fit: law tired has changed (- then, + now):\n  + reads mass: scalar [kg], without a role"
    );
}
