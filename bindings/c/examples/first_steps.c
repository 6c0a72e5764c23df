/* Ten lines to the first step: the Moon goes round the Earth. Its position is the program's own array. */
#include "vesper.h"
#include <stdio.h>

int main(void) {
    double position[] = {0, 0, 0, 384400e3, 0, 0}, velocity[] = {0, -0.0124, 0, 0, 1.0183, 0};
    double mass[] = {5.972e24, 7.346e22};
    vesper_builder builder;
    vesper_engine engine;
    vesper_builder_new(VESPER_F64, &builder);
    vesper_builder_domain(builder, "bodies", 2);
    vesper_builder_lend(builder, "bodies", "position", VESPER_F64, position, 6); /* used in place */
    vesper_builder_column(builder, "bodies", "velocity [km/s]", VESPER_F64, velocity, 6); /* copied, converted */
    vesper_builder_column(builder, "bodies", "mass", VESPER_F64, mass, 2);
    vesper_builder_law(builder, "gravity", "softening = 1e3");
    vesper_builder_law(builder, "motion", NULL);
    if (vesper_builder_build(builder, &engine)) return puts(vesper_last_error()), 1;
    vesper_engine_step(engine, 3946, 600.0); /* steps of ten minutes; `position` holds the new places */
    printf("a month later the Moon is at (%.0f, %.0f, %.0f) m\n", position[3], position[4], position[5]);
    vesper_engine_free(engine);
    return 0;
}
