// OrcaAvoidance: reciprocal collision avoidance (ORCA) between agents, and avoidance of walls.
#pragma once

#include "server/ai/crowd/avoidance_settings.h"
#include "server/ai/crowd/crowd_agents.h"
#include "server/ai/crowd/crowd_order.h"
#include "server/ai/crowd/walls.h"
#include "server/compute/team.h"

#include <cstdint>
#include <vector>

namespace zoned::ai::steering {

/// AvoidanceReport: the counts of one step.
struct AvoidanceReport {
    std::uint32_t relaxed = 0;  ///< agents that could not avoid everything for the whole horizon
    std::uint32_t pressed = 0;  ///< agents that overlapped others and moved apart
    std::uint32_t stuck = 0;    ///< agents that stood: more neighbours or walls than the limits
                                ///< allow
};

/// A step of a crowd. The velocity of an agent is the one nearest to its desired velocity that
/// meets three conditions:
/// - It avoids collisions within the horizon reciprocally, by the half-planes of optimal reciprocal
///   collision avoidance. They are relaxed evenly where no velocity meets all of them. Source: van
///   den Berg, Guy, Lin and Manocha, "Reciprocal n-body collision avoidance", Robotics Research,
///   STAR 70, 2011, section 4.
/// - It keeps to the agent's share of the gap to each other agent during the step: a half-plane
///   between the two, after buffered Voronoi cells. Source: Zhou, Wang, Bandyopadhyay and Schwager,
///   "Fast, on-line collision avoidance for dynamic vehicles using buffered Voronoi cells", IEEE
///   Robotics and Automation Letters 2, 2017. Standing still always meets this condition, so it is
///   never relaxed. Two agents without overlap stay so, but for rounding, unless others move one.
/// - It keeps to the agent's side of walls in the same manner, so no agent walks through a wall,
///   however dense the crowd.
/// Agents that overlap (put there by others) part as fast as walls allow.
class OrcaAvoidance {
  public:
    explicit OrcaAvoidance(const AvoidanceSettings& settings) : settings_(settings) {}

    [[nodiscard]] const AvoidanceSettings& settings() const { return settings_; }

    /// Applies from the next step on.
    void set(const AvoidanceSettings& settings) { settings_ = settings; }

    /// Moves all agents with yield > 0 by a step and writes their velocities. `tick` numbers the
    /// steps and seeds random choices. The result has the same bits for any number of threads. Does
    /// not allocate for numbers of agents and cells met before.
    AvoidanceReport step(CrowdAgents& agents,
                         const Walls& walls,
                         std::uint64_t tick,
                         compute::Team& team);

  private:
    AvoidanceSettings settings_;
    CrowdOrder order_;
    std::vector<AvoidanceReport> of_batch_;
};

}  // namespace zoned::ai::steering
