#include "server/ai/walk.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

const motion::CharacterLimits& limits_of(const Surroundings& around) {
    return around.types[around.entities.type[around.self]].character;
}

/// A walk by a timetable leaves so much of full speed unused that a body can make up for what
/// commands, whose headings and speeds are few, and others on its way have cost it.
constexpr float kUsed = 0.98F;

/// What the mind's command makes of a character, m/s.
float commanded_speed(const Mind& mind, const motion::CharacterLimits& limits) {
    const float share = Vec2(mind.aim.move_x, mind.aim.move_z).norm() / kFullMove;
    const bool sprints = (mind.aim.buttons & motion::kButtonSprint) != 0;
    return std::min(share, 1.0F) * limits.speed * (sprints ? limits.sprint_factor : 1.0F);
}

/// Stands where it will have come to a halt.
void halt(Mind& mind, const Surroundings& around, const Vec2& velocity) {
    mind.leg = leg_from(
        around.at, velocity, Vec2::Zero(), 0.0F, limits_of(around).acceleration, around.now - 1);
    mind.aim.move_x = mind.aim.move_z = 0;
    mind.aim.buttons = 0;
}

/// Where a command leads that is held: its heading is one of few, so that it passes the goal a
/// little to the side; the length to where the goal counts as reached. Where it would pass by
/// farther than that, corrections on the way lead it straight to the goal.
void head_for(const Vec2& goal, const Vec2& heading, Leg& leg) {
    const Vec2 way = goal - leg.from;
    const float along = way.dot(heading);
    const float aside2 = std::max(0.0F, way.squaredNorm() - along * along);
    if (aside2 < 0.25F * kArriveM * kArriveM) {
        leg.length = along - std::sqrt(kArriveM * kArriveM - aside2);
    } else {
        leg.direction = way / way.norm();
        leg.length = way.norm() - kArriveM;
    }
    leg.length = std::max(leg.length, 1e-3F);
    leg.goal = goal;
}

/// The command that leads to `goal`, and the leg that it makes. Getting up to speed, or turning,
/// leads a little aside: the second try allows for that.
void set_out(Mind& mind,
             const State& state,
             const Surroundings& around,
             const Vec2& goal,
             const Vec2& velocity) {
    const float acceleration = limits_of(around).acceleration;
    Vec2 way = goal - around.at;
    for (int attempt = 0; attempt < 2; ++attempt) {
        aim_along(mind,
                  Pace{std::min(state.speed_factor * mind.band, kUsed), state.sprint},
                  way / way.norm());
        const float speed = commanded_speed(mind, limits_of(around));
        if (!(speed > 0.0F)) {
            halt(mind, around, velocity);
            return;
        }
        const Vec2 heading = aim_direction(mind);
        mind.leg = leg_from(around.at, velocity, heading, speed, acceleration, around.now - 1);
        const Vec2 rest = goal - mind.leg.from;
        if (!(rest.norm() > kArriveM)) {
            break;
        }
        way = rest;
    }
    head_for(goal, aim_direction(mind), mind.leg);
}

}  // namespace

Vec2 whereabouts(const Mind& mind, const Vec2& body, Tick now, float dt) {
    if (!mind.timed) {
        return body;
    }
    const Vec2 at = position_at(mind.leg, now - 1, dt);
    const bool astray = mind.tier == Tier::kAwake && (at - body).norm() > kAstrayM;
    return astray ? body : at;
}

bool goes_by_legs(const Mind& mind, const State& state) {
    switch (state.action) {
        case ActionKind::kIdle:
        case ActionKind::kWander:
        case ActionKind::kPatrol:
        case ActionKind::kReturn:
        case ActionKind::kGo:
            return !state.rubber_band;
        case ActionKind::kFlock:
        case ActionKind::kFormUp:
            return false;
        case ActionKind::kChase:
        case ActionKind::kFlee:
        case ActionKind::kFollow:
        case ActionKind::kEscort:
        case ActionKind::kGuard:
            return !state.rubber_band && !mind.prey && !mind.ward;
    }
    return false;
}

void start_leg(Mind& mind, const Surroundings& around) {
    const Vec3& v = around.entities.velocity[around.self];
    const Vec2 velocity(v.x(), v.z());
    const float speed = velocity.norm();
    mind.leg = leg_from(around.body(),
                        velocity,
                        speed > 0.0F ? Vec2(velocity / speed) : Vec2(Vec2::Zero()),
                        speed,
                        0.0F,
                        around.now - 1);
    mind.timed = true;
}

void plan_leg(Mind& mind, const State& state, bool entered, const Surroundings& around) {
    const Wish wish = state.action == ActionKind::kFlock
                          ? Wish()
                          : wish_of(mind, state, full_speed(state, around), around);
    const Vec2 velocity = velocity_at(mind.leg, around.now - 1, around.dt);
    if (!wish.has_goal || !(wish.direction.norm() > 1e-3F)) {
        if (mind.leg.speed > 0.0F) {
            halt(mind, around, velocity);
        }
        return;
    }
    if (!entered && mind.leg.length > 0.0F && wish.goal == mind.leg.goal) {
        return;
    }
    set_out(mind, state, around, wish.goal, velocity);
}

}  // namespace zoned::ai
