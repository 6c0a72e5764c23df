/*
 * vesper.h: the C interface of Vesper, a framework for laws of physics.
 *
 * A builder takes domains (sets of rows), columns (a property of every row), laws and settings, and becomes an engine. The
 * engine takes steps, and between them shows and changes its columns. README.md beside this folder begins with ten lines.
 *
 * Names     A property is named as laws name it: "position", "velocity", "mass". A unit may stand behind it, "velocity [km/s]":
 *           numbers are converted when they are copied in or out. Without one numbers are in the property's own unit, an SI unit;
 *           so are those of columns in place.
 * Texts     UTF-8, ending with a NUL. Those given to a function are only looked at while it runs.
 * Arrays    Interleaved: all numbers of the first row, then those of the second. `count` is the number of numbers, not of rows
 *           and not of bytes, and is checked before anything is read. Arrays for results have numbers already (any), and share no
 *           memory with the column that they are of, unless they are that column.
 * Errors    Functions return a status; vesper_last_error tells the whole text. What goes wrong on a builder is kept, too, and
 *           vesper_builder_build fails with all of it: a program may look at that status alone. A call that fails changes
 *           nothing, but for steps, which stand where they broke; handles, views, times and texts that it would give are zero.
 * Handles   Plain numbers, 0 for none. One that was freed is an error and not a crash, also if its place is taken again.
 * Threads   A builder or engine belongs to the thread that made it. Another thread's call is VESPER_ERROR_THREAD, until the
 *           owner calls vesper_engine_let_go or ends; then the next thread that calls has it. Different engines run on
 *           different threads at once. An engine's own threads need no care, but for the log.
 *
 * Checked against the library's code by `cargo test -p vesper-c`.
 */
#ifndef VESPER_H
#define VESPER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header. It changes where a program that was built with another header would go wrong. */
#define VESPER_ABI_VERSION 1

/* What a call came to. */
typedef int32_t vesper_status;
enum {
    VESPER_OK = 0,             /* done */
    VESPER_ERROR_ARGUMENT = 1, /* a null pointer, an odd address, a code that there is not, text that is no UTF-8 */
    VESPER_ERROR_HANDLE = 2,   /* the handle is null, was freed, or never was one */
    VESPER_ERROR_THREAD = 3,   /* another thread has the handle, or a call on it is under way (from a callback) */
    VESPER_ERROR_FAULT = 4,    /* what was described or asked for does not fit: names, units, lengths, laws */
    VESPER_ERROR_RUN = 5,      /* a step could not be taken, or numbers became infinite or NaN */
    VESPER_ERROR_PANIC = 6,    /* a mistake inside the library; the handle can only be freed */
    VESPER_ERROR_LIMIT = 7     /* 65536 handles are in use */
};

/* The type of the numbers of an array. */
typedef uint32_t vesper_type;
enum {
    VESPER_F32 = 1, /* float */
    VESPER_F64 = 2, /* double */
    VESPER_U32 = 3  /* uint32_t: rows of a domain, counted from 0 */
};

/* What vesper_engine_column is for. */
enum {
    VESPER_READ = 0, /* to look at */
    VESPER_WRITE = 1 /* to change before the next call; laws and integrator follow */
};

/* What vesper_engine_text tells. */
enum {
    VESPER_REPORT = 0,    /* which laws run, which do not, and why; what nobody uses */
    VESPER_EXPLAIN = 1,   /* the order of the laws, merged loops, what moves where */
    VESPER_DOT = 2,       /* the graph of the laws in the language of Graphviz */
    VESPER_CHECKPOINT = 3 /* the complete state, for vesper_engine_restore: the same bits from there on */
};

/* How much is logged; each level with those above it. */
enum {
    VESPER_LOG_OFF = 0,
    VESPER_LOG_ERROR = 1,
    VESPER_LOG_WARN = 2, /* a law sleeps, since it lacks a property */
    VESPER_LOG_INFO = 3, /* a law woke; a column is used by nobody */
    VESPER_LOG_DEBUG = 4,
    VESPER_LOG_TRACE = 5
};

/* An engine that is being put together. Made by vesper_builder_new; freed by vesper_builder_build or vesper_builder_free. */
typedef struct vesper_builder {
    uint64_t id;
} vesper_builder;

/* An engine. Made by vesper_builder_build; freed by vesper_engine_free. */
typedef struct vesper_engine {
    uint64_t id;
} vesper_engine;

