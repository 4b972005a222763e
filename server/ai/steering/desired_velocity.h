// DesiredVelocity: the direction and goal that an agent wants now, before path and command.
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

/// The largest move of a command along one axis.
inline constexpr float kFullMove = 127.0F;

/// Surroundings: the inputs, besides the agent, of desired velocities and steering.
struct Surroundings {
    const AiContext& ai;
    world::Row self;
    Slot slot = 0;           ///< of the agent
    Vec2 at = Vec2::Zero();  ///< x, z where the agent takes itself to be, m: see whereabouts.h
    bool there = false;      ///< its path ends here: it cannot come nearer to its goal
    bool all_out = false;    ///< it keeps no speed in reserve, because no body has to follow its
                             ///< segment
    const HerdDrift* drift = nullptr;  ///< positions of a herd that is fully or partly suspended;
                                       ///< null: all stand where their rows say

    /// x, z of the entity, m.
    [[nodiscard]] Vec2 body() const {
        const Vec3& position = ai.entities.position[self];
        return {position.x(), position.z()};
    }
};

/// The surroundings of an agent that takes itself to be where whereabouts() says.
Surroundings surroundings_of(const AiContext& ai,
                             const Agent& agent,
                             world::Row row,
                             Slot slot = 0);

struct DesiredVelocity {
    Vec2 direction = Vec2::Zero();  ///< need not have unit length; zero = stand still
    bool has_goal = false;          ///< progress means coming nearer to `goal`
    Vec2 goal = Vec2::Zero();
    float fresh_cos;     ///< re-aim at a decision when the cosine is below this
    bool seeks = false;  ///< wants to get to `goal`, and needs a path where it cannot go straight
    bool keep = false;   ///< nothing new: the aim stays
    bool far = false;    ///< it had to stop against its will: a path may open

    DesiredVelocity();
};

/// Starts the action that the agent has just switched to.
void begin_action(Agent& agent, const BrainState& state, const Surroundings& around);

/// The place of an escort, m: `radius_m` from its ward, between the ward and a threat, but no
/// farther than half the distance to the threat. Without a threat it keeps to its own side of a
/// moving ward, across the ward's path. Beside a ward that stands it stays where it is within 1.5
/// radii, else it goes to `radius_m`.
Vec2 escort_place(const Vec2& here,
                  const Vec2& ward,
                  const Vec2& ward_velocity,
                  const std::optional<Vec2>& threat,
                  float radius_m);

/// The desired velocity of `state`; `speed` in m/s. Moves on targets that are reached.
DesiredVelocity desired_velocity(Agent& agent,
                                 const BrainState& state,
                                 float speed,
                                 const Surroundings& around);

/// The height of the feet at the goal of such a desired velocity, m. A goal that begins at home has
/// the height of home. A goal about another entity has that entity's height, and a place has its
/// own. Not a number: on the ground.
float goal_floor(const Agent& agent, const BrainState& state, const Surroundings& around);

/// At a decision a herd animal re-aims when the cosine of its heading error is below this. It is 10
/// degrees, because herds are large and need little precision.
inline constexpr float kReaimFlockCos = 0.98481F;

/// The direction in which a herd animal at `here` (x, z, m) wants to go by itself; `speed` in m/s.
FlockPull flock_pull(const Agent& agent,
                     const BrainState& state,
                     float speed,
                     const Vec2& here,
                     const PointsOfInterest& points_of_interest);

/// Another point for a wanderer.
void pick_wander_target(Agent& agent, float radius, const Surroundings& around);

/// The full speed of a walker in that state, m/s.
float full_speed(const BrainState& state, const Surroundings& around);

/// True if its command moves it.
bool moving(const Agent& agent);

/// True: the agent is under way. An agent that follows a segment is judged by its segment.
bool walks(const Agent& agent);

/// The direction of a command, or of the agent's command: unit length, or zero when it stands.
Vec2 aim_direction(const motion::InputCommand& aim);
Vec2 aim_direction(const Agent& agent);

/// The speed of a move: the gait and a share of its full speed.
struct Pace {
    float factor = 1.0F;  ///< share of the walking or the sprinting speed
    bool sprint = false;
};

/// `direction` has unit length.
void move_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction);
void face_along(motion::InputCommand& aim, const Vec2& direction);
/// Sets both direction and pace.
void aim_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction);
void aim_along(Agent& agent, const Pace& pace, const Vec2& direction);
void aim_along(Agent& agent, const BrainState& state, const Vec2& direction);

void restart_progress(Agent& agent, const Vec3& here, Tick now);

}  // namespace zoned::ai
