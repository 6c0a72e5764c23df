/* Ten lines to the first step: the Moon goes round the Earth. Its position is the program's own array. */
#include "vesper.h"
#include <stdio.h>

int main(void) {
    double position[] = {0, 0, 0, 384400e3, 0, 0}, velocity[] = {0, -12.4, 0, 0, 1018.3, 0};
    double mass[] = {5.972e24, 7.346e22};
    vesper_builder builder;
    vesper_engine engine;
    vesper_builder_new(VESPER_F64, &builder);
    vesper_builder_domain(builder, "bodies", 2);
    vesper_builder_lend(builder, "bodies", "position", VESPER_F64, position, 6);
    vesper_builder_column(builder, "bodies", "velocity", VESPER_F64, velocity, 6);
    vesper_builder_column(builder, "bodies", "mass", VESPER_F64, mass, 2);
    vesper_builder_law(builder, "gravity", NULL);
    vesper_builder_law(builder, "motion", NULL);
    if (vesper_builder_build(builder, &engine) != VESPER_OK ||
        vesper_engine_step(engine, 3946, 600.0) != VESPER_OK) {
        fprintf(stderr, "%s\n", vesper_last_error());
        return 1;
    }
    printf("a month later the Moon is at (%.0f, %.0f, %.0f) m\n", position[3], position[4], position[5]);
    return vesper_engine_free(engine);
}
