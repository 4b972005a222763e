#include "server/physics/narrowphase/narrowphase.h"

#include <algorithm>
#include <utility>

namespace zoned::physics {

namespace {

using Collide = void (*)(const Placed&, const Placed&, float, Manifold&);

// [kind of a][kind of b] for a's kind <= b's kind, in the order of ShapeKind.
constexpr Collide kTests[kConvexKinds][kConvexKinds] = {
    {collide_sphere_sphere,
     collide_sphere_box,
     collide_sphere_capsule,
     collide_sphere_plane,
     collide_sphere_hull},
    {nullptr, collide_box_box, collide_box_capsule, collide_box_plane, collide_box_hull},
    {nullptr, nullptr, collide_capsule_capsule, collide_capsule_plane, collide_capsule_hull},
    {nullptr, nullptr, nullptr, nullptr, collide_plane_hull},
    {nullptr, nullptr, nullptr, nullptr, collide_hull_hull},
};

/// A pair that moves less than this within a step is looked at where it stands.
constexpr float kSlowMotion = 0.1F;
/// Close enough to count as the impact, m.
constexpr float kImpactGap = 0.01F;
/// Looked farther ahead than a pair at rest needs, m.
constexpr float kLookAhead = 0.002F;
constexpr int kMaxImpactAdvances = 12;

}  // namespace

void collide(const Placed& a, const Placed& b, float margin, Manifold& out) {
    out.count = 0;
    out.separation = INFINITY;
    const auto ka = static_cast<std::size_t>(a.shape.kind);
    const auto kb = static_cast<std::size_t>(b.shape.kind);
    if (ka <= kb) {
        if (kTests[ka][kb] != nullptr) {
            kTests[ka][kb](a, b, margin, out);
        }
    } else {
        kTests[kb][ka](b, a, margin, out);
        out.flip();
    }
}

Impact collide_ahead(const Placed& a, const Placed& b, const PairMotion& motion, Manifold& out) {
    const Vec3 relative = motion.velocity_b - motion.velocity_a;
    const float travel = relative.norm() * motion.dt;
    if (travel <= kSlowMotion) {
        // A body at rest may start to move a little without being looked at again.
        const float margin = kContactMargin + std::max(travel + motion.turn, kLookAhead);
        collide(a, b, margin, out);
        return {0.0F, margin};
    }
    const float margin = kContactMargin + motion.turn;
    const float gap_of_impact = kImpactGap + motion.turn;
    float time = 0.0F;
    for (int i = 0; i < kMaxImpactAdvances; ++i) {
        const Placed at_a{a.shape, a.position + time * motion.velocity_a, a.rotation};
        const Placed at_b{b.shape, b.position + time * motion.velocity_b, b.rotation};
        collide(at_a, at_b, margin, out);
        const float closing = -out.normal.dot(relative);
        if (out.separation <= gap_of_impact) {
            if (time > 0.0F && closing > 0.0F) {
                // Points that will follow within the step hold the body too: with the first one
                // alone it would spin about it and through the other surface.
                collide(at_a, at_b, margin + closing * (motion.dt - time), out);
            }
            return {time, margin};
        }
        // Along the separating axis they cannot meet before the gap is closed at this rate.
        if (closing * (motion.dt - time) < out.separation - gap_of_impact) {
            break;
        }
        time += std::max(out.separation - 0.5F * gap_of_impact, 0.0F) / closing;
    }
    if (out.separation > margin) {
        out.count = 0;
    }
    return {time, margin};
}

Impact collide_ahead(const Placed& a, const Placed& b, const PairMotion& motion, ContactSet& out) {
    const Vec3 relative = motion.velocity_b - motion.velocity_a;
    const float travel = relative.norm() * motion.dt;
    if (travel <= kSlowMotion) {
        const float margin = kContactMargin + std::max(travel + motion.turn, kLookAhead);
        out.collide(a, b, {margin, Vec3::Zero(), 0.0F});
        return {0.0F, margin};
    }
    Probe probe{kContactMargin + motion.turn, relative, motion.dt};
    const float gap_of_impact = kImpactGap + motion.turn;
    float time = 0.0F;
    for (int i = 0; i < kMaxImpactAdvances; ++i) {
        const Placed at_a{a.shape, a.position + time * motion.velocity_a, a.rotation};
        const Placed at_b{b.shape, b.position + time * motion.velocity_b, b.rotation};
        const float step = earliest_impact(at_a, at_b, probe, gap_of_impact);
        if (step == INFINITY) {
            break;
        }
        if (step == 0.0F || i == kMaxImpactAdvances - 1) {
            out.collide(at_a, at_b, probe);
            return {time, probe.margin};
        }
        time = std::min(time + step, motion.dt);
        probe.time = motion.dt - time;
    }
    // They stay apart: parts that are near all the same are near where they stand.
    out.collide(a, b, {probe.margin, Vec3::Zero(), 0.0F});
    return {0.0F, probe.margin};
}

}  // namespace zoned::physics
