// ThresholdCrossings: finds the pairs that may have changed since the last tick, eight at a time.
#pragma once

#include "server/interest/interest_rule.h"
#include "server/spatial/box_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::interest {

/// Squared distances at which a pair changes its level of detail, whatever the radii: the largest
/// floats whose roots lod_at() still counts as within.
struct LodThresholds {
    static constexpr std::size_t kMost = 3;
    std::array<float, kMost> nearer{};    ///< a level is taken when it is reached
    std::array<float, kMost> farther{};   ///< a level that is held is lost beyond it
    std::array<float, kMost> nearer_m{};  ///< their roots
    std::array<float, kMost> farther_m{};
    std::size_t count = 0;

    LodThresholds() = default;
    explicit LodThresholds(const InterestSettings& settings);
};

/// The state of a pair (known or not, level of detail) follows from its last state and three kinds
/// of comparison: `distance^2 <= radius^2`, `distance^2 <= ((1 + hysteresis) radius)^2` and
/// `distance^2 <= LOD step`. To settle it twice changes nothing. So it can only change when the
/// distance falls within a plain radius (step), or rises beyond a widened one, since the last tick.
/// No other pair needs a second look.
///
/// Here one side is a point that is now at (x, z) with `radius_m`, and was at (old_x, old_z) with
/// `old_radius_m`. The other sides are eight points that stay. Where both sides of a pair move, one
/// steps first and then the other: any change of the pair is a change in one of the two steps. Bit
/// i of the answer is set where the pair may change. The arithmetic is that of hears(), so no pair
/// is missed.
struct ThresholdCrossings {
    float x = 0.0F;
    float z = 0.0F;
    float old_x = 0.0F;
    float old_z = 0.0F;
    float radius_m = 0.0F;  ///< >= 0
    float old_radius_m = 0.0F;
    float widen = 1.1F;  ///< 1 + hysteresis
    const LodThresholds* lods = nullptr;

    [[gnu::always_inline]] std::uint32_t operator()(const Array8& xs,
                                                    const Array8& zs,
                                                    const Array8& radii) const {
        return crossed(xs, zs, radii.min(radius_m), radii.min(old_radius_m));
    }

    /// Where no other radius is smaller than both of `radius_m` and `old_radius_m`.
    [[gnu::always_inline]] std::uint32_t flat(const Array8& xs, const Array8& zs) const {
        return crossed(xs, zs, radius_m, old_radius_m);
    }

  private:
    [[gnu::always_inline]] std::uint32_t crossed(const Array8& xs,
                                                 const Array8& zs,
                                                 const Array8& r,
                                                 const Array8& old_r) const {
        using spatial::lanes_at_most;
        const Array8 dx = xs - x;
        const Array8 dz = zs - z;
        const Array8 old_dx = xs - old_x;
        const Array8 old_dz = zs - old_z;
        const Array8 now = dx * dx + dz * dz;
        const Array8 before = old_dx * old_dx + old_dz * old_dz;
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
            const Array8 nearer = lods->nearer[k];
            const Array8 farther = lods->farther[k];
            crossed |= (lanes_at_most(now, nearer) & ~lanes_at_most(before, nearer)) |
                       (lanes_at_most(before, farther) & ~lanes_at_most(now, farther));
        }
        return crossed;
    }
};

/// The same for one pair, whichever of the two moved, by the squares of their distance (m2) now and
/// a tick ago and the radius that holds between them.
inline bool crossed(float now,
                    float before,
                    float radius_m,
                    float widen,
                    const LodThresholds& lods) {
    const float plain = radius_m * radius_m;
    const float wide = radius_m * widen * (radius_m * widen);
    bool any = (now <= plain && !(before <= plain)) || (before <= wide && !(now <= wide));
    for (std::size_t k = 0; k < lods.count; ++k) {
        any = any || (now <= lods.nearer[k] && !(before <= lods.nearer[k])) ||
              (before <= lods.farther[k] && !(now <= lods.farther[k]));
    }
    return any;
}

/// The same eight at a time, where the point and its other sides may all have moved: these were at
/// (old_xs, old_zs). Exactly what crossed() says of each.
struct MutualCrossings {
    float x = 0.0F;
    float z = 0.0F;
    float old_x = 0.0F;
    float old_z = 0.0F;
    float radius_m = 0.0F;  ///< >= 0
    float widen = 1.1F;     ///< 1 + hysteresis
    const LodThresholds* lods = nullptr;
    const float* old_xs = nullptr;  ///< eight
    const float* old_zs = nullptr;

