// ContactSet: the manifolds of a pair that has several, before they become contacts.
#pragma once

#include "server/physics/narrowphase/near_parts.h"
#include "server/physics/shapes/material.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::physics {

/// Which parts of the two shapes meet: the part of a in the upper half, that of b in the lower. A
/// part is a child of a compound or a triangle of a surface; a convex shape is its own part 0.
using PartKey = std::uint64_t;

struct PartManifold {
    PartKey key = 0;
    Manifold manifold;
    /// The parts' own materials; null: the body's.
    const Material* material_a = nullptr;
    const Material* material_b = nullptr;
};

/// How a pair approaches.
struct Probe {
    float margin = 0.0F;           ///< points farther apart than this are left out, m, ...
    Vec3 approach = Vec3::Zero();  ///< ... unless b's velocity relative to a, m/s, ...
    float time = 0.0F;             ///< ... closes the gap along the normal within this, s
};

/// Pairs have no more manifolds than this: of more the deepest ones count.
inline constexpr std::size_t kMaxPairManifolds = 32;

/// Scratch for one pair at a time.
class ContactSet {
  public:
    /// The contacts of all parts where they stand. Manifolds of nearly the same normal between the
    /// same materials become one of four points: a box on a floor of many triangles touches it like
    /// one on a plane.
    void collide(const Placed& a, const Placed& b, const Probe& probe);

    [[nodiscard]] const std::vector<PartManifold>& manifolds() const { return manifolds_; }

    /// Some sensor part overlapped the other body in `collide`.
    [[nodiscard]] bool sensed() const { return sensed_; }

    /// Manifolds that found no room in `collide`.
    [[nodiscard]] std::uint32_t dropped() const { return dropped_; }

    ContactSet();

  private:
    static constexpr std::size_t kGroupPoints = 16;

    /// Manifolds that will be one.
    struct ManifoldGroup {
        PartKey key;
        Vec3 normal;
        float separation;
        const Material* material_a;
        const Material* material_b;
        std::array<ManifoldPoint, kGroupPoints> points;
        std::size_t count;
    };

    struct Pair;
    void meet(const Pair& pair, const Probe& probe);
    /// Lists the triangles near all of a compound, so that its parts need not look for their own.
    void gather(const Placed& mesh, const Placed& compound, const Vec3& travel, float margin);
    template <class Surface>
    void meet_surface(const Pair& pair, const Probe& probe, const Surface& surface, bool a_is);
    void add(const Pair& pair, std::uint32_t triangle, const Probe& probe, Manifold& manifold);
    ManifoldGroup* group_for(const Pair& pair, PartKey key, const Manifold& manifold);

    NearTriangles near_;
    bool gathered_ = false;  ///< `near_` is complete
    std::vector<ManifoldGroup> groups_;
    std::vector<PartManifold> manifolds_;
    bool sensed_ = false;
    std::uint32_t dropped_ = 0;
};

/// The earliest time within the probe at which some parts of the shapes may be as near as `gap`,
/// from their distances where they stand: never too late; infinite when they stay apart.
float earliest_impact(const Placed& a, const Placed& b, const Probe& probe, float gap);

}  // namespace zoned::physics
