// The headers in C++17, together and twice: every function is there with C's names, and a small program runs.
#include "vesper.h"
#include "vesper_law.h"
#include "vesper.h"
#include "vesper_law.h"
#include <array>
#include <string_view>
#include <type_traits>

static_assert(std::is_trivially_copyable_v<vesper_engine> && std::is_standard_layout_v<vesper_column>);
static_assert(sizeof(vesper_engine) == 8 && VESPER_LAW_F64 == 2 && VESPER_F64 == 2);

int main() {
    vesper_builder builder{};
    if (vesper_builder_new(VESPER_F32, &builder) != VESPER_OK) return 1;
    std::array<float, 3> position{0, 0, 1};
    vesper_builder_domain(builder, "bodies", 1);
    vesper_builder_lend(builder, "bodies", "positon", VESPER_F32, position.data(), position.size());
    vesper_builder_law(builder, "motion", nullptr);
    vesper_engine engine{};
    if (vesper_builder_build(builder, &engine) != VESPER_ERROR_FAULT || engine.id != 0) return 2;
    const std::string_view said{vesper_last_error()};
    return said.find("positon") == said.npos ? 3 : 0;
}