    [[gnu::always_inline]] std::uint32_t operator()(const Array8& xs,
                                                    const Array8& zs,
                                                    const Array8& radii) const {
        return crossed(xs, zs, radii.min(radius_m));
    }

    /// Where no other radius is smaller than `radius_m`.
    [[gnu::always_inline]] std::uint32_t flat(const Array8& xs, const Array8& zs) const {
        return crossed(xs, zs, radius_m);
    }

  private:
    [[gnu::always_inline]] std::uint32_t crossed(const Array8& xs,
                                                 const Array8& zs,
                                                 const Array8& r) const {
        const Array8 dx = xs - x;
        const Array8 dz = zs - z;
        const Array8 old_dx = Array8::load(old_xs) - old_x;
        const Array8 old_dz = Array8::load(old_zs) - old_z;
        const Array8 now = dx * dx + dz * dz;
        const Array8 before = old_dx * old_dx + old_dz * old_dz;
        const Array8 wide = r * widen;
        std::uint32_t mask = came(now, before, r * r) | came(before, now, wide * wide);
        for (std::size_t k = 0; k < lods->count; ++k) {
            mask |= came(now, before, lods->nearer[k]) | came(before, now, lods->farther[k]);
        }
        return mask;
    }

    /// Within a step that it was beyond.
    [[gnu::always_inline]] static std::uint32_t came(const Array8& now,
                                                     const Array8& before,
                                                     const Array8& step) {
        return spatial::lanes_at_most(now, step) & ~spatial::lanes_at_most(before, step);
    }
};

/// The same for a point whose other sides have moved as well, by their present places alone. A pair
/// may change if its distance is so near a step that the two can have crossed it with `reach_m` in
/// all. Some named pairs did not cross: a tick ago they were on the same side.
class NearThresholds {
  public:
    /// The point is at (x, z), hears up to `radius_m`; `reach_m`, m, is at least what it and any
    /// other moved together.
    NearThresholds(float x,
                   float z,
                   float radius_m,
                   float widen,
                   float reach_m,
                   const LodThresholds& lods)
        : x_(x),
          z_(z),
          radius_m_(radius_m),
          widen_(widen),
          reach_m_(reach_m) {
        add(radius_m * radius_m, radius_m);
        add(radius_m * widen * radius_m * widen, radius_m * widen);
        for (std::size_t k = 0; k < lods.count; ++k) {
            add(lods.nearer[k], lods.nearer_m[k]);
            add(lods.farther[k], lods.farther_m[k]);
        }
    }

    [[gnu::always_inline]] std::uint32_t operator()(const Array8& xs,
                                                    const Array8& zs,
                                                    const Array8& radii) const {
        const Array8 now = squared(xs, zs);
        const Array8 r = radii.min(radius_m_);
        const Array8 wide = r * widen_;
        const Array8 slack = slack_[1];
        const Array8 off = ((now - r * r).abs() - slack).min((now - wide * wide).abs() - slack);
        return spatial::lanes_at_most(off.min(nearest_from(2, now)), 0.0F);
    }

    [[gnu::always_inline]] std::uint32_t flat(const Array8& xs, const Array8& zs) const {
        return spatial::lanes_at_most(nearest_from(0, squared(xs, zs)), 0.0F);
    }

  private:
    /// Squares of distances that differ by `reach_m` on two sides of a step differ by less than the
    /// slack from the step's. The second term is for roundings, 2^-24 in each of five operations.
    void add(float square, float step) {
        const float far = step + reach_m_;
        square_[count_] = square;
        slack_[count_++] = 1.001F * reach_m_ * (step + far) + 4e-6F * far * far;
    }

    [[gnu::always_inline]] Array8 squared(const Array8& xs, const Array8& zs) const {
        const Array8 dx = xs - x_;
        const Array8 dz = zs - z_;
        return dx * dx + dz * dz;
    }

    [[gnu::always_inline]] Array8 nearest_from(std::size_t first, const Array8& now) const {
        Array8 nearest = 1.0F;
        if (first == 0) {
            nearest = (now - square_[0]).abs() - slack_[0];
            nearest = nearest.min((now - square_[1]).abs() - slack_[1]);
        }
        for (std::size_t k = 2; k < count_; ++k) {
            nearest = nearest.min((now - square_[k]).abs() - slack_[k]);
        }
        return nearest;
    }

    float x_;
    float z_;
    float radius_m_;
    float widen_;
    float reach_m_;
    std::array<float, 2 + 2 * LodThresholds::kMost> square_{};
    std::array<float, 2 + 2 * LodThresholds::kMost> slack_{};
    std::size_t count_ = 0;
};

}  // namespace zoned::interest
