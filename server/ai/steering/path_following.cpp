#include "server/ai/steering/path_following.h"

#include "server/ai/steering/forage_walk.h"
#include "server/ai/steering/spline_following.h"
#include "server/ai/steering/terrain_walk.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

const motion::CharacterLimits& limits_of(const Surroundings& around) {
    return around.ai.types[around.ai.entities.type[around.self]].character;
}

/// A timetable leaves this much of full speed unused. The body needs the rest to make up for coarse
/// commands (few headings and speeds) and for others that hold it up.
constexpr float kUsed = 0.98F;
/// A corner of a path counts as passed within this distance, m; a walker aims nearer.
constexpr float kCornerM = 0.5F;
constexpr float kTurnM = 0.2F;
/// A segment that ends this much farther from its goal than it has to was cut short, m.
constexpr float kShort_m = 0.25F;
/// A body that is held up is this far at least from where its timetable has it, m.
constexpr float kHeldUp_m = 0.01F;
/// An agent without a map walks this far at most along an obstacle before it tries again, m.
constexpr float kAside_m = 8.0F;
/// An agent without a path looks again after this long, s. An agent that waits for an answer looks
/// again sooner.
constexpr float kLookAgain_s = 5.0F;
constexpr float kAskAgain_s = 0.25F;

Vec2 flat_of(pathfinding::Spot spot) {
    return {spot.x, spot.z};
}

pathfinding::Spot spot_of(const Vec2& at) {
    return {at.x(), at.y()};
}

/// The speed that a character gets from the agent's command, m/s.
float commanded_speed(const Agent& agent, const motion::CharacterLimits& limits) {
    const float share = Vec2(agent.aim.move_x, agent.aim.move_z).norm() / kFullMove;
    const bool sprints = (agent.aim.buttons & motion::kButtonSprint) != 0;
    return std::min(share, 1.0F) * limits.speed * (sprints ? limits.sprint_factor : 1.0F);
}

/// Stands where it will have come to a halt.
void halt(Agent& agent, const Surroundings& around, const Vec2& velocity) {
    agent.segment = segment_from(
        around.at, velocity, Vec2::Zero(), 0.0F, limits_of(around).acceleration, around.ai.now - 1);
    agent.aim.move_x = agent.aim.move_z = 0;
    agent.aim.buttons = 0;
}

void look_again(Agent& agent, float after_s, const Surroundings& around) {
    agent.again_at = around.ai.now + std::max<Tick>(1, std::lround(after_s / around.ai.dt));
}

/// Computes where a held command leads. Its heading is one of few, so it passes the goal a little
/// to the side. The length ends where the goal is within `near_m` and counts as reached. If it
/// would pass farther off, corrections under way lead it straight to the goal.
void head_for(const Vec2& goal, float near_m, const Vec2& heading, PathSegment& segment) {
    const Vec2 path = goal - segment.from;
    const float along = path.dot(heading);
    const float aside2 = std::max(0.0F, path.squaredNorm() - along * along);
    if (aside2 < 0.25F * near_m * near_m) {
        segment.length = along - std::sqrt(near_m * near_m - aside2);
    } else {
        segment.direction = path / path.norm();
        segment.length = path.norm() - near_m;
    }
    segment.length = std::max(segment.length, 1e-3F);
}

/// The command that leads to within `near_m` of `goal`, and the segment that it makes. Getting up
/// to speed, or turning, leads a little aside: the second try allows for that.
void set_out(Agent& agent,
             const BrainState& state,
             const Surroundings& around,
             const Vec2& goal,
             float near_m) {
    const Vec2 velocity = velocity_at(agent.segment, around.ai.now - 1, around.ai.dt);
    const Vec2 whole = agent.segment.goal;
    const float acceleration = limits_of(around).acceleration;
    const Pace pace{std::min(state.speed_factor * agent.band, around.all_out ? 1.0F : kUsed),
                    state.sprint};
    Vec2 path = goal - around.at;
    Vec2 towards = Vec2::Zero();
    for (int attempt = 0; attempt < 2; ++attempt) {
        towards = path / path.norm();
        move_along(agent.aim, pace, towards);
        const float speed = commanded_speed(agent, limits_of(around));
        if (!(speed > 0.0F)) {
            face_along(agent.aim, towards);
            halt(agent, around, velocity);
            return;
        }
        const Vec2 heading = aim_direction(agent);
        agent.segment =
            segment_from(around.at, velocity, heading, speed, acceleration, around.ai.now - 1);
        const Vec2 rest = goal - agent.segment.from;
        if (!(rest.norm() > near_m)) {
            break;
        }
        path = rest;
    }
    face_along(agent.aim, towards);
    head_for(goal, near_m, aim_direction(agent), agent.segment);
    agent.segment.goal = whole;
    agent.again_at = kNever;
}

bool has_map(const Surroundings& around) {
    return around.ai.paths != nullptr &&
           around.ai.paths->plans_for(around.ai.entities.type[around.self]);
}

