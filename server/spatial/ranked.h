// Ranked: children of a tree on a stack in order of distance, the nearest on top.
#pragma once

#include "server/spatial/box_lanes.h"

#include <cstddef>
#include <cstdint>

namespace zoned::spatial {

/// A child and how far away it is, in m or m2 as the search counts.
struct Ranked {
    float distance;
    std::uint32_t child;
};

/// Adds the children in the mask to `list` behind `count`, farthest first. Returns the new count.
template <class Children>
std::size_t push_ranked(std::uint32_t mask,
                        const Array8& distance,
                        const Children& children,
                        Ranked* list,
                        std::size_t count) {
    const std::size_t first = count;
    for_each_lane(mask, [&](std::size_t lane) {
        const Ranked entry{distance[static_cast<Eigen::Index>(lane)], children[lane]};
        std::size_t i = count++;
        for (; i > first && list[i - 1].distance < entry.distance; --i) {
            list[i] = list[i - 1];
        }
        list[i] = entry;
    });
    return count;
}

}  // namespace zoned::spatial
