// Circle: sine, cosine and headings with the same bits on every machine.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/math/types.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace zoned::ai::learning {

/// Sine and cosine by their series, for |angle| <= 0.8: within 1e-12. The series end with angle^13
/// and angle^12; the next terms are below 0.8^15 / 15! and 0.8^14 / 14! < 1e-12.
inline std::array<double, 2> sine_and_cosine(double angle) {
    const double s = angle * angle;
    double sine = 1.0;
    for (const double next : {156.0, 110.0, 72.0, 42.0, 20.0, 6.0}) {
        sine = 1.0 - s / next * sine;
    }
    double cosine = 1.0;
    for (const double next : {132.0, 90.0, 56.0, 30.0, 12.0, 2.0}) {
        cosine = 1.0 - s / next * cosine;
    }
    return {angle * sine, cosine};
}

/// The unit vector in (x, z) of a body that faces `yaw`: 65536 = one turn about +y, 0 looks along
/// +z.
inline Vec2 heading_of(std::uint16_t yaw) {
    // Split into the nearest quarter turn and the rest, at most an eighth.
    const unsigned quarter = ((yaw + 8192U) >> 14U) & 3U;
    const auto left = static_cast<std::int16_t>(yaw - (quarter << 14U));
    const auto [sine, cosine] =
        sine_and_cosine(static_cast<double>(left) * (std::numbers::pi / 32768.0));
    const auto s = static_cast<float>(sine);
    const auto c = static_cast<float>(cosine);
    switch (quarter) {
        case 0:
            return {s, c};
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        default:
            return {-c, s};
    }
}

/// The yaw of a direction in (x, z) that is not 0. The arc tangent is the C library's.
inline std::uint16_t yaw_of(const Vec2& direction) {
    const float turns =
        elementary::atan2(direction.x(), direction.y()) / (2.0F * std::numbers::pi_v<float>);
    return static_cast<std::uint16_t>(std::lround(turns * 65536.0F) & 0xFFFF);
}

}  // namespace zoned::ai::learning
