#include "server/ai/pathfinding/flow_fields/next_hops.h"

#include "shared/core/assert.h"

namespace zoned::ai::pathfinding {

std::size_t NextHops::add(const GridMap& map, const FlowField& field) {
    ZONED_ASSERT(map.width() == width_ && map.height() == height_, "the map of these tables");
    const std::size_t begin = hops_.size();
    hops_.resize(begin + bytes_per_goal(), 0);
    std::size_t at = 0;
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x, ++at) {
            const Hop hop = field.hop(
                map.place({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)}));
            hops_[begin + at / 2] |= static_cast<std::uint8_t>(hop << (at % 2 * 4));
        }
    }
    return begin / bytes_per_goal();
}

}  // namespace zoned::ai::pathfinding
