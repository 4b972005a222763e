// Morton codes: an order of points in space in which neighbours mostly follow one another.
#pragma once

#include "shared/math/aabb.h"

#include <cstdint>

namespace zoned::spatial {

/// The lower ten bits with two zeros after each.
inline std::uint32_t spread_bits(std::uint32_t x) {
    x &= 0x3FFU;
    x = (x | (x << 16)) & 0x030000FFU;
    x = (x | (x << 8)) & 0x0300F00FU;
    x = (x | (x << 4)) & 0x030C30C3U;
    return (x | (x << 2)) & 0x09249249U;
}

/// 30 bits: the cell of a point in a box that is cut into 1024 along each axis, the axes' bits
/// interlaced (G. M. Morton, "A computer oriented geodetic data base", IBM 1966). Points outside
/// count as at its border, NaN as at its lower end.
inline std::uint32_t morton_code(const Vec3& point, const Aabb& box) {
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float size = box.upper[axis] - box.lower[axis];
        const float at = size > 0.0F ? (point[axis] - box.lower[axis]) * (1024.0F / size) : 0.0F;
        const float cell = at > 0.0F ? (at < 1023.0F ? at : 1023.0F) : 0.0F;
        code |= spread_bits(static_cast<std::uint32_t>(cell)) << axis;
    }
    return code;
}

}  // namespace zoned::spatial
