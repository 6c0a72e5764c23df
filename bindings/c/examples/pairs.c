/*
 * Pairs on a spring, seven cases: the bits of positions and velocities after ten seconds, in both precisions.
 * `cargo run --example pairs` prints the same lines from Rust.
 */
#include "vesper.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct pair {
    char name;
    double mass[2], velocity[6];
    double stiffness; /* 0 for no spring */
    int gravity;
} pair;

static const pair PAIRS[] = {
    {'a', {1, 1}, {0, 0, 0, 0, 0, 0}, 100, 0},      {'b', {1, 1}, {0, -10, 0, 0, 10, 0}, 100, 0},
    {'c', {1, 1}, {0, 0, 0, 0, 10, 0}, 100, 0},     {'d', {10, 1}, {0, 3, 0, 0, 0, 0}, 100, 0},
    {'e', {1, 1}, {10, 0, 30, -20, 0, 20}, 0, 1},   {'f', {1, 1}, {0, 0, 15, 0, 0, 15}, 100, 1},
    {'g', {1, 1}, {0, 0, 15, 0, 0, 15}, 30, 1},
};

static void check(vesper_status status) {
    if (status != VESPER_OK) {
        fprintf(stderr, "%s: %s\n", vesper_status_text(status), vesper_last_error());
        exit(1);
    }
}

static void print_bits(vesper_engine engine, const char *property, vesper_type type) {
    double doubles[6];
    float floats[6];
    uint64_t wide;
    uint32_t narrow;
    int k;
    check(vesper_engine_get(engine, "bodies", property, type, type == VESPER_F64 ? (void *)doubles : (void *)floats, 6));
    for (k = 0; k < 6; k++) {
        memcpy(&wide, &doubles[k], sizeof wide);
        memcpy(&narrow, &floats[k], sizeof narrow);
        if (type == VESPER_F64)
            printf(" %016llx", (unsigned long long)wide);
        else
            printf(" %08lx", (unsigned long)narrow);
    }
}

static void run(const pair *pair, vesper_type type) {
    static const double position[] = {-10, 5, 0, 10, 5, 0}, gravity[] = {0, 0, -9.81}, damping = 10, rest_length = 10;
    static const uint32_t ends[] = {0, 1};
    vesper_builder builder;
    vesper_engine engine;
    check(vesper_builder_new(type, &builder));
    vesper_builder_domain(builder, "bodies", 2);
    vesper_builder_column(builder, "bodies", "position", VESPER_F64, position, 6);
    vesper_builder_column(builder, "bodies", "velocity", VESPER_F64, pair->velocity, 6);
    vesper_builder_column(builder, "bodies", "mass", VESPER_F64, pair->mass, 2);
    vesper_builder_law(builder, "motion", NULL);
    if (pair->stiffness > 0) {
        vesper_builder_domain(builder, "springs", 1);
        vesper_builder_link(builder, "springs", "ends", "bodies", ends, 2);
        vesper_builder_column(builder, "springs", "stiffness", VESPER_F64, &pair->stiffness, 1);
        vesper_builder_column(builder, "springs", "damping", VESPER_F64, &damping, 1);
        vesper_builder_column(builder, "springs", "rest_length", VESPER_F64, &rest_length, 1);
        vesper_builder_law(builder, "spring", NULL);
        vesper_builder_law(builder, "damper", NULL);
    }
    if (pair->gravity) {
        vesper_builder_column(builder, "scene", "gravity", VESPER_F64, gravity, 3);
        vesper_builder_law(builder, "uniform_gravity", NULL);
    }
    vesper_builder_settings(builder, "integrator = 'runge_kutta_4', step = 1e-3");
    check(vesper_builder_build(builder, &engine));
    check(vesper_engine_advance(engine, 10.0));
    printf("%c %s", pair->name, type == VESPER_F64 ? "f64" : "f32");
    print_bits(engine, "position", type);
    print_bits(engine, "velocity", type);
    printf("\n");
    check(vesper_engine_free(engine));
}

int main(void) {
    size_t k;
    for (k = 0; k < sizeof PAIRS / sizeof *PAIRS; k++) {
        run(&PAIRS[k], VESPER_F64);
        run(&PAIRS[k], VESPER_F32);
    }
    return 0;
}
