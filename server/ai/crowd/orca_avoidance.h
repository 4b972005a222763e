// OrcaAvoidance: optimal reciprocal collision avoidance: agents avoid each other and walls.
#pragma once

#include "server/ai/crowd/crowd_agents.h"
#include "server/ai/crowd/crowd_order.h"
#include "server/ai/crowd/walls.h"
#include "server/compute/team.h"

#include <cstdint>
#include <vector>

namespace zoned::ai::steering {

struct AvoidanceSettings {
    float step_s = 0.05F;         ///< > 0
    float horizon_s = 1.2F;       ///< so far ahead collisions with others are avoided, >= step_s
    float wall_horizon_s = 0.2F;  ///< nobody gets nearer to a wall than in this time, >= step_s
    float neighbour_m = 3.0F;     ///< others that are farther do not matter, > 0
    float comfort_m = 0.1F;       ///< to others but those who go after, where there is room
    float comfort_s = 0.2F;       ///< so fast it is made, > 0
    /// How much one who gets nowhere tries other directions, as a share of its speed, 0 to 1.
    /// Without, some who block each other evenly would wait for ever.
    float restless = 0.7F;
    /// How far one whose path is blocked turns to its right, as a share of its speed, 0 to 1: who
    /// meet head-on pass each other, crowds that meet form lanes.
    float keep_right = 0.5F;
};

/// What happened in a step.
struct AvoidanceReport {
    std::uint32_t relaxed = 0;  ///< agents that could not avoid everything for the whole horizon
    std::uint32_t pressed = 0;  ///< agents that overlapped others and moved apart
    std::uint32_t stuck = 0;    ///< agents with more neighbours or walls than are looked at: stood
};

/// A step of a crowd. The velocity of an agent is the one nearest to what it wants among those that
/// - reciprocally avoid collisions within the horizon: half-planes of optimal reciprocal collision
///   avoidance (van den Berg, Guy, Lin and Manocha, "Reciprocal n-body collision avoidance",
///   Robotics Research, STAR 70, 2011, section 4), relaxed evenly where there are none such;
/// - keep to its share of the gap to each other agent during the step: a half-plane between the
///   two, after buffered Voronoi cells (Zhou, Wang, Bandyopadhyay and Schwager, "Fast, on-line
///   collision avoidance for dynamic vehicles using buffered Voronoi cells", IEEE Robotics and
///   Automation Letters 2, 2017). Standing still is always among them, so this is never relaxed:
///   two agents that do not overlap will not (but for rounding), unless one is moved by others;
/// - keep to its side of walls, likewise: nobody walks through a wall, however dense the crowd.
/// Those that overlap (put there by others) part as fast as walls allow.
class OrcaAvoidance {
  public:
    explicit OrcaAvoidance(const AvoidanceSettings& settings) : settings_(settings) {}

    [[nodiscard]] const AvoidanceSettings& settings() const { return settings_; }

    /// From the next step on.
    void set(const AvoidanceSettings& settings) { settings_ = settings; }

    /// Moves all agents with yield > 0 by a step and writes their velocities; `tick` numbers steps
    /// (random choices come from it). The same bits for any number of threads, no allocation once
    /// as many agents and cells have been seen.
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