/*
 * Where the numbers of a column are: number c of value k is ((double *)column.component[c])[k * column.stride], or float, or
 * uint32_t, as `type` says. Vectors that the engine owns stand in an array for each component (stride 1); lent ones, and links,
 * stand one value behind the other (stride = width), at the address that was lent.
 */
typedef struct vesper_column {
    void *component[4];     /* where x, y, z, w begin; null beyond the width; more than 4 ends of a link follow the fourth */
    const uint32_t *subset; /* the rows that have a value, ascending; null where all rows have one */
    size_t rows;            /* how many values there are */
    size_t stride;          /* from one value to the next, in numbers */
    uint32_t width;         /* numbers in a value: 1, 3 or 4; for a link the rows that it leads to */
    vesper_type type;       /* VESPER_F32, VESPER_F64, or VESPER_U32 for a link */
} vesper_column;

/* Values of one property for new rows. */
typedef struct vesper_values {
    const char *property; /* its name, with a unit or without */
    const void *numbers;  /* row after row; for a link the rows that it leads to */
    size_t count;         /* how many numbers: new rows times width */
    vesper_type type;     /* VESPER_F32 or VESPER_F64; VESPER_U32 for a link */
} vesper_values;

/* A function of the client that is given what is logged. It may be called on any thread that calls the library, and on an engine's
 * own threads by laws of modules, on several at once. It must not throw, and calls no function on handles. The text is the
 * library's, and is there until the function returns. */
typedef void (*vesper_log_callback)(uint32_t level, const char *text, void *user);

/* ---- General: from any thread ---------------------------------------------------------------------------------------------- */

/* The version of the library; compare it with VESPER_ABI_VERSION before anything else. */
uint32_t vesper_abi_version(void);

/* A status in a few words. Static text. */
const char *vesper_status_text(vesper_status status);

/* The whole text of this thread's last failure, a line or a few for each fault; empty if there was none. The library's, until
 * the next failure on this thread. */
const char *vesper_last_error(void);

/* Hands what is logged up to `level` to `callback`, with `user` as it is given here; a null callback for nobody. For the whole
 * program: the last call counts. A callback may still be running on another thread when this returns. */
vesper_status vesper_set_log(vesper_log_callback callback, void *user, uint32_t level);

/* ---- Builder --------------------------------------------------------------------------------------------------------------- */

/* Begins an engine that computes in VESPER_F32 or VESPER_F64. */
vesper_status vesper_builder_new(vesper_type precision, vesper_builder *builder);

/* Adds a domain of so many rows (at most 4294967295). Columns, and laws and settings that name it, come after it. The domain
 * "scene", of one row, is always there: its columns are the constants ("gravity", "speed_of_light"). */
vesper_status vesper_builder_domain(vesper_builder builder, const char *domain, size_t rows);

/* Adds a column and copies its numbers, in VESPER_F32 or VESPER_F64 whatever the engine computes in. `count` is rows times the
 * width of the property: 1 for a number, 3 for a vector, 4 for a quaternion. A name that no law knows is a property of its own,
 * which is kept and goes with its rows. */
vesper_status vesper_builder_column(vesper_builder builder, const char *domain, const char *property, vesper_type type,
                                    const void *values, size_t count);

/* Adds a column in memory of the caller: no number is ever copied. The type is that of the engine, aligned as the type is, in the
 * property's own unit; no two columns, of one engine or of several, share memory. It stays where it is until the engine is freed. The caller reads and
 * writes it whenever no function runs on this engine; what was written is seen by the next step. Domains with lent columns
 * cannot change their number of rows. */
vesper_status vesper_builder_lend(vesper_builder builder, const char *domain, const char *property, vesper_type type,
                                  void *values, size_t count);

/* Adds a link: for every row as many rows of the domain `target` as the property says ("ends": 2, "corners": 3). Copied. */
vesper_status vesper_builder_link(vesper_builder builder, const char *domain, const char *property, const char *target,
                                  const uint32_t *rows, size_t count);

/* Looks for modules of laws (vesper_law.h) in this folder, too, before those of the environment variable VESPER_LAW_PATH. Say it before
 * the laws. The code of a module runs in this process. */
vesper_status vesper_builder_laws_from(vesper_builder builder, const char *folder);

/* Adds a stock law (`vesper laws` lists them), or one of a module of laws. `parameters` is null, or what stands behind the name in
 * a scene: "softening = 1e3", "g = 1, domain = 'stars', label = 'pull', every = 2", "module = 'wings'". Modules are found by their
 * names. */
