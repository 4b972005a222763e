#include "server/ai/wish.h"

#include "server/ai/flock.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::ai {

namespace {

constexpr float kReaimFreshCos = 0.99452F;  ///< cos 6 degrees
constexpr float kReaimFlockCos = 0.98481F;  ///< cos 10 degrees: herds are many and may be sloppy
/// A standing returner sets out again only when pushed this far from home, m.
constexpr float kSetOutM = 2.0F;

Vec2 flat(const Vec3& v) {
    return {v.x(), v.z()};
}

Vec2 corner_of(const Mind& mind, float radius, std::uint8_t corner) {
    const bool right = corner == 1 || corner == 2;
    const bool up = corner >= 2;
    return flat(mind.home) + Vec2(right ? radius : -radius, up ? radius : -radius);
}

std::uint8_t nearest_corner(const Mind& mind, float radius, const Vec2& here) {
    std::uint8_t best = 0;
    for (std::uint8_t corner = 1; corner < 4; ++corner) {
        if ((corner_of(mind, radius, corner) - here).squaredNorm() <
            (corner_of(mind, radius, best) - here).squaredNorm()) {
            best = corner;
        }
    }
    return best;
}

Wish go_to(const Vec2& goal, const Vec2& here) {
    Wish wish;
    wish.has_goal = true;
    wish.goal = goal;
    wish.direction = goal - here;
    return wish;
}

Wish wish_wander(Mind& mind, const State& state, const Surroundings& around) {
    const Vec2 here = flat(around.entities.position[around.self]);
    if ((flat(mind.target) - here).norm() < kArriveM) {
        pick_wander_target(mind, state.radius_m, around);
    }
    return go_to(flat(mind.target), here);
}

Wish wish_patrol(Mind& mind, const State& state, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    Vec2 goal = corner_of(mind, state.radius_m, mind.corner);
    if ((goal - flat(here)).norm() < kArriveM) {
        mind.corner = static_cast<std::uint8_t>((mind.corner + 1) & 3);
        restart_progress(mind, here, around.now);
        goal = corner_of(mind, state.radius_m, mind.corner);
    }
    return go_to(goal, flat(here));
}

Wish wish_return(const Mind& mind, const Surroundings& around) {
    const Vec2 here = flat(around.entities.position[around.self]);
    const float distance = (flat(mind.home) - here).norm();
    return distance < (moving(mind) ? kArriveM : kSetOutM) ? Wish() : go_to(flat(mind.home), here);
}

/// A spot is left only when pushed away from it, as a home is.
Wish wish_place(const Mind& mind, const State& state, const Surroundings& around) {
    const Vec2 spot = around.places.spot(state.place, mind.entity);
    const Vec2 here = around.here();
    const float distance = (spot - here).norm();
    return distance < (moving(mind) ? kArriveM : kSetOutM) ? Wish() : go_to(spot, here);
}

/// Chase and flee: `sign` is +1 towards, -1 away.
Wish wish_prey(const Mind& mind, const Surroundings& around, float sign) {
    const world::Row prey = mind.prey ? around.entities.find(mind.prey) : world::kNoRow;
    if (prey == world::kNoRow || around.entities.has(prey, world::kHidden)) {
        return {};
    }
    const Vec2 towards =
        flat(around.entities.position[prey]) - flat(around.entities.position[around.self]);
    const float distance = towards.norm();
    Wish wish;
    if (sign > 0.0F && distance < (moving(mind) ? kChaseStopM : kChaseFollowM)) {
        return wish;
    }
    // On the very spot of its prey any direction leads away.
    wish.direction = distance < 1e-4F ? Vec2(1.0F, 0.0F) : Vec2(sign * towards);
    return wish;
}

Wish wish_flock(Mind& mind, const State& state, float speed, const Surroundings& around) {
    Wish wish;
    wish.keep = !mind.fresh && moving(mind);
    if (wish.keep) {
        return wish;
    }
    FlockQuery query;
    query.self = around.self;
    query.home = flat(mind.home);
    query.heading = aim_direction(mind);
    query.radius_m = state.radius_m;
    query.speed = speed;
    wish.direction = flock_heading(around.entities, around.grid, query);
    wish.fresh_cos = kReaimFlockCos;
    if (wish.direction.norm() < 1e-3F) {
        // Balanced: walk on, or set out anywhere.
        wish.keep = moving(mind);
        wish.direction = Vec2(mind.rng.range(-1.0F, 1.0F), 1.0F);
    }
    return wish;
}

}  // namespace

