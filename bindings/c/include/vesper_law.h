/* Laws for Vesper that are compiled apart from it, in any language that C can be called from.
 *
 * A module is a shared library that exports one function, `vesper_module_v1`, which returns a table of laws. A program finds it by
 * name (`vesper run scene.toml --laws DIR`, or VESPER_LAW_PATH), checks what each law says it touches against its data, orders it
 * among the others, and calls it. What a law says and what it does have to agree: it is tried on rows of nobody's first, and refused
 * where it writes to what it says it reads, or to rows that it was not called for.
 *
 *     cc -O2 -shared -fPIC -I include -o laws/liblift.so lift.c
 *
 * Numbers are in the units that the law declares. A law may be called by several threads at once, for different rows, unless it has a
 * memory (`state_size`); what is global in a module is shared by all its laws in all engines, memory or not. A step has many calls, of
 * some rows each, and more than one of the same rows: a memory must not count them. A law must not keep a pointer of a call after it
 * returned. Modules are never unloaded.
 *
 * What breaks this interface gets another symbol; what is added stands at the end of a structure, which `struct_size` tells.
 */
#ifndef VESPER_LAW_H
#define VESPER_LAW_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define VESPER_EXPORT __declspec(dllexport)
#else
#define VESPER_EXPORT __attribute__((visibility("default")))
#endif

/* The version of these structures: `vesper_module.abi`. */
#define VESPER_LAW_ABI 1

/* What a law does to a property. */
enum {
    VESPER_READS = 1,    /* looks at it */
    VESPER_PREVIOUS = 2, /* looks at what it was in the evaluation before */
    VESPER_SETS = 3,     /* writes it, for every row; one law may */
    VESPER_ADDS = 4,     /* adds to it, `+=`; any number of laws may */
    VESPER_RATES = 5,    /* writes its rate of change, in its unit per second, for every row */
    VESPER_AMENDS = 6    /* corrects it after a step */
};

/* What a property is: components of a value. */
enum { VESPER_SCALAR = 1, VESPER_VECTOR = 3, VESPER_QUATERNION = 4 };

/* Where a law meets a property. */
enum {
    VESPER_OWN = 0,   /* on the law's own rows; of pairs, on both */
    VESPER_SCENE = 1, /* a constant of the scene: one value for all rows */
    VESPER_FIELD = 2, /* a function of place and time, at the row's position; for laws of rows */
    VESPER_END = 3    /* on the rows that a link leads to */
};

/* What a call of the law is of. */
enum {
    VESPER_ROWS = 1,   /* rows, each by itself */
    VESPER_PAIRS = 2,  /* what rows j add to rows i, i != j; it may only add */
    VESPER_LINKS = 3,  /* what links add to the rows that they lead to */
    VESPER_COLUMNS = 4 /* whole columns: an algorithm of the law's own */
};

/* Numbers that a law takes; what the program computes in otherwise is converted for each call. */
enum { VESPER_LAW_F32 = 1, VESPER_LAW_F64 = 2 };

/* What a property is to integrators: VESPER_AS_USUAL for properties that Vesper knows (position, velocity, force, ...). Of others, a
 * law that adds makes a sum, and what a law gives the rate of is a state. */
enum {
    VESPER_AS_USUAL = 0,
    VESPER_PLAIN = 1,
    VESPER_COORDINATE = 2,
    VESPER_MOMENTUM = 3, /* moves the coordinate `role_of` */
    VESPER_SUM = 4,      /* starts from `role_of` where the rows have it */
    VESPER_TURN = 5,     /* turns `role_by`, and adds to `role_of` by that */
    VESPER_SWITCH = 6    /* which case the law is in: integrators stop where its sign turns */
};

/* How much something matters that a law says. */
enum { VESPER_ERROR = 1, VESPER_WARNING = 2, VESPER_INFORMATION = 3, VESPER_DEBUGGING = 4, VESPER_TRACES = 5 };

