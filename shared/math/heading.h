// Headings: yaws in units of the wire, 65536 to the turn about +y, and unit vectors in (x, z). Yaw
// 0 looks along +z.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/math/types.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace zoned {

/// The unit vector in (x, z) of a body that faces `yaw`.
inline Vec2 heading_of(std::uint16_t yaw) {
    const double turn = static_cast<std::int16_t>(yaw) * (std::numbers::pi / 32768.0);
    const auto [sine, cosine] = elementary::sincos(turn);
    return {static_cast<float>(sine), static_cast<float>(cosine)};
}

/// The yaw of a direction in (x, z) that is not 0.
inline std::uint16_t yaw_of(const Vec2& direction) {
    const float turns =
        elementary::atan2(direction.x(), direction.y()) / (2.0F * std::numbers::pi_v<float>);
    return static_cast<std::uint16_t>(std::lround(turns * 65536.0F) & 0xFFFF);
}

}  // namespace zoned