Wish::Wish() : fresh_cos(kReaimFreshCos) {
}

bool moving(const Mind& mind) {
    return mind.aim.move_x != 0 || mind.aim.move_z != 0;
}

Vec2 aim_direction(const Mind& mind) {
    const Vec2 move(mind.aim.move_x, mind.aim.move_z);
    return moving(mind) ? Vec2(move / move.norm()) : Vec2::Zero();
}

void restart_progress(Mind& mind, const Vec3& here, Tick now) {
    mind.anchor = here;
    mind.anchor_since = now;
}

/// A uniform point of the disc around home that is not where it stands already.
void pick_wander_target(Mind& mind, float radius, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    for (int attempt = 0; attempt < 8; ++attempt) {
        // Rejection from the square needs no trigonometry.
        Vec2 point = Vec2::Zero();
        do {
            point.x() = mind.rng.range(-1.0F, 1.0F);
            point.y() = mind.rng.range(-1.0F, 1.0F);
        } while (point.squaredNorm() > 1.0F);
        mind.target = mind.home + Vec3(point.x() * radius, 0.0F, point.y() * radius);
        if ((flat(mind.target) - flat(here)).norm() > 2.0F * kArriveM) {
            break;
        }
    }
    restart_progress(mind, here, around.now);
}

void begin_deed(Mind& mind, const State& state, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    mind.detour_until = 0;
    restart_progress(mind, here, around.now);
    if (state.action == ActionKind::kWander) {
        pick_wander_target(mind, state.radius_m, around);
    } else if (state.action == ActionKind::kPatrol) {
        mind.corner = nearest_corner(mind, state.radius_m, flat(here));
    }
}

Wish wish_of(Mind& mind, const State& state, float speed, const Surroundings& around) {
    switch (state.action) {
        case ActionKind::kIdle:
            return {};
        case ActionKind::kWander:
            return wish_wander(mind, state, around);
        case ActionKind::kPatrol:
            return wish_patrol(mind, state, around);
        case ActionKind::kChase:
            return wish_prey(mind, around, 1.0F);
        case ActionKind::kFlee:
            return wish_prey(mind, around, -1.0F);
        case ActionKind::kFlock:
            return wish_flock(mind, state, speed, around);
        case ActionKind::kReturn:
            return wish_return(mind, around);
        case ActionKind::kGo:
            return wish_place(mind, state, around);
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return {};
}

/// `direction` has unit length.
void aim_along(Mind& mind, const State& state, const Vec2& direction) {
    const float scale = kFullMove * std::clamp(state.speed_factor * mind.band, 0.0F, 1.0F);
    mind.aim.move_x = static_cast<std::int8_t>(std::lround(direction.x() * scale));
    mind.aim.move_z = static_cast<std::int8_t>(std::lround(direction.y() * scale));
    // Turning +z about +y by an angle gives (sin, cos) in (x, z).
    const float turns =
        std::atan2(direction.x(), direction.y()) / (2.0F * std::numbers::pi_v<float>);
    mind.aim.yaw = static_cast<std::uint16_t>(std::lround(turns * 65536.0F) & 0xFFFF);
    mind.aim.buttons = state.sprint ? motion::kButtonSprint : 0;
}

float full_speed(const State& state, const Surroundings& around) {
    const motion::CharacterLimits& limits =
        around.types[around.entities.type[around.self]].character;
    return limits.speed * state.speed_factor * (state.sprint ? limits.sprint_factor : 1.0F);
}

}  // namespace zoned::ai
