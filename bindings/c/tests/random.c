/*
 * A million calls at random: null, wrong sizes, freed handles, odd addresses, wrong order. Built with the sanitizers for
 * addresses and undefined behaviour; and without, when the memory that it takes may not grow. `tests/all/random.rs` makes fewer
 * calls from Rust.
 */
#define _XOPEN_SOURCE 600
#include "vesper.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#define KEPT 12
#define NUMBERS 64
#define COUNT(list) (sizeof(list) / sizeof *(list))

/* xorshift64*, the same on every run. */
static uint64_t chance_state = 42;

static uint64_t chance(uint64_t below) {
    chance_state ^= chance_state >> 12;
    chance_state ^= chance_state << 25;
    chance_state ^= chance_state >> 27;
    return (chance_state * UINT64_C(0x2545F4914F6CDD1D) >> 16) % below;
}

static const char *const DOMAINS[] = {"bodies", "bodies", "springs", "scene", "bodis", "\xff\xfe", NULL};
static const char *const PROPERTIES[] = {"position",    "velocity", "mass",    "ends",   "stiffness",       "rest_length",
                                         "force",       "gravity",  "time",    "colour", "velocity [km/s]", "position [s]",
                                         "mass [",      "",         NULL};
static const char *const LAWS[] = {"gravity", "motion", "spring", "uniform_gravity", "drag", "nothing", "\xff", NULL};
static const char *const PARAMETERS[] = {"", "", "g = 1", "softening = 'x'", "every = 2", "} ] }", "label = 'a'", NULL};
static const char *const SETTINGS[] = {
    "step = 0.001, threads = 1", "integrator = 'runge_kutta_4'", "integrator = 'implicit_midpoint'",
    "observe = ['bodies.force']", "step = -1", "= =", NULL};
static const char *const SCENES[] = {
    "[domains.bodies]\nposition = [[0,0,1]]\nvelocity = [[0,0,1]]\nmass = [1]\n[[laws]]\nname = 'motion'\n",
    "[domains.bodies]\nposition = [[0,0]]\n", "[", NULL};
/* What is read has room for 64 numbers; more are refused before anything is read. */
static const size_t COUNTS[] = {0, 1, 2, 3, 4, 6, 8, 9, 12, NUMBERS, SIZE_MAX / 2, SIZE_MAX};
static const size_t ROWS[] = {0, 1, 2, 2, 3, 4, (size_t)UINT32_MAX + 1, SIZE_MAX};
static const vesper_type TYPES[] = {VESPER_F64, VESPER_F64, VESPER_F64, VESPER_F32, VESPER_F32, VESPER_U32, 0, 99};

static vesper_builder builders[KEPT];
static vesper_engine engines[KEPT];
static double *arrays[16]; /* memory of the heap, so that a look beyond its end is found */
static unsigned long done[8], calls;

#define ANY(list) ((list)[chance(COUNT(list))])

static void check(vesper_status status) {
    if (status != VESPER_OK) {
        fprintf(stderr, "%s: %s\n", vesper_status_text(status), vesper_last_error());
        exit(1);
    }
}

/* Puts a new handle in the place of an old one, which is freed, or was. */
static void keep_builder(vesper_builder builder) {
    size_t place = chance(KEPT);
    if (builder.id == 0)
        return;
    vesper_builder_free(builders[place]);
    builders[place] = builder;
}

static void keep_engine(vesper_engine engine) {
    size_t place = chance(KEPT);
    if (engine.id == 0)
        return;
    vesper_engine_free(engines[place]);
    engines[place] = engine;
}

/* A builder from which an engine can come. */
static vesper_builder right_builder(void) {
    static const double position[] = {0, 0, 0, 1, 0, 0}, velocity[6], mass[] = {1, 2};
    vesper_builder builder;
    check(vesper_builder_new(chance(2) ? VESPER_F64 : VESPER_F32, &builder));
    check(vesper_builder_domain(builder, "bodies", 2));
    check(vesper_builder_column(builder, "bodies", "position", VESPER_F64, position, 6));
    check(vesper_builder_column(builder, "bodies", "velocity", VESPER_F64, velocity, 6));
    check(vesper_builder_column(builder, "bodies", "mass", VESPER_F64, mass, 2));
    check(vesper_builder_law(builder, "motion", NULL));
    if (chance(2))
        check(vesper_builder_law(builder, "gravity", "g = 1"));
    if (chance(2))
        check(vesper_builder_settings(builder, "step = 0.001, threads = 1"));
    return builder;
}

/* A state that an engine told. */
static char checkpoint[100000];

/* The most memory that the program has taken so far, in kB. */
static long memory(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_maxrss : 0;
}

