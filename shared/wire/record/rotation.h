// Rotations: quantised orientations as quaternions and as turns between them. Inline: a codec asks
// for a dozen of them per body.
#pragma once

#include "shared/wire/quantize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace zoned::wire::record {

/// A unit quaternion.
struct Rotation {
    float w = 1.0F;
    float x = 0.0F;
    float y = 0.0F;
    float z = 0.0F;
};

/// Axis times angle, rad, at most pi long.
using Turn = std::array<float, 3>;

namespace detail {

inline constexpr float kSqrt2 = std::numbers::sqrt2_v<float>;

inline std::array<float, 4> components(const Rotation& r) {
    return {r.w, r.x, r.y, r.z};
}

inline constexpr float kHalfPi = std::numbers::pi_v<float> / 2.0F;

/// Sum of terms[i] x^i.
template <std::size_t N>
float polynomial(const std::array<float, N>& terms, float x) {
    float sum = terms[N - 1];
    for (std::size_t i = N - 1; i-- > 0;) {
        sum = sum * x + terms[i];
    }
    return sum;
}

// Taylor's series in the square of the argument, to the precision of a float.

/// asin(s) / s, for s up to 1/8 ...
inline constexpr std::array<float, 4> kArcOfSmall = {1.0F,
                                                     1.0F / 6.0F,
                                                     3.0F / 40.0F,
                                                     5.0F / 112.0F};
/// ... and up to 1/2.
inline constexpr std::array<float, 10> kArc = {1.0F,
                                               1.0F / 6.0F,
                                               3.0F / 40.0F,
                                               5.0F / 112.0F,
                                               35.0F / 1152.0F,
                                               63.0F / 2816.0F,
                                               231.0F / 13312.0F,
                                               143.0F / 10240.0F,
                                               6435.0F / 557056.0F,
                                               12155.0F / 1245184.0F};
/// sin(x) / x and cos(x), for x up to 1/4 ...
inline constexpr std::array<float, 4> kSineOfSmall = {1.0F,
                                                      -1.0F / 6.0F,
                                                      1.0F / 120.0F,
                                                      -1.0F / 5040.0F};
inline constexpr std::array<float, 4> kCosineOfSmall = {1.0F,
                                                        -1.0F / 2.0F,
                                                        1.0F / 24.0F,
                                                        -1.0F / 720.0F};
/// ... and up to pi/2.
inline constexpr std::array<float, 6> kSine =
    {1.0F, -1.0F / 6.0F, 1.0F / 120.0F, -1.0F / 5040.0F, 1.0F / 362880.0F, -1.0F / 39916800.0F};
inline constexpr std::array<float, 7> kCosine = {1.0F,
                                                 -1.0F / 2.0F,
                                                 1.0F / 24.0F,
                                                 -1.0F / 720.0F,
                                                 1.0F / 40320.0F,
                                                 -1.0F / 3628800.0F,
                                                 1.0F / 479001600.0F};

inline float arc_over_sine(float square) {
    return square <= 1.0F / 64.0F ? polynomial(kArcOfSmall, square) : polynomial(kArc, square);
}

}  // namespace detail

/// Of a state that turns freely. `limit` is QuantizationLimits::orientation: components of
/// -limit..limit stand for -1 / sqrt 2 .. 1 / sqrt 2.
inline Rotation rotation_of(const QuantizedState& state, std::int32_t limit) {
    const float unit = 1.0F / (static_cast<float>(limit) * detail::kSqrt2);
    std::array<float, 4> all{};
    float rest = 1.0F;
    std::size_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (static_cast<std::int32_t>(i) != state.orientation_largest) {
            all[i] = static_cast<float>(state.orientation[next++]) * unit;
            rest -= all[i] * all[i];
        }
    }
    all[static_cast<std::size_t>(state.orientation_largest)] = std::sqrt(std::max(0.0F, rest));
    return {all[0], all[1], all[2], all[3]};
}

