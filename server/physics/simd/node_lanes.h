// Node lanes: converts rows of four numbers for eight nodes to lanes and back.
#pragma once

#include "server/physics/simd/lanes.h"

#include <cstring>

namespace zoned::physics::soft {

/// x, y, z and one more, as one register.
using Row4 = Eigen::Vector4f;

struct NodeLanes {
    Lanes x, y, z, w;
};

using Half = float __attribute__((vector_size(16)));
using NodeIndices = std::array<std::uint32_t, kLanes>;

[[gnu::always_inline]] inline Lanes pair_of(const Row4* rows, std::uint32_t a, std::uint32_t b) {
    Half low;
    Half high;
    std::memcpy(&low, rows + a, sizeof(low));
    std::memcpy(&high, rows + b, sizeof(high));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Nodes 0..3 in the low halves and 4..7 in the high ones are transposed by themselves.
[[gnu::always_inline]] inline NodeLanes load_nodes(const Row4* rows, const NodeIndices& i) {
    const Lanes a = pair_of(rows, i[0], i[4]);
    const Lanes b = pair_of(rows, i[1], i[5]);
    const Lanes c = pair_of(rows, i[2], i[6]);
    const Lanes d = pair_of(rows, i[3], i[7]);
    const Lanes ab_low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes ab_high = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes cd_low = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes cd_high = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
    return {__builtin_shufflevector(ab_low, cd_low, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab_low, cd_low, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(ab_high, cd_high, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab_high, cd_high, 2, 3, 10, 11, 6, 7, 14, 15)};
}

[[gnu::always_inline]] inline void store_pair(Row4* rows,
                                              std::uint32_t a,
                                              std::uint32_t b,
                                              const Lanes& both) {
    const Half low = __builtin_shufflevector(both, both, 0, 1, 2, 3);
    const Half high = __builtin_shufflevector(both, both, 4, 5, 6, 7);
    std::memcpy(static_cast<void*>(rows + a), &low, sizeof(low));
    std::memcpy(static_cast<void*>(rows + b), &high, sizeof(high));
}

[[gnu::always_inline]] inline void store_nodes(Row4* rows,
                                               const NodeIndices& i,
                                               const NodeLanes& n) {
    const Lanes xy_low = __builtin_shufflevector(n.x, n.y, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes xy_high = __builtin_shufflevector(n.x, n.y, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes zw_low = __builtin_shufflevector(n.z, n.w, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes zw_high = __builtin_shufflevector(n.z, n.w, 2, 10, 3, 11, 6, 14, 7, 15);
    store_pair(rows, i[0], i[4], __builtin_shufflevector(xy_low, zw_low, 0, 1, 8, 9, 4, 5, 12, 13));
    store_pair(
        rows, i[1], i[5], __builtin_shufflevector(xy_low, zw_low, 2, 3, 10, 11, 6, 7, 14, 15));
    store_pair(
        rows, i[2], i[6], __builtin_shufflevector(xy_high, zw_high, 0, 1, 8, 9, 4, 5, 12, 13));
    store_pair(
        rows, i[3], i[7], __builtin_shufflevector(xy_high, zw_high, 2, 3, 10, 11, 6, 7, 14, 15));
}

}  // namespace zoned::physics::soft
