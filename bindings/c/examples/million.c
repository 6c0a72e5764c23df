/*
 * A million bodies in memory of the program: the engine has the same pointers, and takes no memory in its steps.
 *
 * Linked with `-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign` it counts who asks for memory.
 */
#include "vesper.h"
#include <stdio.h>
#include <stdlib.h>

#define ROWS 1000000

static float position[3 * ROWS], velocity[3 * ROWS], mass[ROWS];

#ifdef COUNT_MEMORY
static unsigned long asked;
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
int __real_posix_memalign(void **memory, size_t align, size_t size);
void *__wrap_malloc(size_t size) { return __sync_fetch_and_add(&asked, 1), __real_malloc(size); }
void *__wrap_calloc(size_t count, size_t size) { return __sync_fetch_and_add(&asked, 1), __real_calloc(count, size); }
void *__wrap_realloc(void *memory, size_t size) { return __sync_fetch_and_add(&asked, 1), __real_realloc(memory, size); }
int __wrap_posix_memalign(void **memory, size_t align, size_t size) {
    return __sync_fetch_and_add(&asked, 1), __real_posix_memalign(memory, align, size);
}
#else
static unsigned long asked = 0;
#endif

static void check(vesper_status status) {
    if (status != VESPER_OK) {
        fprintf(stderr, "%s: %s\n", vesper_status_text(status), vesper_last_error());
        exit(1);
    }
}

int main(void) {
    const double gravity[] = {0, 0, -8}; /* a power of two, so that every position is exact */
    vesper_builder builder;
    vesper_engine engine;
    vesper_column column;
    unsigned long before, in_build;
    size_t k, wrong = 0;
    for (k = 0; k < ROWS; k++) {
        position[3 * k] = (float)k;
        velocity[3 * k + 2] = 4;
        mass[k] = 1;
    }
    before = asked;
    check(vesper_builder_new(VESPER_F32, &builder));
    vesper_builder_domain(builder, "bodies", ROWS);
    vesper_builder_lend(builder, "bodies", "position", VESPER_F32, position, 3 * ROWS);
    vesper_builder_lend(builder, "bodies", "velocity", VESPER_F32, velocity, 3 * ROWS);
    vesper_builder_lend(builder, "bodies", "mass", VESPER_F32, mass, ROWS);
    vesper_builder_column(builder, "scene", "gravity", VESPER_F64, gravity, 3);
    vesper_builder_law(builder, "uniform_gravity", NULL);
    vesper_builder_law(builder, "motion", NULL);
    vesper_builder_settings(builder, "integrator = 'leapfrog', threads = 1");
    check(vesper_builder_build(builder, &engine));
    check(vesper_engine_step(engine, 1, 0.0625));
    in_build = asked - before;
    (void)in_build;
    before = asked;
    check(vesper_engine_step(engine, 15, 0.0625));
#ifdef COUNT_MEMORY
    printf("asked for memory: %lu times to build, %lu times in 15 steps of a million rows\n", in_build, asked - before);
    wrong += in_build == 0;
#endif
    wrong += asked != before;
    check(vesper_engine_column(engine, "bodies", "position", VESPER_READ, &column));
    wrong += column.component[0] != (void *)position || column.stride != 3 || column.rows != ROWS;
    check(vesper_engine_column(engine, "bodies", "mass", VESPER_READ, &column));
    wrong += column.component[0] != (void *)mass || column.stride != 1;
    for (k = 0; k < ROWS; k++) /* after 1 s: 4 t - 4 t^2 = 0, and the velocity is turned round */
        wrong += position[3 * k] != (float)k || position[3 * k + 2] != 0 || velocity[3 * k + 2] != -4;
    printf("%lu things wrong\n", (unsigned long)wrong);
    check(vesper_engine_free(engine));
    return wrong != 0;
}
