// LocalAvoidance: agents that would meet somebody get a command that avoids it (ORCA); all others
// keep theirs, bit for bit.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/ai_context.h"
#include "server/ai/crowd/orca_avoidance.h"
#include "server/ai/crowd/static_walls.h"
#include "server/world/entities.h"
#include "shared/motion/static_geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Who makes way: the entity of an active agent.
struct AvoidingAgent {
    world::Row row = world::kNoRow;
    float path_left_m = 0.0F;  ///< to where it goes; who has less goes first
};

/// How far an agent that does `state` still has to go from `here` (x, z, m); 0: nobody knows.
float path_left(const Agent& agent,
                const BrainState& state,
                const PointsOfInterest& points_of_interest,
                const Vec2& here);

struct LocalAvoidanceReport {
    std::uint32_t crowded = 0;   ///< walkers that would have met somebody
    std::uint32_t gave_way = 0;  ///< of these: whose command is not what they want
    std::uint32_t held = 0;      ///< of these: that could but brake
};

/// Commands are what characters make of them (motion::apply_input), so a promise about
/// places has to know about acceleration and quantised commands. Between two that both
/// yield lies a line half path between where they are and where they would come to stand if they
/// braked now. A command is given only if its character, after this tick and after braking from
/// then on, keeps to its side, as apply_input itself says, and nobody who keeps to the ground is
/// led off it. To brake is always among these, so whoever does not overlap will not, unless moved
/// by others. The idea of sets that can be kept for ever by stopping: Fraichard and Asama,
/// "Inevitable collision states", Advanced Robotics 18, 2004; the lines: steering::OrcaAvoidance.
class LocalAvoidance {
  public:
    /// `walkers` ascend by entity id, each has the command that its agent wants. Others that count:
    /// characters, and bodies that move; those yield that have an agent in another zone. Changes
    /// `command` of walkers alone. The same bits for any number of threads and order of rows; no
    /// allocation once as many were near each other.
    LocalAvoidanceReport step(std::span<const AvoidingAgent> walkers,
                              const AiContext& ai,
                              steering::KnownWalls& walls,
                              const steering::AvoidanceSettings& settings);

  private:
    /// Where one is and where it comes to stand, or is after the tick where it does not yield.
    struct BrakingCourse {
        Vec2 at = Vec2::Zero();
        Vec2 end = Vec2::Zero();
        float y = 0.0F;
        float half_height = 0.0F;
    };

    /// n . x >= c for all places x of a walker.
    struct DividingLine {
        Vec2 n = Vec2::Zero();
        float c = 0.0F;
    };

    struct BrakingStop {
        Vec2 at = Vec2::Zero();   ///< after the tick
        Vec2 end = Vec2::Zero();  ///< after braking
        float y = 0.0F;           ///< after the tick
        bool free = true;         ///< no wall turns it aside meanwhile
    };

    void gather(std::span<const AvoidingAgent> walkers, const AiContext& ai);
    void add_walker(const AvoidingAgent& walker, const AiContext& ai);
    void add_other(world::Row row, const AiContext& ai);
    [[nodiscard]] float reach(const AiContext& ai,
                              const steering::AvoidanceSettings& settings) const;
    void find_crowded(const AiContext& ai, const steering::AvoidanceSettings& settings);
    [[nodiscard]] bool is_crowded(std::uint32_t one,
                                  const steering::CrowdBatch& batch,
                                  const AiContext& ai,
                                  const steering::AvoidanceSettings& settings) const;
    [[nodiscard]] bool would_meet(std::uint32_t one,
                                  std::uint32_t other,
                                  const steering::AvoidanceSettings& settings) const;
    [[nodiscard]] bool apart_in_height(std::uint32_t one, std::uint32_t other) const;
    [[nodiscard]] DividingLine side_of(std::uint32_t one, std::uint32_t other) const;
    template <class Visit>
    void for_each_near(const steering::CrowdBatch& batch, Visit&& visit) const;
    void take_in_neighbours(const steering::AvoidanceSettings& settings);
    void give_commands(const AiContext& ai);
    void give_command(std::uint32_t one, const steering::CrowdBatch& batch, const AiContext& ai);
    [[nodiscard]] BrakingStop stop_of(world::Row row,
                                      const motion::InputCommand& command,
                                      const AiContext& ai) const;
    [[nodiscard]] static bool is_carried(world::Row row,
                                         const BrakingStop& stop,
                                         const AiContext& ai);

    steering::CrowdAgents seen_;          // walkers, then others by entity id
    std::size_t walkers_ = 0;             // the first so many of seen_
    std::vector<world::Row> rows_;        // by seen
    std::vector<BrakingCourse> courses_;  // by seen
    std::vector<std::uint8_t> taken_;     // by row: it is a walker
    std::vector<world::Row> others_;
    std::vector<std::uint8_t> crowded_;  // by seen: kCrowded, kNear
    std::vector<std::uint8_t> outcome_;  // by seen
    steering::CrowdOrder order_;
    float reach_ = 0.0F;
    steering::CrowdAgents close_;          // those that count for who is crowded
    std::vector<std::uint32_t> close_of_;  // by seen: row of close_
    steering::OrcaAvoidance avoidance_{steering::AvoidanceSettings()};
};

}  // namespace zoned::ai
