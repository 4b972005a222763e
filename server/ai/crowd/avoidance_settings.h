// AvoidanceSettings: how far ahead the agents of a crowd avoid each other and walls.
#pragma once

namespace zoned::ai::steering {

struct AvoidanceSettings {
    float step_s = 0.05F;         ///< > 0
    float horizon_s = 1.2F;       ///< collisions with others are avoided this far ahead, >= step_s
    float wall_horizon_s = 0.2F;  ///< no agent may reach a wall within this time, >= step_s
    float neighbour_m = 3.0F;     ///< others farther away are ignored, > 0
    float comfort_m = 0.1F;       ///< distance to other agents where there is room, except to
                                  ///< agents that go after it
    float comfort_s = 0.2F;       ///< time in which that distance is restored, > 0
    /// The share of its speed with which a blocked agent tries other directions, 0 to 1. Without
    /// it, agents that block each other evenly would wait for ever.
    float restless = 0.7F;
    /// The share of its speed with which a blocked agent turns to its right, 0 to 1. Agents that
    /// meet head-on pass each other, and crowds that meet form lanes.
    float keep_right = 0.5F;
};

}  // namespace zoned::ai::steering
