// Crossings: which pairs may have changed since the tick before, eight at a time.
#pragma once

#include "server/interest/interest_step.h"
#include "server/spatial/box_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::interest {

/// Squared distances at which a pair changes its level of detail, whatever the radii: the largest
/// floats whose roots lod_at() still counts as within.
struct LodSteps {
    static constexpr std::size_t kMost = 3;
    std::array<float, kMost> nearer{};   ///< a level is taken when it is reached
    std::array<float, kMost> farther{};  ///< a level that is held is lost beyond it
    std::size_t count = 0;

    LodSteps() = default;
    explicit LodSteps(const Settings& settings);
};

/// What a pair is (known or not, level of detail) follows from what it was and from which of the
/// comparisons `distance^2 <= radius^2`, `distance^2 <= ((1 + hysteresis) radius)^2` and
/// `distance^2 <= LOD step` hold; and to settle it twice changes nothing. So it can only change
/// when it comes within a plain radius (step) that it was beyond a tick ago, or gets beyond a
/// widened one that it was within: nothing else needs a second look. Here one side is a point that
/// is now at (x, z) with `radius_m`, and was at (old_x, old_z) with `old_radius_m`; the other sides
/// are eight points of a grid. Bit i of the answer is set where the pair may change. The arithmetic
/// is that of hears(): no pair is missed.
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

    [[gnu::always_inline]] std::uint32_t operator()(const Array8& xs,
                                                    const Array8& zs,
                                                    const Array8& old_xs,
                                                    const Array8& old_zs,
                                                    const Array8& radii) const {
        using spatial::lanes_at_most;
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
        std::uint32_t crossed =
            (lanes_at_most(now, r * r) & ~lanes_at_most(before, old_r * old_r)) |
            (lanes_at_most(before, old_wide * old_wide) & ~lanes_at_most(now, wide * wide));
        if (radius_m != old_radius_m) {
            // A radius of zero reaches nobody, not even at distance zero, where these comparisons
            // hold: a pair too many does no harm.
            crossed |= lanes_at_most(now, wide * wide);
        }
        for (std::size_t k = 0; k < lods->count; ++k) {
            const Array8 nearer = Array8::Constant(lods->nearer[k]);
            const Array8 farther = Array8::Constant(lods->farther[k]);
            crossed |= (lanes_at_most(now, nearer) & ~lanes_at_most(before, nearer)) |
                       (lanes_at_most(before, farther) & ~lanes_at_most(now, farther));
        }
        return crossed;
    }
};

}  // namespace zoned::interest
