#include "server/ai/steering/desired_velocity.h"

#include "server/ai/steering/flocking.h"
#include "server/ai/steering/forage_walk.h"
#include "server/ai/steering/formation_following.h"
#include "server/ai/steering/spline_following.h"
#include "shared/core/assert.h"
#include "shared/math/heading.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr float kReaimFreshCos = 0.99452F;  ///< cos 6 degrees
/// A standing returner sets out again only when pushed this far from home, m.
constexpr float kSetOutM = 2.0F;
/// Feet farther above or below each other stand on two floors, m.
constexpr float kOtherFloorM = 1.5F;

/// A ward that is slower than this stands, m/s.
constexpr float kStrollMps = 0.1F;
/// An agent within this many radii of a standing ward is near enough.
constexpr float kNearShare = 1.5F;
/// A follower stops within this share of the radius.
constexpr float kFollowStop = 0.7F;
/// The most places on the route of a herd.
constexpr std::size_t kMostStops = 32;
/// The distance from its path at which a herd turns back by half a right angle, as a share of its
/// radius.
constexpr float kTrackShare = 0.5F;
/// The meaning of Agent::corner for a guard.
constexpr std::uint8_t kAtPost = 0;
constexpr std::uint8_t kEngaged = 1;

Vec2 flat(const Vec3& v) {
    return {v.x(), v.z()};
}

Vec2 corner_of(const Agent& agent, float radius, std::uint8_t corner, const Surroundings& around) {
    const bool right = corner == 1 || corner == 2;
    const bool up = corner >= 2;
    return around.ai.world.nearest(flat(agent.home) +
                                   Vec2(right ? radius : -radius, up ? radius : -radius));
}

std::uint8_t nearest_corner(const Agent& agent, float radius, const Surroundings& around) {
    const Vec2 here = around.at;
    std::uint8_t best = 0;
    for (std::uint8_t corner = 1; corner < 4; ++corner) {
        if ((corner_of(agent, radius, corner, around) - here).squaredNorm() <
            (corner_of(agent, radius, best, around) - here).squaredNorm()) {
            best = corner;
        }
    }
    return best;
}

DesiredVelocity go_to(const Vec2& goal, const Vec2& here) {
    DesiredVelocity desired;
    desired.has_goal = true;
    desired.seeks = true;
    desired.goal = goal;
    desired.direction = goal - here;
    return desired;
}

DesiredVelocity wander_velocity(Agent& agent, const BrainState& state, const Surroundings& around) {
    const Vec2 here = around.at;
    if (around.there || (flat(agent.target) - here).norm() < kArriveM) {
        pick_wander_target(agent, state.radius_m, around);
    }
    return go_to(flat(agent.target), here);
}

DesiredVelocity patrol_velocity(Agent& agent, const BrainState& state, const Surroundings& around) {
    Vec2 goal = corner_of(agent, state.radius_m, agent.corner, around);
    if (around.there || (goal - around.at).norm() < kArriveM) {
        agent.corner = static_cast<std::uint8_t>((agent.corner + 1) & 3);
        restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
        goal = corner_of(agent, state.radius_m, agent.corner, around);
    }
    return go_to(goal, around.at);
}

/// True if a goal that is near over the ground is on another floor, as far as the maps know floors.
bool on_other_floor(const Agent& agent,
                    const BrainState& state,
                    const Vec2& goal,
                    const Surroundings& around) {
    const TypeIndex type = around.ai.entities.type[around.self];
    if (around.ai.paths == nullptr || !around.ai.paths->plans_for(type)) {
        return false;
    }
    const float ground = around.ai.paths->ground(type, {goal.x(), goal.y()});
    const float of_goal = goal_floor(agent, state, around);
    const float floor = std::isnan(of_goal) ? ground : of_goal;
    const motion::CharacterLimits& body = around.ai.types[type].character;
    const float feet =
        around.ai.entities.position[around.self].y() - body.radius - body.half_segment;
    // Where the map knows no floors there is only one.
    return !std::isnan(ground) && std::abs(floor - feet) > kOtherFloorM;
}

/// To stand at: left only when pushed away from it.
DesiredVelocity go_and_stay(const Agent& agent,
                            const BrainState& state,
                            const Vec2& goal,
                            const Surroundings& around) {
    const float over_ground = (goal - around.at).norm();
    const bool above = over_ground < kSetOutM && on_other_floor(agent, state, goal, around);
    const float distance = above ? kSetOutM : over_ground;
    DesiredVelocity desired;
    desired.far = around.there && !(distance < kArriveM);
    const bool stay = distance < (walks(agent) ? kArriveM : kSetOutM);
    return stay || desired.far ? desired : go_to(goal, around.at);
}

