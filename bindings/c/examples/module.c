/* A law in C, compiled apart, in an engine that C runs: `module FOLDER`, where FOLDER has examples/modules/c/lift.c as liblift.so. */
#include "vesper.h"
#include <math.h>
#include <stdio.h>

int main(int count, char **words) {
    double position[3] = {0, 0, 1000}, velocity[3] = {25, 0, 0}, mass[1] = {250};
    vesper_builder builder;
    vesper_engine engine;
    if (count != 2) return puts("say in which folder liblift.so is"), 2;
    vesper_builder_new(VESPER_F64, &builder);
    vesper_builder_laws_from(builder, words[1]);
    vesper_builder_domain(builder, "gliders", 1);
    vesper_builder_lend(builder, "gliders", "position", VESPER_F64, position, 3);
    vesper_builder_column(builder, "gliders", "velocity", VESPER_F64, velocity, 3);
    vesper_builder_column(builder, "gliders", "mass", VESPER_F64, mass, 1);
    vesper_builder_law(builder, "motion", NULL);
    vesper_builder_law(builder, "lift", "module = 'lift', slope = 20");
    if (vesper_builder_build(builder, &engine)) return puts(vesper_last_error()), 1;
    if (vesper_engine_step(engine, 1000, 1e-3)) return puts(vesper_last_error()), 1;
    printf("after a second the glider is %.6f m high\n", position[2]);
    vesper_engine_free(engine);
    /* 20 kg/s times 25 m/s lift 250 kg by 2 m/s^2. */
    return fabs(position[2] - 1001) < 1e-9 ? 0 : 1;
}
