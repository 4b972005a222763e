#include "shared/wire/snapshot/snapshot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::wire::snapshot {

namespace {

constexpr float kSqrt2 = std::numbers::sqrt2_v<float>;

float half_range(int orientation_bits) {
    return 0.5F * static_cast<float>((1 << orientation_bits) - 1);
}

std::array<float, 4> components(const Rotation& r) {
    return {r.w, r.x, r.y, r.z};
}

}  // namespace

Rotation rotation_of(const BodySample& sample, int orientation_bits) {
    const float half = half_range(orientation_bits);
    const float step = 1.0F / (half * kSqrt2);
    std::array<float, 3> small{};
    float rest = 1.0F;
    for (std::size_t i = 0; i < 3; ++i) {
        small[i] = (static_cast<float>(sample.orientation[i]) - half) * step;
        rest -= small[i] * small[i];
    }
    std::array<float, 4> all{};
    std::size_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        all[i] = i == sample.left_out ? std::sqrt(std::max(0.0F, rest)) : small[next++];
    }
    return {all[0], all[1], all[2], all[3]};
}

std::array<std::int16_t, 3> quantize_rotation(const Rotation& rotation,
                                              int left_out,
                                              int orientation_bits) {
    const float half = half_range(orientation_bits);
    const std::array<float, 4> all = components(rotation);
    const float sign = all[static_cast<std::size_t>(left_out)] < 0.0F ? -1.0F : 1.0F;
    std::array<std::int16_t, 3> out{};
    std::size_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i != static_cast<std::size_t>(left_out)) {
            const float steps = std::floor(sign * all[i] * kSqrt2 * half + half + 0.5F);
            out[next++] = static_cast<std::int16_t>(std::clamp(steps, 0.0F, 2.0F * half));
        }
    }
    return out;
}

int greatest_component(const Rotation& rotation) {
    const std::array<float, 4> all = components(rotation);
    std::size_t greatest = 0;
    for (std::size_t i = 1; i < 4; ++i) {
        if (std::abs(all[i]) > std::abs(all[greatest])) {
            greatest = i;
        }
    }
    return static_cast<int>(greatest);
}

float lead_of(const Rotation& rotation, int greatest) {
    const std::array<float, 4> all = components(rotation);
    float next = 0.0F;
    for (std::size_t i = 0; i < 4; ++i) {
        if (i != static_cast<std::size_t>(greatest)) {
            next = std::max(next, std::abs(all[i]));
        }
    }
    return std::abs(all[static_cast<std::size_t>(greatest)]) - next;
}

}  // namespace zoned::wire::snapshot
