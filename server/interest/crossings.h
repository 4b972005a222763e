// Crossings: which pairs may have changed since the tick before, eight at a time.
#pragma once

#include "server/interest/interest_step.h"
#include "server/spatial/box_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::interest {

/// Squared distances at which a pair changes its level of detail, whatever the radii: the largest
/// float whose root lod_at() still counts as within.
struct LodSteps {
    static constexpr std::size_t kMost = 6;
    std::array<float, kMost> squared{};
    std::size_t count = 0;

    LodSteps() = default;
    explicit LodSteps(const Settings& settings);
};

/// Everything about a pair (known or not, level of detail) is settled by what it was and by which
/// of the comparisons `distance^2 <= radius^2`, `distance^2 <= ((1 + hysteresis) radius)^2` and
/// `distance^2 <= LOD step` hold; and to settle it twice changes nothing. So a pair for which all
/// of them come out as a tick ago needs no second look. Here one side is a point that is now at
/// (x, z) with `radius_m`, and was at (old_x, old_z) with `old_radius_m`; the other sides are eight
/// points of a grid. Bit i of the answer is set where something came out otherwise. The arithmetic
/// is that of hears(): the answer is exact.
struct Crossings {
    float x = 0.0F;
    float z = 0.0F;
    float old_x = 0.0F;
    float old_z = 0.0F;
    float radius_m = 0.0F;  ///< >= 0
    float old_radius_m = 0.0F;
    float widen = 1.1F;  ///< 1 + hysteresis
    const LodSteps* lods = nullptr;

    using Array8 = spatial::Array8;

    std::uint32_t operator()(const Array8& xs,
                             const Array8& zs,
                             const Array8& old_xs,
                             const Array8& old_zs,
                             const Array8& radii) const {
        const Array8 dx = xs - x;
        const Array8 dz = zs - z;
        const Array8 old_dx = old_xs - old_x;
        const Array8 old_dz = old_zs - old_z;
        const Array8 now = dx * dx + dz * dz;
        const Array8 before = old_dx * old_dx + old_dz * old_dz;
        const Array8 r = radii.min(radius_m);
        const Array8 old_r = radii.min(old_radius_m);
        const Array8 wide = r * widen;
        const Array8 old_wide = old_r * widen;
        // A radius of zero reaches nobody: only where it is now, or was, can it be exact, and a
        // pair too many does no harm.
        std::uint32_t crossed =
            (spatial::lanes_at_most(now, r * r) ^ spatial::lanes_at_most(before, old_r * old_r)) |
            (spatial::lanes_at_most(now, wide * wide) ^
             spatial::lanes_at_most(before, old_wide * old_wide));
        if (radius_m != old_radius_m) {
            // At distance zero from a radius that was or becomes zero all comparisons hold.
            crossed |= spatial::lanes_at_most(now, wide * wide);
        }
        for (std::size_t k = 0; k < lods->count; ++k) {
            const Array8 step = Array8::Constant(lods->squared[k]);
            crossed |= spatial::lanes_at_most(now, step) ^ spatial::lanes_at_most(before, step);
        }
        return crossed;
    }
};

}  // namespace zoned::interest