static vesper_status call(void) {
    const double times[] = {1e-3, 1e-3, 0.5, 0, -1, NAN, INFINITY, 1e300};
    const char *domain = ANY(DOMAINS), *property = ANY(PROPERTIES), *law = ANY(LAWS), *parameters = ANY(PARAMETERS);
    const char *text = NULL;
    vesper_type type = ANY(TYPES);
    size_t count = ANY(COUNTS), rows = ANY(ROWS);
    void *array = chance(40) ? ANY(arrays) : NULL;
    void *odd = array ? (char *)array + rows % 2 : NULL;
    double time = ANY(times);
    vesper_builder builder = ANY(builders), new_builder = {0};
    vesper_engine engine = ANY(engines), new_engine = {0};
    vesper_column column;
    vesper_values values[3];
    vesper_status status;
    int null = chance(50) == 0;
    if (chance(60) == 0)
        builder.id = engine.id = chance(UINT64_MAX);
    switch (chance(27)) {
    case 0:
        status = vesper_builder_new(type, null ? NULL : &new_builder);
        keep_builder(new_builder);
        return status;
    case 1:
        return vesper_builder_domain(builder, domain, rows);
    case 2:
    case 3:
        return vesper_builder_column(builder, domain, property, type, array, count);
    case 4:
        return vesper_builder_lend(builder, domain, property, type, odd, count);
    case 5:
        return vesper_builder_link(builder, domain, property, domain, array, count);
    case 6:
        return vesper_builder_law(builder, law, parameters);
    case 7:
        return vesper_builder_settings(builder, ANY(SETTINGS));
    case 8:
        return vesper_builder_scene(builder, ANY(SCENES), NULL);
    case 9:
    case 10:
        status = vesper_builder_build(builder, null ? NULL : &new_engine);
        keep_engine(new_engine);
        return status;
    case 11:
        return vesper_builder_free(builder);
    case 12:
    case 13:
        return vesper_engine_step(engine, chance(4), time);
    case 14:
        return vesper_engine_advance(engine, time);
    case 15:
        return vesper_engine_time(engine, array, NULL);
    case 16:
        status = vesper_engine_column(engine, domain, property, (uint32_t)(count % 3), &column);
        if (status == VESPER_OK && column.rows > 0 && column.component[0] != NULL) {
            /* The last value, of the heap of the library or of this program. */
            char *start = column.component[0];
            size_t size = column.type == VESPER_F64 ? 8 : 4;
            volatile char last = start[(column.rows - 1) * column.stride * size + size - 1];
            (void)last;
        }
        return status;
    case 17:
        return vesper_engine_get(engine, domain, property, type, array, count);
    case 18:
        return vesper_engine_set(engine, domain, property, type, array, count);
    case 19:
        for (count = 0; count < 3; count++) {
            values[count].property = PROPERTIES[count];
            values[count].numbers = array;
            values[count].count = count == 2 ? rows : rows * 3;
            values[count].type = type;
        }
        return vesper_engine_add_rows(engine, domain, rows, null ? NULL : values, 3);
    case 20:
        return vesper_engine_remove_rows(engine, domain, array, count < NUMBERS ? count : NUMBERS);
    case 21:
        return vesper_engine_enable(engine, law, (int32_t)(rows % 2));
    case 22:
        return vesper_engine_observe(engine, domain, property);
    case 23:
        status = vesper_engine_text(engine, (uint32_t)(count % 5), null ? NULL : &text);
        if (status == VESPER_OK && strlen(text) >= sizeof checkpoint)
            exit(1);
        if (status == VESPER_OK && count % 5 == VESPER_CHECKPOINT)
            strcpy(checkpoint, text);
        return status;
    case 24:
        return vesper_engine_restore(engine, null ? parameters : checkpoint);
    case 25:
        return vesper_engine_let_go(engine);
    default:
        return vesper_engine_free(engine);
    }
}

int main(int arguments, char **argument) {
    static const double odd_numbers[] = {0, 1, 2, -0.5, 1e300, 0, 3, 1e-300};
    unsigned long turns = arguments > 1 ? strtoul(argument[1], NULL, 10) : 1000000;
    long early = 0;
    size_t k, j;
    for (k = 0; k < COUNT(arrays); k++) {
        arrays[k] = malloc(NUMBERS * sizeof(double));
        for (j = 0; j < NUMBERS; j++)
            arrays[k][j] = k < 8 ? 0.5 : (j + k) % 8 == 5 ? NAN : odd_numbers[(j + k) % 8];
    }
    for (calls = 0; calls < turns; calls++) {
        vesper_status status;
        if (calls == turns / 5)
            early = memory();
        if (calls % 10 == 0) {
            vesper_engine engine;
            check(vesper_builder_build(right_builder(), &engine));
            keep_engine(engine);
            keep_builder(right_builder());
        }
        status = call();
        if (status < 0 || status > 7 || status == VESPER_ERROR_PANIC || (status && !*vesper_last_error())) {
            fprintf(stderr, "call %lu: status %d: %s\n", calls, (int)status, vesper_last_error());
            return 1;
        }
        done[status]++;
    }
    for (k = 0; k < KEPT; k++) {
        vesper_builder_free(builders[k]);
        vesper_engine_free(engines[k]);
    }
    for (k = 0; k < COUNT(arrays); k++)
        free(arrays[k]);
    printf("%lu calls at random: %lu done, %lu refused for an argument, %lu for a handle, %lu for a fault, %lu for a step\n", calls,
           done[0], done[1], done[2], done[4], done[5]);
#ifndef __SANITIZE_ADDRESS__ /* which keeps what was freed */
    printf("%ld kB after a fifth of them, %ld kB in the end\n", early, memory());
    if (memory() > early + early / 10)
        return 1;
#endif
    return early == 0;
}
