#include "shared/wire/snapshot/turn.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::wire::snapshot {

namespace {

constexpr float kHalfPi = std::numbers::pi_v<float> / 2.0F;

/// Sum of terms[i] x^i.
template <std::size_t N>
float polynomial(const std::array<float, N>& terms, float x) {
    float sum = terms[N - 1];
    for (std::size_t i = N - 1; i-- > 0;) {
        sum = sum * x + terms[i];
    }
    return sum;
}

// Taylor's series in the square of the argument, as long as a float can tell.

/// asin(s) / s, for s up to 1/8 ...
constexpr std::array<float, 4> kArcOfSmall = {1.0F, 1.0F / 6.0F, 3.0F / 40.0F, 5.0F / 112.0F};
/// ... and up to 1/2.
constexpr std::array<float, 10> kArc = {1.0F,
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
constexpr std::array<float, 4> kSineOfSmall = {1.0F, -1.0F / 6.0F, 1.0F / 120.0F, -1.0F / 5040.0F};
constexpr std::array<float, 4> kCosineOfSmall = {1.0F, -1.0F / 2.0F, 1.0F / 24.0F, -1.0F / 720.0F};
/// ... and up to pi/2.
constexpr std::array<float, 6> kSine =
    {1.0F, -1.0F / 6.0F, 1.0F / 120.0F, -1.0F / 5040.0F, 1.0F / 362880.0F, -1.0F / 39916800.0F};
constexpr std::array<float, 7> kCosine = {1.0F,
                                          -1.0F / 2.0F,
                                          1.0F / 24.0F,
                                          -1.0F / 720.0F,
                                          1.0F / 40320.0F,
                                          -1.0F / 3628800.0F,
                                          1.0F / 479001600.0F};

float arc_over_sine(float square) {
    return square <= 1.0F / 64.0F ? polynomial(kArcOfSmall, square) : polynomial(kArc, square);
}

}  // namespace

Rotation operator*(const Rotation& a, const Rotation& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Rotation conjugate(const Rotation& r) {
    return {r.w, -r.x, -r.y, -r.z};
}

Turn turn_between(const Rotation& from, const Rotation& to) {
    const Rotation r = to * conjugate(from);
    const float sign = r.w < 0.0F ? -1.0F : 1.0F;
    const float w = sign * r.w;
    const float square = r.x * r.x + r.y * r.y + r.z * r.z;
    // Half the angle from its sine where that is small, else from its cosine.
    float factor = 0.0F;
    if (square <= 0.25F) {
        factor = arc_over_sine(square);
    } else if (w * w <= 0.25F) {
        factor = (kHalfPi - w * arc_over_sine(w * w)) / std::sqrt(square);
    } else {
        // asin(s) = pi / 2 - 2 asin(sqrt((1 - s) / 2)).
        const float sine = std::sqrt(std::min(square, 1.0F));
        const float rest = 0.5F * (1.0F - sine);
        factor = (kHalfPi - 2.0F * std::sqrt(rest) * arc_over_sine(rest)) / sine;
    }
    factor *= 2.0F * sign;
    return {factor * r.x, factor * r.y, factor * r.z};
}

Rotation turned(const Rotation& from, const Turn& turn) {
    constexpr float kLongest = kHalfPi * kHalfPi;
    const float square = 0.25F * (turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    if (!std::isfinite(square)) {
        return from;
    }
    const float scale = square <= kLongest ? 0.5F : 0.5F * std::sqrt(kLongest / square);
    const float half_square = std::min(square, kLongest);
    const bool small = half_square <= 1.0F / 16.0F;
    const float vector =
        scale * (small ? polynomial(kSineOfSmall, half_square) : polynomial(kSine, half_square));
    const float cosine =
        small ? polynomial(kCosineOfSmall, half_square) : polynomial(kCosine, half_square);
    return Rotation{cosine, vector * turn[0], vector * turn[1], vector * turn[2]} * from;
}

}  // namespace zoned::wire::snapshot