/* A property that a law touches. Zeros mean: own rows, as usual, needed, no default, a rate that depends on all inputs. */
typedef struct vesper_port {
    const char *property; /* its name, as in scenes: "velocity" */
    const char *field;    /* what the law calls it, for messages; NULL: the same */
    const char *unit;     /* "m/s"; NULL: the SI unit of `si` */
    int8_t si[7];         /* exponents of m, kg, s, A, K, mol, cd */
    uint8_t kind;         /* VESPER_SCALAR, ... */
    uint8_t mode;         /* VESPER_READS, ... */
    uint8_t place;        /* VESPER_OWN, ... */
    uint8_t role;         /* VESPER_AS_USUAL, ... */
    uint8_t optional;     /* 1: the law runs without it; its pointers are NULL then */
    uint8_t has_default;  /* 1: a constant that the scene does not give is `default_value` */
    const char *role_of;
    const char *role_by;
    double default_value[3];
    uint64_t from; /* of a rate: bit k for port k, which it depends on; 0: on all. In a call for this rate alone the others are zeros */
} vesper_port;

/* A number of the law's own, or three. */
typedef struct vesper_parameter {
    const char *name;
    const char *doc;      /* may be NULL */
    const char *unit;     /* "kg/s"; NULL: none */
    uint32_t width;       /* 1 or 3 */
    uint32_t has_default; /* 0: it has to be given */
    double default_value[3];
} vesper_parameter;

/* The program, to a law. It lives as long as the law. */
typedef struct vesper_host {
    uint32_t struct_size;
    uint32_t abi;
    void *context;                                                  /* for `log` */
    void (*log)(void *context, uint32_t level, const char *text); /* the last VESPER_ERROR is told as the reason of a failure */
} vesper_host;

/* One call. Rows `begin` to before `end` are to be computed, and no others are to be written. */
typedef struct vesper_call {
    uint32_t struct_size;
    uint32_t precision; /* VESPER_LAW_F32: the slots are floats; VESPER_LAW_F64: doubles */
    size_t begin, end;
    size_t others_begin, others_end; /* of pairs, the rows j; of links, all links that there are */
    void *const *slots;    /* a pointer for each component of each port, in their order: to row 0; NULL where optional and absent */
    const size_t *strides; /* by slot, numbers from one row to the next: 1 for rows and pairs, 0 for constants */
    const size_t *rows;    /* by slot, how many rows; for laws of columns, else NULL */
    const uint32_t *links; /* the rows that link k leads to, from links[k * arity] on; else NULL */
    const void *native;    /* for laws of Vesper's own making */
} vesper_call;

/* A law: what it is, what it touches, and its functions, which return 0 where all went well. A law that returns anything else is
 * switched off and named, and all else goes on. */
typedef struct vesper_law {
    uint32_t struct_size;    /* sizeof(vesper_law) */
    uint32_t port_size;      /* sizeof(vesper_port) */
    uint32_t parameter_size; /* sizeof(vesper_parameter) */
    uint32_t shape;          /* VESPER_ROWS, ... */
    uint32_t precisions;     /* VESPER_LAW_F32, VESPER_LAW_F64 or both */
    uint32_t native;         /* 0 */
    const char *name;        /* small letters, digits and _ */
    const char *doc;         /* may be NULL */
    const char *domain;      /* NULL: the scene says, or the only one that fits */
    const char *link;        /* of a law of links, the property that it follows: "ends"; else NULL */
    uint32_t link_arity;     /* how many rows a link joins */
    uint32_t structure;      /* 0; 1 where the rate of each coordinate is its momentum */
    size_t port_count;
    const vesper_port *ports; /* inputs first */
    size_t parameter_count;
    const vesper_parameter *parameters;
    /* Makes a law from the components of its parameters, in their order; *self is what the others get. */
    int32_t (*create)(const vesper_host *host, const double *parameters, size_t count, void **self);
    int32_t (*apply)(void *self, const vesper_call *call);
    /* The energy of the call's rows, in J, of pairs j > i, each once; NULL where the law does not know it. Outputs are NULL or not to be
     * written. */
    int32_t (*energy)(void *self, const vesper_call *call, double *energy);
    void (*destroy)(void *self); /* may be NULL */
    /* The memory that decides what the law does next, for checkpoints; 0 and NULL where it has none. */
    size_t state_size;
    int32_t (*save)(void *self, void *to);
    int32_t (*load)(void *self, const void *from);
} vesper_law;

/* What a module exports. */
typedef struct vesper_module {
    uint32_t abi;         /* VESPER_LAW_ABI */
    uint32_t struct_size; /* sizeof(vesper_module) */
    const char *build;    /* who built it, for messages; may be NULL */
    size_t law_count;
    const vesper_law *const *laws;
} vesper_module;

/* The one symbol of a module. */
VESPER_EXPORT const vesper_module *vesper_module_v1(void);

#ifdef __cplusplus
}
#endif

#endif
