/* A law in C: lift, a force upwards, by the speed forwards. cc -O2 -shared -fPIC -I bindings/c/include -o laws/liblift.so lift.c */
#include "vesper_law.h"
#include <stdlib.h>

static int32_t create(const vesper_host *host, const double *parameters, size_t count, void **self) {
    double *slope = malloc(sizeof *slope);
    (void)host, (void)count;
    if (slope) *slope = parameters[0];
    *self = slope;
    return slope ? 0 : 1;
}

static int32_t apply(void *self, const vesper_call *call) {
    const double slope = *(double *)self, *speed = call->slots[0]; /* the x of the velocity; y and z are slots 1 and 2 */
    double *force = call->slots[5];                                /* the z of the force: its x is slot 3 */
    for (size_t row = call->begin; row < call->end; row++) force[row] += slope * speed[row];
    return 0;
}

static const vesper_port ports[] = {
    {.property = "velocity", .si = {1, 0, -1}, .kind = VESPER_VECTOR, .mode = VESPER_READS},
    {.property = "force", .si = {1, 1, -2}, .kind = VESPER_VECTOR, .mode = VESPER_ADDS},
};
static const vesper_parameter parameters[] = {{.name = "slope", .unit = "kg/s", .width = 1, .has_default = 1, .default_value = {0.1}}};
static const vesper_law lift = {
    .struct_size = sizeof lift, .port_size = sizeof *ports, .parameter_size = sizeof *parameters,
    .shape = VESPER_ROWS, .precisions = VESPER_LAW_F64, .name = "lift", .doc = "Lift of a wing, by the speed forwards.",
    .port_count = 2, .ports = ports, .parameter_count = 1, .parameters = parameters,
    .create = create, .apply = apply, .destroy = free,
};
static const vesper_law *const laws[] = {&lift};
static const vesper_module module = {VESPER_LAW_ABI, sizeof module, "lift.c", 1, laws};

const vesper_module *vesper_module_v1(void) { return &module; }
