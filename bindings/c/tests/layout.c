/*
 * Sizes, offsets and codes as C has them: what is wrong does not compile. `tests/all/header.rs` reads the same lines and holds
 * them against Rust.
 */
#include "vesper.h"
#include "vesper_law.h"

/* C99 has no static assertion: an array of -1 elements is an error. */
#define HOLDS(what, name) typedef char name##_holds[(what) ? 1 : -1]
#define SIZE(type, bytes) HOLDS(sizeof(type) == (bytes), size_of_##type)
#define OFFSET(type, field, bytes) HOLDS(offsetof(type, field) == (bytes), offset_of_##type##_##field)

SIZE(vesper_builder, 8);
SIZE(vesper_engine, 8);
SIZE(vesper_column, 64);
OFFSET(vesper_column, component, 0);
OFFSET(vesper_column, subset, 32);
OFFSET(vesper_column, rows, 40);
OFFSET(vesper_column, stride, 48);
OFFSET(vesper_column, width, 56);
OFFSET(vesper_column, type, 60);
SIZE(vesper_values, 32);
OFFSET(vesper_values, property, 0);
OFFSET(vesper_values, numbers, 8);
OFFSET(vesper_values, count, 16);
OFFSET(vesper_values, type, 24);

int main(void) {
    return vesper_abi_version() != VESPER_ABI_VERSION;
}
