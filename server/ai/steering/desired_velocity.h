// DesiredVelocity: where an agent wants to go now, before that becomes a command or a path segment.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/agent/whereabouts.h"
#include "server/ai/ai_context.h"
#include "server/ai/pathfinding/path_service.h"
#include "server/ai/steering/flocking.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <optional>

namespace zoned::ai {

/// A goal this near counts as reached, m.
inline constexpr float kArriveM = 1.0F;
/// A chaser stops this near to its prey and follows again beyond the other, m.
inline constexpr float kChaseStopM = 1.1F;
inline constexpr float kChaseFollowM = 1.4F;

/// The most of a command's move along one axis.
inline constexpr float kFullMove = 127.0F;

/// What desired velocities and steering read besides the agent.
struct Surroundings {
    const AiContext& ai;
    world::Row self;
    Slot slot = 0;           ///< of the agent
    Vec2 at = Vec2::Zero();  ///< x, z where the agent takes itself to be, m: whereabouts.h
    bool there = false;      ///< its path ends here: nearer to its goal it does not come
    bool all_out = false;    ///< it keeps no speed back, for no body has to follow its segment
    const HerdDrift* drift = nullptr;  ///< of a herd that is not seen, or in part; null: all are
                                       ///< where their rows say

    /// x, z of the entity, m.
    [[nodiscard]] Vec2 body() const {
        const Vec3& position = ai.entities.position[self];
        return {position.x(), position.z()};
    }
};

/// Of an agent that takes itself to be where whereabouts() says.
Surroundings surroundings_of(const AiContext& ai,
                             const Agent& agent,
                             world::Row row,
                             Slot slot = 0);

struct DesiredVelocity {
    Vec2 direction = Vec2::Zero();  ///< need not have unit length; zero = stand still
    bool has_goal = false;          ///< progress means coming nearer to `goal`
    Vec2 goal = Vec2::Zero();
    float fresh_cos;     ///< re-aim at a decision when the cosine is below this
    bool seeks = false;  ///< wants to get to `goal`: by a path, where it can't go straight
    bool keep = false;   ///< nothing new: the aim stays
    bool far = false;    ///< it stands where it did not want to: a path may open

    DesiredVelocity();
};

/// Begins what the agent does anew, which it has just turned to.
void begin_action(Agent& agent, const BrainState& state, const Surroundings& around);

/// Where an escort goes, m: between its ward and a threat, `radius_m` from the ward but no farther
/// than half way; without a threat beside a ward that moves, across its path, on the side on which
/// the escort is; of one that stands to within half a radius more than that.
Vec2 escort_place(const Vec2& here,
                  const Vec2& ward,
                  const Vec2& ward_velocity,
                  const std::optional<Vec2>& threat,
                  float radius_m);

/// What `state` wants; `speed` in m/s. Moves on targets that are reached.
DesiredVelocity desired_velocity(Agent& agent,
                                 const BrainState& state,
                                 float speed,
                                 const Surroundings& around);

/// How high the feet are of who is where such a desired leads, m: as at home for what begins there,
/// as those of whom it is about, as a place has it; not a number: on the ground.
float goal_floor(const Agent& agent, const BrainState& state, const Surroundings& around);

/// At a decision a herd animal re-aims when the cosine of what its heading is off by is below this:
/// 10 degrees, for herds are many and may be sloppy.
inline constexpr float kReaimFlockCos = 0.98481F;

/// Where a herd animal at `here` (x, z, m) wants to go on its own account; `speed` in m/s.
FlockPull flock_pull(const Agent& agent,
                     const BrainState& state,
                     float speed,
                     const Vec2& here,
                     const PointsOfInterest& points_of_interest);

/// Another point for a wanderer.
void pick_wander_target(Agent& agent, float radius, const Surroundings& around);

/// Of a walker in that state, m/s.
float full_speed(const BrainState& state, const Surroundings& around);

/// Whether its command moves it.
bool moving(const Agent& agent);

/// Whether it is on its way: by its segment where it goes by one.
bool walks(const Agent& agent);

/// Of a command, or the agent's: unit length, or zero when it stands.
Vec2 aim_direction(const motion::InputCommand& aim);
Vec2 aim_direction(const Agent& agent);

/// How fast it goes.
struct Pace {
    float factor = 1.0F;  ///< of walking, or of sprinting
    bool sprint = false;
};

/// `direction` has unit length.
void move_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction);
void face_along(motion::InputCommand& aim, const Vec2& direction);
/// Both.
void aim_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction);
void aim_along(Agent& agent, const Pace& pace, const Vec2& direction);
void aim_along(Agent& agent, const BrainState& state, const Vec2& direction);

void restart_progress(Agent& agent, const Vec3& here, Tick now);

}  // namespace zoned::ai