/// True if the entity of a suspended agent without a map could not be placed where the timetable
/// says.
bool is_held_up(const Agent& agent, const BrainState& state, const Surroundings& around) {
    return agent.tier == Tier::kSuspended && !has_map(around) && !goes_by_cells(agent, state) &&
           (around.at - around.body()).norm() > kHeldUp_m;
}

/// A body has come to a halt where something holds it up: so has its timetable.
void stand_at(const Vec2& place, Agent& agent, Surroundings& around) {
    const Vec2 goal = agent.segment.goal;
    around.at = place;
    agent.segment = segment_from(place, Vec2::Zero(), Vec2::Zero(), 0.0F, 0.0F, around.ai.now - 1);
    agent.segment.goal = goal;
}

/// A straight walk from the place where the agent is, at its height.
LookAhead look_from(const Vec2& at, const Vec2& way, const Surroundings& around) {
    Vec3 here = around.ai.entities.position[around.self];
    here.x() = at.x();
    here.z() = at.y();
    const float length = way.norm();
    return length > 0.0F ? look_ahead(here,
                                      way / length,
                                      length,
                                      limits_of(around),
                                      around.ai.statics,
                                      around.ai.now)
                         : LookAhead{0.0F, 0.0F, here};
}

/// Where the segment has come to its speed, and goes straight.
Vec2 after_bend(const PathSegment& segment) {
    return segment.from + segment.direction * (segment.speed * segment.bend_s);
}

/// For an agent without a map: who cannot make its turn sets out from rest, and its segment ends
/// where something solid would hold it up. `again` makes the segment anew.
template <class SetOut>
void stop_at_obstacles(Agent& agent, Surroundings& around, const SetOut& again) {
    const motion::StaticGeometry& statics = around.ai.statics;
    const bool bare =
        statics.boxes().empty() && statics.doors().empty() && statics.surfaces().empty();
    if (bare || !(agent.segment.speed > 0.0F)) {
        return;
    }
    Vec2 begin = after_bend(agent.segment);
    const Vec2 turn = begin - around.at;
    if (look_from(around.at, turn, around).length < turn.norm()) {
        stand_at(around.at, agent, around);
        again();
        begin = around.at;
    }
    PathSegment& segment = agent.segment;
    const float begun = (begin - segment.from).dot(segment.direction);
    const float way = segment.length - begun;
    if (way > 0.0F) {
        const float free = look_from(begin, segment.direction * way, around).length;
        segment.length = free < way ? std::max(begun + free, 1e-3F) : segment.length;
    }
}

/// True if the segment ends at something solid and not at its goal.
bool stopped_short(const Agent& agent, const BrainState& state, const Surroundings& around) {
    const PathSegment& segment = agent.segment;
    const float near_m = state.action == ActionKind::kForage
                             ? around.ai.points_of_interest.radius_m(state.forage->nest)
                             : 0.0F;
    return !agent.on_path && !goes_by_cells(agent, state) && segment.length > 0.0F &&
           (end_of(segment) - segment.goal).norm() > std::max(near_m, kArriveM) + kShort_m;
}

/// A place beside an obstacle ahead, on either side.
Vec2 place_aside(Agent& agent, const Vec2& ahead, const Surroundings& around) {
    const float side = (agent.rng.next() & 1U) != 0 ? 1.0F : -1.0F;
    return around.at +
           Vec2(side * ahead.y(), -side * ahead.x()) * agent.rng.range(kArriveM + 1.0F, kAside_m);
}

bool has_path(const Agent& agent, const Surroundings& around) {
    return agent.on_path && around.ai.paths != nullptr &&
           around.ai.paths->has(around.slot, agent.entity);
}

/// A straight walk is over within this distance of its goal, m.
float reach_of(const Agent& agent,
               const BrainState& state,
               const DesiredVelocity& desired,
               const Surroundings& around) {
    if (state.action != ActionKind::kForage) {
        return kArriveM;
    }
    // Home is all of the nest.
    return goes_by_cells(agent, state)
               ? kAtCell * state.forage->cell_m
               : std::max(kTurnM,
                          desired.direction.norm() -
                              around.ai.points_of_interest.outside(state.forage->nest, around.at));
}

/// True if the agent has reached the end of its path.
bool path_is_over(const Agent& agent, const Surroundings& around) {
    if (!has_path(agent, around)) {
        return false;
    }
    const pathfinding::PathResult path = around.ai.paths->answer(around.slot);
    return !path.waiting &&
           (path.corners.empty() || (flat_of(path.corners.back()) - around.at).norm() < kCornerM);
}

}  // namespace

bool goes_by_segments(const Agent& agent, const BrainState& state) {
    const bool banded = state.rubber_band && (agent.prey || agent.band != 1.0F);
    switch (state.action) {
        case ActionKind::kFollowTrack:
            return true;
        case ActionKind::kIdle:
        case ActionKind::kWander:
        case ActionKind::kPatrol:
        case ActionKind::kReturn:
        case ActionKind::kGo:
        case ActionKind::kForage:
            return !banded;
        case ActionKind::kFlock:
        case ActionKind::kFormUp:
            return false;
        case ActionKind::kChase:
        case ActionKind::kFlee:
        case ActionKind::kFollow:
        case ActionKind::kEscort:
        case ActionKind::kGuard:
            return !banded && !agent.prey && !agent.ward;
    }
    return false;
}

