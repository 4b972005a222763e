#include "tests/bench/grid_scene.h"

#include "tests/bench/file_text.h"
#include "tests/bench/public_data.h"

#include <utility>

namespace zoned::bench {

std::optional<GridScene> read_grid_scene(const std::string& name,
                                         std::size_t step,
                                         std::string& why) {
    std::string file = data_directory() + "/movingai/" + name + ".map";
    std::string map_text = text_of_file(file);
    if (map_text.empty()) {
        // Two small maps come with the tests.
        const std::string ours = ZONED_SOURCE_DIR "/tests/conformance/movingai/" + name + ".map";
        map_text = text_of_file(ours);
        file = map_text.empty() ? file : ours;
    }
    if (map_text.empty()) {
        why = file + " is not there: no rows of it";
        return std::nullopt;
    }
    auto map = scenario::parse_grid_map(map_text);
    if (!map) {
        why = file + ", " + map.error() + ": no rows of it";
        return std::nullopt;
    }
    const auto all = scenario::parse_grid_scenario(text_of_file(file + ".scen"));
    if (!all) {
        why = file + ".scen, " + all.error() + ": no rows of it";
        return std::nullopt;
    }
    GridScene scene{name, std::move(*map), {}};
    for (std::size_t i = 0; i < all->size(); i += step) {
        scene.instances.push_back((*all)[i]);
    }
    return scene;
}

}  // namespace zoned::bench