vesper_status vesper_builder_law(vesper_builder builder, const char *law, const char *parameters);

/* Chooses what section [engine] of a scene chooses: "step = 1e-3, threads = 2, strict = true, observe = ['bodies.force']",
 * "integrator = { name = 'dormand_prince_8', rtol = 1e-10 }". Leapfrog where no integrator is chosen. */
vesper_status vesper_builder_settings(vesper_builder builder, const char *settings);

/* Adds a whole scene: its domains, constants, fields, laws and settings. Files that it names lie in `folder`; null for the
 * current one. Its precision, where it says one, is that of the builder. */
vesper_status vesper_builder_scene(vesper_builder builder, const char *scene, const char *folder);

/* Checks everything, orders the laws, and makes the engine. Fails with all that went wrong on the builder, and with laws that
 * sleep by a slip of the pen. The builder is freed in any case, unless another thread has it. */
vesper_status vesper_builder_build(vesper_builder builder, vesper_engine *engine);

/* Frees a builder that is not to be built. */
vesper_status vesper_builder_free(vesper_builder builder);

/* ---- Engine ---------------------------------------------------------------------------------------------------------------- */

/* Takes `count` steps of `step` s. After the first one no memory is taken, but for what wakes further threads. */
vesper_status vesper_engine_step(vesper_engine engine, uint64_t count, double step);

/* Goes on by `frame` s: by as many steps of the set length as fit, and the rest is carried to the next frame; without a set
 * step, by one step. */
vesper_status vesper_engine_advance(vesper_engine engine, double frame);

/* The time, in s, and the steps taken; null for what is not asked. */
vesper_status vesper_engine_time(vesper_engine engine, double *time, uint64_t *steps);

/* Where the numbers of a column are: given ones, links, and what is observed. The pointers are the engine's (or the caller's
 * own, where lent). They stay good until rows, laws or observers change, a law fails, a checkpoint is gone on from or the engine is
 * freed; with a graphics processor until the next step. To change numbers ask with VESPER_WRITE, each time, and write finite ones. With `moving_origin` positions are
 * from the origin that moves; vesper_engine_get gives them from where coordinates begin. */
vesper_status vesper_engine_column(vesper_engine engine, const char *domain, const char *property, uint32_t access,
                                   vesper_column *column);

/* Copies all numbers of a column to the caller, in VESPER_F32 or VESPER_F64 (VESPER_U32 for a link), interleaved; in the unit behind
 * its name. */
vesper_status vesper_engine_get(vesper_engine engine, const char *domain, const char *property, vesper_type type, void *values,
                                size_t count);

/* Changes all numbers of a column, also of a constant (domain "scene"), or the time. Numbers are finite, or none is changed. */
vesper_status vesper_engine_set(vesper_engine engine, const char *domain, const char *property, vesper_type type,
                                const void *values, size_t count);

/* Adds `rows` rows behind the last. Every property that all rows have needs values for the new ones. */
vesper_status vesper_engine_add_rows(vesper_engine engine, const char *domain, size_t rows, const vesper_values *columns,
                                     size_t count);

/* Removes rows, and with them rows that link to them. Later rows move up, and links follow. */
vesper_status vesper_engine_remove_rows(vesper_engine engine, const char *domain, const uint32_t *rows, size_t count);

/* Switches a law on (1) or off (0), by its label, or else its name. */
vesper_status vesper_engine_enable(vesper_engine engine, const char *law, int32_t enabled);

/* Looks at a property that laws compute ("force") from now on: it is computed at once, and after each step or frame. */
vesper_status vesper_engine_observe(vesper_engine engine, const char *domain, const char *property);

/* Tells VESPER_REPORT, VESPER_EXPLAIN, VESPER_DOT or VESPER_CHECKPOINT. The text is the engine's, until the next call of this
 * function for it, or until it is freed. */
vesper_status vesper_engine_text(vesper_engine engine, uint32_t which, const char **text);

/* Goes on from a checkpoint of an engine that was put together alike; rows may differ. Lent memory is written, columns of the engine's
 * own move. */
vesper_status vesper_engine_restore(vesper_engine engine, const char *checkpoint);

/* Lets the next thread that calls have the engine. */
vesper_status vesper_engine_let_go(vesper_engine engine);

/* Frees an engine. Lent memory is the caller's alone from then on. */
vesper_status vesper_engine_free(vesper_engine engine);

#ifdef __cplusplus
}
#endif

#endif