void start_segment(Agent& agent, const Surroundings& around) {
    const Vec3& v = around.ai.entities.velocity[around.self];
    const Vec2 velocity(v.x(), v.z());
    const float speed = velocity.norm();
    agent.segment = segment_from(around.body(),
                                 velocity,
                                 speed > 0.0F ? Vec2(velocity / speed) : Vec2(Vec2::Zero()),
                                 speed,
                                 0.0F,
                                 around.ai.now - 1);
    agent.timed = true;
    agent.on_path = false;
}

void follow_path(Agent& agent, const BrainState& state, const Surroundings& around) {
    const Vec2 next = flat_of(around.ai.paths->heading(around.slot, spot_of(around.at), kCornerM));
    const bool last = (next - agent.segment.goal).norm() < kTurnM;
    const float near_m = last ? kArriveM : kTurnM;
    if ((next - around.at).norm() > near_m) {
        set_out(agent, state, around, next, near_m);
        return;
    }
    const Vec2 goal = agent.segment.goal;
    halt(agent, around, velocity_at(agent.segment, around.ai.now - 1, around.ai.dt));
    agent.segment.goal = goal;
    look_again(agent, kAskAgain_s, around);
}

bool plan_segment(Agent& agent, const BrainState& state, bool entered, const Surroundings& from) {
    Surroundings around = from;
    const bool stopped =
        segment_is_over(agent, around.ai.now, around.ai.dt) && stopped_short(agent, state, around);
    const Vec2 ahead = agent.segment.direction;
    if (is_held_up(agent, state, around)) {
        stand_at(around.body(), agent, around);
    } else if (stopped) {
        stand_at(end_of(agent.segment), agent, around);
    }
    // At an obstacle it chooses another target, or walks aside.
    const bool has_others =
        state.action == ActionKind::kWander || state.action == ActionKind::kPatrol;
    around.there = !entered && (path_is_over(agent, around) || (stopped && has_others));
    if (state.action == ActionKind::kFollowTrack && follow_spline(agent, state, around)) {
        return false;
    }
    const DesiredVelocity desired =
        desired_velocity(agent, state, full_speed(state, around), around);
    if (!desired.has_goal || !(desired.direction.norm() > 1e-3F)) {
        if (agent.segment.speed > 0.0F) {
            halt(agent, around, velocity_at(agent.segment, around.ai.now - 1, around.ai.dt));
        }
        agent.on_path = false;
        agent.again_at = kNever;
        if (desired.far || state.action == ActionKind::kForage) {
            look_again(agent, desired.far ? kLookAgain_s : kAskAgain_s, around);
        }
        return false;
    }
    const bool same = !entered && desired.goal == agent.segment.goal;
    const bool by_cells = goes_by_cells(agent, state);
    if (same && !by_cells && has_path(agent, around)) {
        follow_path(agent, state, around);
        return false;
    }
    if (!by_cells && has_map(around)) {
        agent.segment.goal = desired.goal;
        return true;
    }
    float reach = reach_of(agent, state, desired, around);
    const bool aside = same && stopped;
    if (!same || aside || agent.segment.length == 0.0F) {
        const Vec2 goal = aside ? place_aside(agent, ahead, around) : desired.goal;
        reach = aside ? kTurnM : reach;
        agent.on_path = false;
        const auto walk = [&] {
            agent.segment.goal = goal;
            set_out(agent, state, around, goal, reach);
        };
        walk();
        if (!by_cells) {
            stop_at_obstacles(agent, around, walk);
        }
    }
    return false;
}

bool turn_to_path(Agent& agent,
                  const BrainState& state,
                  DesiredVelocity& desired,
                  const Surroundings& around) {
    const TypeIndex type = around.ai.entities.type[around.self];
    const pathfinding::Spot body = spot_of(around.body());
    if (!desired.seeks || around.ai.paths == nullptr || !around.ai.paths->plans_for(type)) {
        agent.on_path = false;
        return false;
    }
    const float feet_m = limits_of(around).radius + limits_of(around).half_segment;
    const PathHeights heights{around.ai.entities.position[around.self].y() - feet_m,
                              goal_floor(agent, state, around)};
    if (around.ai.paths->straight(type, body, spot_of(desired.goal), heights)) {
        agent.on_path = false;
        return false;
    }
    const bool asks = agent.fresh || !has_path(agent, around);
    if (has_path(agent, around)) {
        const Vec2 next = flat_of(around.ai.paths->heading(around.slot, body, kCornerM));
        desired.direction = next - around.body();
        // Progress is measured towards the corner.
        desired.goal = next;
    }
    return asks;
}

}  // namespace zoned::ai