DesiredVelocity return_velocity(const Agent& agent,
                                const BrainState& state,
                                const Surroundings& around) {
    return go_and_stay(agent, state, flat(agent.home), around);
}

DesiredVelocity place_velocity(const Agent& agent,
                               const BrainState& state,
                               const Surroundings& around) {
    return go_and_stay(
        agent, state, around.ai.points_of_interest.spot(state.place, agent.entity), around);
}

/// Another entity, as the agent believes it to be.
struct Other {
    Vec2 place = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();
};

std::optional<Other> other_of(EntityId entity, const Surroundings& around) {
    const world::Row row = entity ? around.ai.entities.find(entity) : world::kNoRow;
    if (row == world::kNoRow || around.ai.entities.has(row, world::kHidden)) {
        return std::nullopt;
    }
    return Other{flat(around.ai.entities.position[row]), flat(around.ai.entities.velocity[row])};
}

/// Its present place, or the place where it was last noticed.
std::optional<Other> target_of(const Agent& agent, const Surroundings& around) {
    if (agent.prey && !agent.noticed) {
        return Other{flat(agent.known), Vec2::Zero()};
    }
    return other_of(agent.prey, around);
}

/// Chase and flee: `sign` is +1 towards, -1 away.
DesiredVelocity prey_velocity(const Agent& agent,
                              const BrainState& state,
                              const Surroundings& around,
                              float sign) {
    const std::optional<Other> target = target_of(agent, around);
    if (!target) {
        return {};
    }
    const Vec2 towards = target->place - around.at;
    const float distance = towards.norm();
    DesiredVelocity desired;
    if (sign > 0.0F && distance < (moving(agent) ? kChaseStopM : kChaseFollowM) &&
        !on_other_floor(agent, state, target->place, around)) {
        return desired;
    }
    desired.seeks = sign > 0.0F;
    desired.goal = target->place;
    // On the very spot of its prey any direction leads away.
    const Vec2 way = distance < 1e-4F ? Vec2(1.0F, 0.0F) : Vec2(sign * towards);
    desired.direction = sign > 0.0F ? way : around.ai.world.held(around.at, way);
    return desired;
}

DesiredVelocity flock_velocity(Agent& agent,
                               const BrainState& state,
                               float speed,
                               const Surroundings& around) {
    DesiredVelocity desired;
    desired.keep = !agent.fresh && moving(agent);
    if (desired.keep) {
        return desired;
    }
    const FlockQuery query{
        flock_pull(agent, state, speed, around.body(), around.ai.points_of_interest),
        around.self,
        around.drift};
    desired.direction = flock_heading(around.ai.entities, *around.ai.near, query);
    desired.fresh_cos = kReaimFlockCos;
    if (desired.direction.norm() < 1e-3F) {
        // Balanced: walk on, or set out anywhere.
        desired.keep = moving(agent);
        desired.direction = Vec2(agent.rng.range(-1.0F, 1.0F), 1.0F);
    }
    return desired;
}

/// Stays within `radius_m` of its ward, else of its target. It sets out when it is beyond, and
/// stops well within. So an agent beside another does not stop and go with every step.
DesiredVelocity follow_velocity(const Agent& agent,
                                const BrainState& state,
                                const Surroundings& around) {
    const std::optional<Other> whom =
        agent.ward ? other_of(agent.ward, around) : target_of(agent, around);
    if (!whom) {
        return {};
    }
    const float enough = moving(agent) ? kFollowStop * state.radius_m : state.radius_m;
    const bool near = (whom->place - around.at).norm() < enough &&
                      !on_other_floor(agent, state, whom->place, around);
    return near ? DesiredVelocity() : go_to(whom->place, around.at);
}

DesiredVelocity escort_velocity(const Agent& agent,
                                const BrainState& state,
                                const Surroundings& around) {
    const std::optional<Other> ward = other_of(agent.ward, around);
    if (!ward) {
        return {};
    }
    const Vec2 here = around.at;
    const std::optional<Other> threat = target_of(agent, around);
    const Vec2 goal = escort_place(here,
                                   ward->place,
                                   ward->velocity,
                                   threat ? std::optional<Vec2>(threat->place) : std::nullopt,
                                   state.radius_m);
    return (goal - here).norm() < (moving(agent) ? 0.5F * kArriveM : kArriveM) ? DesiredVelocity()
                                                                               : go_to(goal, here);
}

