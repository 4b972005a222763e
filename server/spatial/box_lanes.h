// BoxLanes: eight boxes side by side, tested against a box, a ray or a point all at once.
#pragma once

#include "shared/math/aabb.h"
#include "shared/math/array8.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace zoned::spatial {

inline constexpr std::size_t kLanes = 8;

/// A box that moves along `direction` (unit length) from where it lies about `origin`; half extents
/// of zero make it a ray.
struct Sweep {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitX();
    Vec3 half_extents = Vec3::Zero();
};

/// Half the surface of a box, m2: the cost of a node grows with it.
inline float half_area(const Aabb& box) {
    const Vec3 d = box.upper - box.lower;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

inline Aabb merged(const Aabb& a, const Aabb& b) {
    return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

/// Squared distance of a point to a box, zero inside, m2.
inline float squared_distance(const Aabb& box, const Vec3& point) {
    const Vec3 off = (box.lower - point).cwiseMax(point - box.upper).cwiseMax(0.0F);
    return off.squaredNorm();
}

/// Bit i is set where a[i] <= b[i]; a lane that is not a number is never set. The loop
/// in its place costs twice the whole test of a node.
inline std::uint32_t lanes_at_most(const Array8& a, const Array8& b) {
#if defined(__AVX__)
    return static_cast<std::uint32_t>(_mm256_movemask_ps(
        _mm256_cmp_ps(_mm256_loadu_ps(a.data()), _mm256_loadu_ps(b.data()), _CMP_LE_OQ)));
#elif defined(__SSE2__)
    const int low = _mm_movemask_ps(_mm_cmple_ps(_mm_loadu_ps(a.data()), _mm_loadu_ps(b.data())));
    const int high =
        _mm_movemask_ps(_mm_cmple_ps(_mm_loadu_ps(a.data() + 4), _mm_loadu_ps(b.data() + 4)));
    return static_cast<std::uint32_t>(low | (high << 4));
#else
    std::uint32_t mask = 0;
    for (int i = 0; i < 8; ++i) {
        mask |= (a[i] <= b[i] ? 1U : 0U) << i;
    }
    return mask;
#endif
}

/// A sweep made ready for the test of many boxes.
struct SweepLanes {
    explicit SweepLanes(const Sweep& sweep) : origin(sweep.origin), half(sweep.half_extents) {
        for (int i = 0; i < 3; ++i) {
            const float d = sweep.direction[i];
            const auto axis = static_cast<std::size_t>(i);
            // A direction of (nearly) zero gets a slope that is huge and finite: zero times
            // infinity would be no number for a ray that runs along the face of a box.
            const float inverse = std::abs(d) > 1.0e-18F ? 1.0F / d : 1.0e18F;
            slope[i] = inverse;
            near_side[axis] = inverse < 0.0F ? axis + 3 : axis;
            far_side[axis] = inverse < 0.0F ? axis : axis + 3;
        }
    }

    /// Whether the sweep meets a single box within `limit`; rounding errs on the side of meeting.
    [[nodiscard]] bool meets(const Aabb& box, float limit) const {
        float enter = 0.0F;
        float leave = limit;
        for (int i = 0; i < 3; ++i) {
            const float a = (box.lower[i] - half[i] - origin[i]) * slope[i];
            const float b = (box.upper[i] + half[i] - origin[i]) * slope[i];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, kSlack * std::max(a, b));
        }
        return enter <= leave;
    }

    /// Moves the far end of an interval away by this much, so that roundings lose no box (Ize,
    /// "Robust BVH ray traversal", JCGT 2, 2013).
    static constexpr float kSlack = 1.000001F;

    Vec3 origin;
    Vec3 half;
    Vec3 slope = Vec3::Zero();
    std::array<std::size_t, 3> near_side{};  ///< which of BoxLanes::sides the sweep meets first
    std::array<std::size_t, 3> far_side{};
};

/// Lanes that hold no box are far away and inside out; callers mask them all the same, because
/// queries may be infinite.
struct BoxLanes {
    static constexpr float kFar = 3.0e38F;

    /// Lower x, y, z, upper x, y, z.
    std::array<Array8, 6> sides;

    BoxLanes() {
        for (std::size_t i = 0; i < kLanes; ++i) {
            clear(i);
        }
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(sides);
    }

    void set(std::size_t lane, const Aabb& box) {
        const auto i = static_cast<Eigen::Index>(lane);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sides[axis][i] = box.lower[static_cast<Eigen::Index>(axis)];
            sides[axis + 3][i] = box.upper[static_cast<Eigen::Index>(axis)];
        }
    }

    void clear(std::size_t lane) { set(lane, {Vec3::Constant(kFar), Vec3::Constant(-kFar)}); }

    [[nodiscard]] Aabb get(std::size_t lane) const {
        const auto i = static_cast<Eigen::Index>(lane);
        return {Vec3(sides[0][i], sides[1][i], sides[2][i]),
                Vec3(sides[3][i], sides[4][i], sides[5][i])};
    }

    /// The box around all that the lanes hold.
    [[nodiscard]] Aabb bounds() const {
        return {Vec3(sides[0].lowest(), sides[1].lowest(), sides[2].lowest()),
                Vec3(sides[3].highest(), sides[4].highest(), sides[5].highest())};
    }

    /// Bit i is set where box i and `box` have a point in common.
    [[nodiscard, gnu::always_inline]] std::uint32_t overlapping(const Aabb& box) const {
        // a - b <= 0 exactly where a <= b, as long as denormal numbers are kept.
        const Array8 apart = (sides[0] - box.upper.x())
                                 .max(box.lower.x() - sides[3])
                                 .max((sides[1] - box.upper.y()).max(box.lower.y() - sides[4]))
                                 .max((sides[2] - box.upper.z()).max(box.lower.z() - sides[5]));
        return lanes_at_most(apart, 0.0F);
    }

    /// Bit i is set where the sweep meets box i within `limit`; `enter` says from which distance
    /// on. Rounding errs on the side of meeting.
    [[nodiscard]] std::uint32_t met_by(const SweepLanes& s, float limit, Array8& enter) const {
        const auto slab = [&](std::size_t axis, bool far) -> Array8 {
            const auto i = static_cast<Eigen::Index>(axis);
            const std::size_t side = far ? s.far_side[axis] : s.near_side[axis];
            const float reach = side >= 3 ? s.half[i] : -s.half[i];
            return (sides[side] - (s.origin[i] - reach)) * s.slope[i];
        };
        enter = slab(0, false).max(slab(1, false)).max(slab(2, false)).max(0.0F);
        const Array8 leave = slab(0, true).min(slab(1, true)).min(slab(2, true));
        return lanes_at_most(enter, (leave * SweepLanes::kSlack).min(limit));
    }

    /// Squared distance of the point to each box, zero inside, m2; infinite for empty lanes.
    [[nodiscard]] Array8 squared_distance(const Vec3& point) const {
        const auto along = [&](std::size_t axis) -> Array8 {
            const float p = point[static_cast<Eigen::Index>(axis)];
            return (sides[axis] - p).max(p - sides[axis + 3]).max(0.0F);
        };
        return along(0).square() + along(1).square() + along(2).square();
    }
};

/// Calls visit(lane) for each bit of the mask, lowest first.
template <class Visit>
void for_each_lane(std::uint32_t mask, Visit&& visit) {
    for (; mask != 0; mask &= mask - 1) {
        visit(static_cast<std::size_t>(std::countr_zero(mask)));
    }
}

}  // namespace zoned::spatial
