// Fuzzing of instances of the travelling salesman problem: any text is refused with a line, or
// gives distances on which ants find a tour.
#include "server/ai/ants/max_min.h"
#include "server/ai/ants/tsp_text.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <string_view>

namespace zoned::fuzz {

std::vector<Bytes> seeds() {
    const std::string_view texts[] = {
        "NAME : t\nTYPE : TSP\nCOMMENT : three\nDIMENSION : 3\nEDGE_WEIGHT_TYPE : EUC_2D\n"
        "NODE_COORD_SECTION\n1 0 0\n2 3.0e+00 4\n3 -1.5 2\nEOF\n",
        "DIMENSION: 5\r\nEDGE_WEIGHT_TYPE: CEIL_2D\r\nNODE_COORD_SECTION\r\n5 0 0\r\n1 1 1\r\n2 1 "
        "1\r\n3 9 9\r\n4 2 7\r\n"};
    std::vector<Bytes> all;
    for (const std::string_view text : texts) {
        all.emplace_back(text.begin(), text.end());
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned::ai::pathfinding;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto instance = parse_tsp(text);
    if (!instance) {
        ZONED_ASSERT(instance.error().starts_with("line "), "a refusal names the line");
        return 0;
    }
    if (instance->distances.size() <= 40) {
        MaxMin ants(instance->distances, {});
        ants.run(50);
        ZONED_ASSERT(instance->distances.length_of(ants.best()) == ants.best_length(),
                     "the tour is as long as it says");
    }
    return 0;
}