DesiredVelocity guard_velocity(Agent& agent, const BrainState& state, const Surroundings& around) {
    const std::optional<Other> target = target_of(agent, around);
    const float from_post = target ? (target->place - flat(agent.home)).norm() : 0.0F;
    const float reach = agent.corner == kEngaged ? state.leash_m : state.radius_m;
    agent.corner = target && from_post <= reach ? kEngaged : kAtPost;
    return agent.corner == kEngaged ? prey_velocity(agent, state, around, 1.0F)
                                    : return_velocity(agent, state, around);
}

}  // namespace

Surroundings surroundings_of(const AiContext& ai, const Agent& agent, world::Row row, Slot slot) {
    Surroundings around{ai, row, slot};
    around.at = whereabouts(agent, around.body(), ai.now, ai.dt);
    return around;
}

Vec2 escort_place(const Vec2& here,
                  const Vec2& ward,
                  const Vec2& ward_velocity,
                  const std::optional<Vec2>& threat,
                  float radius_m) {
    const Vec2 to_threat = threat ? Vec2(*threat - ward) : Vec2::Zero();
    const float distance = to_threat.norm();
    if (distance > 1e-3F) {
        return ward + to_threat * (std::min(radius_m, 0.5F * distance) / distance);
    }
    const Vec2 from_ward = here - ward;
    const float speed = ward_velocity.norm();
    if (speed > kStrollMps) {
        const Vec2 across(ward_velocity.y() / speed, -ward_velocity.x() / speed);
        return ward + across * (across.dot(from_ward) < 0.0F ? -radius_m : radius_m);
    }
    const float apart = from_ward.norm();
    const bool near = apart <= kNearShare * radius_m;
    return near || !(apart > 1e-3F) ? here : Vec2(ward + from_ward * (radius_m / apart));
}

DesiredVelocity::DesiredVelocity() : fresh_cos(kReaimFreshCos) {
}

FlockPull flock_pull(const Agent& agent,
                     const BrainState& state,
                     float speed,
                     const Vec2& here,
                     const PointsOfInterest& points_of_interest) {
    FlockPull pull;
    pull.home = flat(agent.home);
    pull.heading = aim_direction(agent);
    pull.radius_m = state.radius_m;
    pull.speed = speed;
    pull.weights = state.flock;
    if (!state.along.empty()) {
        std::array<Vec2, kMostStops> stops;
        const std::size_t count = std::min(state.along.size(), kMostStops);
        for (std::size_t i = 0; i < count; ++i) {
            stops[i] = points_of_interest.centre(state.along[i]);
        }
        pull.path = round_trip(std::span(stops.data(), count), here, kTrackShare * state.radius_m);
        pull.home = stops[0];
    }
    return pull;
}

bool walks(const Agent& agent) {
    return agent.timed ? agent.segment.speed > 0.0F : moving(agent);
}

bool moving(const Agent& agent) {
    return agent.aim.move_x != 0 || agent.aim.move_z != 0;
}

Vec2 aim_direction(const motion::InputCommand& aim) {
    const Vec2 move(aim.move_x, aim.move_z);
    return aim.move_x != 0 || aim.move_z != 0 ? Vec2(move / move.norm()) : Vec2(Vec2::Zero());
}

Vec2 aim_direction(const Agent& agent) {
    return aim_direction(agent.aim);
}

void restart_progress(Agent& agent, const Vec3& here, Tick now) {
    agent.anchor = here;
    agent.anchor_since = now;
}

/// A uniform point of the disc around home, as far as that lies in the world, that is not where it
/// stands already.
void pick_wander_target(Agent& agent, float radius, const Surroundings& around) {
    for (int attempt = 0; attempt < 8; ++attempt) {
        // Rejection from the square needs no trigonometry.
        Vec2 point = Vec2::Zero();
        do {
            point.x() = agent.rng.range(-1.0F, 1.0F);
            point.y() = agent.rng.range(-1.0F, 1.0F);
        } while (point.squaredNorm() > 1.0F);
        const Vec2 target = around.ai.world.nearest(flat(agent.home) + radius * point);
        agent.target = Vec3(target.x(), agent.home.y(), target.y());
        if ((flat(agent.target) - around.at).norm() > 2.0F * kArriveM) {
            break;
        }
    }
    restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
}

void begin_action(Agent& agent, const BrainState& state, const Surroundings& around) {
    agent.detour_until = 0;
    restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
    if (state.action == ActionKind::kWander) {
        pick_wander_target(agent, state.radius_m, around);
    } else if (state.action == ActionKind::kGuard) {
        agent.corner = kAtPost;
    } else if (state.action == ActionKind::kForage) {
        agent.corner = kBegins;
        agent.target = Vec3(around.at.x(), 0.0F, around.at.y());
    } else if (state.action == ActionKind::kFollowTrack) {
        begin_spline(agent, state, around);
    } else if (state.action == ActionKind::kFormUp) {
        agent.corner = kNoRank;
        agent.steps = 0;
        agent.target = around.ai.entities.position[around.self];
    } else if (state.action == ActionKind::kPatrol) {
        agent.corner = nearest_corner(agent, state.radius_m, around);
    }
}

