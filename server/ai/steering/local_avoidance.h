// LocalAvoidance: gives agents on a collision course a command that avoids it (ORCA).
// All other agents keep their command, bit for bit.
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

/// AvoidingAgent: the entity of an active agent that takes part in avoidance.
struct AvoidingAgent {
    world::Row row = world::kNoRow;
    float path_left_m = 0.0F;  ///< distance to its goal; the agent with less goes first
};

/// The distance that an agent in `state` still has to go from `here` (x, z, m); 0: unknown.
float path_left(const Agent& agent,
                const BrainState& state,
                const PointsOfInterest& points_of_interest,
                const Vec2& here);

struct LocalAvoidanceReport {
    std::uint32_t crowded = 0;   ///< walkers that were on a collision course
    std::uint32_t gave_way = 0;  ///< of the crowded ones: got another command than they wanted
    std::uint32_t held = 0;      ///< of the crowded ones: could only brake
};

/// A command is only what a character makes of it (motion::apply_input). A promise about places
/// therefore has to include acceleration and quantised commands.
/// Two characters that both yield are divided by a line. It lies half-way between their positions
/// and the places at which they would stop if they braked now. A command is given only if its
/// character keeps to its side after this tick and after braking from then on. apply_input itself
/// computes that. A command also never leads a character off the ground if it keeps to the ground.
/// Braking is always among the allowed commands. So a character that overlaps nobody stays free of
/// overlap, unless others move it.
/// Source for sets that stopping keeps for ever: Fraichard and Asama, "Inevitable collision
/// states", Advanced Robotics 18, 2004. Source for the lines: steering::OrcaAvoidance.
class LocalAvoidance {
  public:
    /// `walkers` ascend by entity id; each has the command that its agent wants. Other characters
    /// and moving bodies count as obstacles; those with an agent in another zone yield. Changes
    /// only `command` of the walkers. The result has the same bits for any number of threads and
    /// any order of rows. Does not allocate once as many have been near each other before.
    LocalAvoidanceReport step(std::span<const AvoidingAgent> walkers,
                              const AiContext& ai,
                              steering::KnownWalls& walls,
                              const steering::AvoidanceSettings& settings);

  private:
    /// The course of one character: its present place and its stop. A character that does not yield
    /// has its place after the tick instead of its stop.
    struct BrakingCourse {
        Vec2 at = Vec2::Zero();
        Vec2 end = Vec2::Zero();
        float y = 0.0F;
        float half_height = 0.0F;
    };

    /// n . x >= c holds for all places x of a walker.
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
    std::size_t walkers_ = 0;             // this many entries at the start of seen_ are walkers
    std::vector<world::Row> rows_;        // by index in seen_
    std::vector<BrakingCourse> courses_;  // by index in seen_
    std::vector<std::uint8_t> taken_;     // by row: it is a walker
    std::vector<world::Row> others_;
    std::vector<std::uint8_t> crowded_;  // by index in seen_: kCrowded, kNear
    std::vector<std::uint8_t> outcome_;  // by index in seen_
    steering::CrowdOrder order_;
    float reach_ = 0.0F;
    steering::CrowdAgents close_;          // the entries of seen_ that decide which walkers are
                                           // crowded
    std::vector<std::uint32_t> close_of_;  // by index in seen_: row in close_
    steering::OrcaAvoidance avoidance_{steering::AvoidanceSettings()};
};

}  // namespace zoned::ai
