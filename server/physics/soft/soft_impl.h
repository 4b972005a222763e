// SoftBodies::Impl: the bodies of one SoftBodies, for the sources that implement it.
#pragma once

#include "server/physics/soft/collision/soft_pairs.h"
#include "server/physics/soft/soft_bodies.h"
#include "server/physics/soft/soft_body.h"

#include <vector>

namespace zoned::physics::soft {

struct SoftBodies::Impl {
    std::vector<SoftBody> bodies;
    std::vector<BodyId> near;
    SoftPairs pairs;
    SoftStats stats;

    /// A sleeping body wakes when something that moves will be at it within the step.
    void wake_touched(const Scene& scene, float slow, float dt);
    void integrate(const Vec3& gravity, float dt, Scene* scene, compute::Team* team);
    void integrate_island(const SoftIsland& island,
                          const Vec3& gravity,
                          float dt,
                          Scene* scene,
                          compute::Team* helpers);
    void settle(SoftBody& body, const SoftSettings& settings, float dt);
    /// Bodies that touch each other fall asleep together.
    void put_to_sleep(const SoftSettings& settings);
    /// Wakes bodies that slept on one that goes.
    void wake_around(const SoftBody& body);
    void count(SoftStats& s) const;
};

/// Its box, from the nodes.
void fit_box(SoftBody& body);

}  // namespace zoned::physics::soft
