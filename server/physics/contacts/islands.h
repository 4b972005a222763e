// Islands: groups the dynamic bodies that contacts connect, and decides which groups may sleep.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/contacts/contact_graph.h"
#include "server/physics/joints/joint_table.h"
#include "shared/core/containers/union_find.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// Wakes a dynamic body and all that it touches or has joints with, directly or through others.
class Waker {
  public:
    void reserve(std::size_t bodies) { stack_.reserve(bodies); }

    void wake(Bodies& bodies, ContactGraph& graph, const JointTable& joints, std::uint32_t row);

  private:
    std::vector<std::uint32_t> stack_;
};

/// Builds the islands of the awake bodies. An island goes to sleep when each of its bodies has been
/// still for long enough and touches no kinematic body that moves. Eight times as long within a
/// centimetre of one place counts as still: a machine of joints and contacts may swing about its
/// rest for ever (J. Rouwe, "Jolt Physics", asks for places in place of speeds as well).
class Islands {
  public:
    struct Limits {
        float speed = 0.0F;    ///< m/s
        float spin = 0.0F;     ///< rad/s
        float after_s = 0.0F;  ///< 0: nothing ever sleeps
        float dt = 0.0F;
    };

    void reserve(std::size_t bodies) {
        sets_.reserve(bodies);
        still_s_.reserve(bodies);
    }

    /// Returns how many islands there were before any fell asleep.
    std::uint32_t update(Bodies& bodies,
                         ContactGraph& graph,
                         const JointTable& joints,
                         std::span<const std::uint32_t> active_joints,
                         const Limits& limits);

  private:
    core::UnionFind sets_;
    std::vector<float> still_s_;  // per set: the least of its bodies
};

/// Stops a body and takes it out of the simulation until something wakes it.
void put_to_sleep(Bodies& bodies, ContactGraph& graph, std::uint32_t row);

}  // namespace zoned::physics
