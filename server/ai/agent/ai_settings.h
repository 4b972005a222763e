// AiSettings: the brains and limits of a world's agents.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/agent/difficulty.h"
#include "server/ai/crowd/avoidance_settings.h"
#include "server/ai/pathfinding/path_settings.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

struct AiSettings {
    std::vector<Brain> brains;              ///< as written
    std::vector<CompiledBrain> compiled{};  ///< for the world's time step: compile()
    /// By type of entity: brain + 1 of its agent, 0: none. Empty: as the types say.
    std::vector<std::uint16_t> brain_of_type{};
    std::uint32_t max_decisions_per_tick =
        4096;                ///< work units; work beyond this waits, the longest waiting first
    bool reduce_far = true;  ///< agents farther than far_m from every player steer every 4th tick
    float far_m = 150.0F;
    std::uint32_t max_plan_nodes = 1024;           ///< nodes that one search for a plan may create
    std::uint32_t max_sight_rays_per_tick = 8192;  ///< kRaysPerLook per agent with line of sight
    /// Agents farther than this from every player are suspended; infinity: none is. No client may
    /// receive an entity beyond it.
    float viewer_range_m = std::numeric_limits<float>::infinity();
    float suspend_after_s = 2.0F;  ///< time off screen before an agent is suspended
    PoiSettings points_of_interest{};
    PathfindingSettings pathfinding{};
    /// Local avoidance between agents, with the world's step: compile(). None: no avoidance.
    std::optional<steering::AvoidanceSettings> avoidance{};
    DifficultyLevels difficulty{};
};

/// Fills in `compiled`, also for the difficulty levels. Inner brains stay empty. `dt` in s.
void compile(AiSettings& settings, float dt);

/// True if agents with that brain (its number + 1; 0: none) go to places at some level of
/// difficulty. Call it after compile().
bool travels(const AiSettings& settings, std::uint16_t brain);

/// Gives each compiled brain that names code its machine, also for the difficulty levels. Call it
/// after compile(). Returns an empty text, or which brain lacks what; then no agent may run.
std::string bind_code(AiSettings& settings, std::span<const state_machine::CodedMachine> machines);

}  // namespace zoned::ai
