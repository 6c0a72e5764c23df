/*
 * What a step of two bodies costs from C, in ns: the least of many batches, for `step` and for `advance`.
 * `cargo run --release --example step_cost` does the same in Rust, and through this interface.
 */
#define _POSIX_C_SOURCE 199309L
#include "vesper.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define CALLS 2000
#define BATCHES 2000

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

int main(void) {
    static const double position[] = {0, 0, 0, 1, 0, 0}, velocity[] = {0, 0, 0, 0, 1, 0}, mass[] = {1, 1e-3};
    double best_step = 1e300, best_advance = 1e300;
    vesper_builder builder;
    vesper_engine engine;
    int batch, call;
    vesper_builder_new(VESPER_F64, &builder);
    vesper_builder_domain(builder, "bodies", 2);
    vesper_builder_column(builder, "bodies", "position", VESPER_F64, position, 6);
    vesper_builder_column(builder, "bodies", "velocity", VESPER_F64, velocity, 6);
    vesper_builder_column(builder, "bodies", "mass", VESPER_F64, mass, 2);
    vesper_builder_law(builder, "gravity", "g = 1");
    vesper_builder_law(builder, "motion", NULL);
    vesper_builder_settings(builder, "integrator = 'leapfrog', step = 0.0009765625");
    if (vesper_builder_build(builder, &engine) != VESPER_OK) {
        fprintf(stderr, "%s\n", vesper_last_error());
        return 1;
    }
    for (batch = 0; batch < BATCHES; batch++) {
        double start = now(), middle, end;
        vesper_status failed = 0;
        for (call = 0; call < CALLS; call++)
            failed |= vesper_engine_step(engine, 1, 0.0009765625);
        middle = now();
        for (call = 0; call < CALLS; call++)
            failed |= vesper_engine_advance(engine, 0.0009765625);
        end = now();
        if (failed)
            return 1;
        if (middle - start < best_step * CALLS)
            best_step = (middle - start) / CALLS;
        if (end - middle < best_advance * CALLS)
            best_advance = (end - middle) / CALLS;
    }
    printf("C: step %.1f ns, advance %.1f ns\n", best_step, best_advance);
    return vesper_engine_free(engine);
}