/// The smallest three of a rotation, in steps, where component `left_out` is.
inline std::array<std::int32_t, 3> smallest_three(const Rotation& rotation,
                                                  int left_out,
                                                  std::int32_t limit) {
    const std::array<float, 4> all = detail::components(rotation);
    const float sign = all[static_cast<std::size_t>(left_out)] < 0.0F ? -1.0F : 1.0F;
    const auto most = static_cast<float>(limit);
    std::array<std::int32_t, 3> out{};
    std::size_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (static_cast<int>(i) != left_out) {
            const float whole = std::floor(sign * all[i] * detail::kSqrt2 * most + 0.5F);
            out[next++] = static_cast<std::int32_t>(std::clamp(whole, -most, most));
        }
    }
    return out;
}

/// The component of the greatest magnitude, the first of those if several are.
inline int greatest_component(const Rotation& rotation) {
    const std::array<float, 4> all = detail::components(rotation);
    std::size_t greatest = 0;
    for (std::size_t i = 1; i < 4; ++i) {
        if (std::abs(all[i]) > std::abs(all[greatest])) {
            greatest = i;
        }
    }
    return static_cast<int>(greatest);
}

/// By how much component `greatest` exceeds the others in magnitude.
inline float lead_of(const Rotation& rotation, int greatest) {
    const std::array<float, 4> all = detail::components(rotation);
    float next = 0.0F;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i != static_cast<std::size_t>(greatest)) {
            next = std::max(next, std::abs(all[i]));
        }
    }
    return std::abs(all[static_cast<std::size_t>(greatest)]) - next;
}

/// a after b.
inline Rotation operator*(const Rotation& a, const Rotation& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

inline Rotation conjugate(const Rotation& r) {
    return {r.w, -r.x, -r.y, -r.z};
}

/// The shorter turn from one orientation to another, to 1e-6 rad. Sums, products, quotients and
/// roots alone: libraries differ in the last bit of sine and arc.
inline Turn turn_between(const Rotation& from, const Rotation& to) {
    const Rotation r = to * conjugate(from);
    const float sign = r.w < 0.0F ? -1.0F : 1.0F;
    const float w = sign * r.w;
    const float square = r.x * r.x + r.y * r.y + r.z * r.z;
    // Half the angle from its sine where that is small, else from its cosine.
    float factor = 0.0F;
    if (square <= 0.25F) {
        factor = detail::arc_over_sine(square);
    } else if (w * w <= 0.25F) {
        factor = (detail::kHalfPi - w * detail::arc_over_sine(w * w)) / std::sqrt(square);
    } else {
        // asin(s) = pi / 2 - 2 asin(sqrt((1 - s) / 2)).
        const float sine = std::sqrt(std::min(square, 1.0F));
        const float rest = 0.5F * (1.0F - sine);
        factor = (detail::kHalfPi - 2.0F * std::sqrt(rest) * detail::arc_over_sine(rest)) / sine;
    }
    factor *= 2.0F * sign;
    return {factor * r.x, factor * r.y, factor * r.z};
}

/// The orientation after a turn from another, to 1e-6; turns of more than pi count as pi, those
/// that no float holds the square of as none.
inline Rotation turned(const Rotation& from, const Turn& turn) {
    constexpr float kLongest = detail::kHalfPi * detail::kHalfPi;
    const float square = 0.25F * (turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    if (!std::isfinite(square)) {
        return from;
    }
    const float scale = square <= kLongest ? 0.5F : 0.5F * std::sqrt(kLongest / square);
    const float half_square = std::min(square, kLongest);
    const bool small = half_square <= 1.0F / 16.0F;
    const float vector = scale * (small ? detail::polynomial(detail::kSineOfSmall, half_square)
                                        : detail::polynomial(detail::kSine, half_square));
    const float cosine = small ? detail::polynomial(detail::kCosineOfSmall, half_square)
                               : detail::polynomial(detail::kCosine, half_square);
    return Rotation{cosine, vector * turn[0], vector * turn[1], vector * turn[2]} * from;
}

}  // namespace zoned::wire::record