DesiredVelocity desired_velocity(Agent& agent,
                                 const BrainState& state,
                                 float speed,
                                 const Surroundings& around) {
    switch (state.action) {
        case ActionKind::kIdle:
            return {};
        case ActionKind::kWander:
            return wander_velocity(agent, state, around);
        case ActionKind::kPatrol:
            return patrol_velocity(agent, state, around);
        case ActionKind::kChase:
            return prey_velocity(agent, state, around, 1.0F);
        case ActionKind::kFlee:
            return prey_velocity(agent, state, around, -1.0F);
        case ActionKind::kFlock:
            return flock_velocity(agent, state, speed, around);
        case ActionKind::kReturn:
            return return_velocity(agent, state, around);
        case ActionKind::kGo:
            return place_velocity(agent, state, around);
        case ActionKind::kFollow:
            return follow_velocity(agent, state, around);
        case ActionKind::kEscort:
            return escort_velocity(agent, state, around);
        case ActionKind::kGuard:
            return guard_velocity(agent, state, around);
        case ActionKind::kForage:
            return go_to(flat(agent.target), around.at);
        case ActionKind::kFollowTrack:
            return track_velocity(agent, state, around);
        case ActionKind::kFormUp:
            // An agent that keeps its place in a formation is steered elsewhere.
            return agent.ward ? go_to(flat(agent.target), around.body()) : DesiredVelocity();
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return {};
}

float goal_floor(const Agent& agent, const BrainState& state, const Surroundings& around) {
    const auto below = [&](float middle, TypeIndex type) {
        const motion::CharacterLimits& body = around.ai.types[type].character;
        return middle - body.radius - body.half_segment;
    };
    const TypeIndex own = around.ai.entities.type[around.self];
    const auto of = [&](EntityId whom) {
        const world::Row row = whom ? around.ai.entities.find(whom) : world::kNoRow;
        return row == world::kNoRow
                   ? below(agent.home.y(), own)
                   : below(around.ai.entities.position[row].y(), around.ai.entities.type[row]);
    };
    const auto of_prey = [&] {
        return agent.prey && !agent.noticed ? below(agent.known.y(), own) : of(agent.prey);
    };
    switch (state.action) {
        case ActionKind::kGo:
            return around.ai.points_of_interest.floor(state.place);
        case ActionKind::kChase:
        case ActionKind::kFlee:
            return of_prey();
        case ActionKind::kFollow:
        case ActionKind::kEscort:
            return agent.ward ? of(agent.ward) : of_prey();
        case ActionKind::kGuard:
            return agent.corner == kEngaged ? of_prey() : below(agent.home.y(), own);
        case ActionKind::kFormUp:
        case ActionKind::kFollowTrack:
        case ActionKind::kForage:
            return below(agent.target.y(), own);
        case ActionKind::kIdle:
        case ActionKind::kWander:
        case ActionKind::kPatrol:
        case ActionKind::kReturn:
        case ActionKind::kFlock:
            return below(agent.home.y(), own);
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return pathfinding::kOnGround;
}

void aim_along(Agent& agent, const BrainState& state, const Vec2& direction) {
    aim_along(agent, Pace{state.speed_factor * agent.band, state.sprint}, direction);
}

void aim_along(Agent& agent, const Pace& pace, const Vec2& direction) {
    aim_along(agent.aim, pace, direction);
}

void move_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction) {
    const float scale = kFullMove * std::clamp(pace.factor, 0.0F, 1.0F);
    aim.move_x = static_cast<std::int8_t>(std::lround(direction.x() * scale));
    aim.move_z = static_cast<std::int8_t>(std::lround(direction.y() * scale));
    aim.buttons = pace.sprint ? motion::kButtonSprint : 0;
}

void face_along(motion::InputCommand& aim, const Vec2& direction) {
    aim.yaw = yaw_of(direction);
}

void aim_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction) {
    move_along(aim, pace, direction);
    face_along(aim, direction);
}

float full_speed(const BrainState& state, const Surroundings& around) {
    const motion::CharacterLimits& limits =
        around.ai.types[around.ai.entities.type[around.self]].character;
    return limits.speed * state.speed_factor * (state.sprint ? limits.sprint_factor : 1.0F);
}

}  // namespace zoned::ai
