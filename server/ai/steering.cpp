#include "server/ai/steering.h"

#include "server/ai/flock.h"
#include "server/ai/policy_steering.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::ai {

namespace {

constexpr float kReaimFreshCos = 0.99452F;  ///< cos 6 degrees
constexpr float kReaimCos = 0.93969F;       ///< cos 20 degrees
constexpr float kReaimFlockCos = 0.98481F;  ///< cos 10 degrees: herds are many and may be sloppy
constexpr float kFullMove = 127.0F;
constexpr float kProgressM = 0.5F;
constexpr float kDetourS = 1.0F;
/// A standing returner sets out again only when pushed this far from home, m.
constexpr float kSetOutM = 2.0F;
/// A rubber band that has changed the speed by this part of full speed is worth a command.
constexpr float kBandChange = 0.05F;

/// Where an action wants to go now.
struct Wish {
    Vec2 direction = Vec2::Zero();  ///< need not have unit length; zero = stand still
    bool has_goal = false;          ///< progress means coming nearer to `goal`
    Vec2 goal = Vec2::Zero();
    float fresh_cos = kReaimFreshCos;  ///< re-aim at a decision when the cosine is below this
    bool keep = false;                 ///< nothing new: the aim stays
};

Vec2 flat(const Vec3& v) {
    return {v.x(), v.z()};
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

void begin(Mind& mind, const State& state, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    mind.detour_until = 0;
    restart_progress(mind, here, around.now);
    if (state.action == ActionKind::kWander) {
        pick_wander_target(mind, state.radius_m, around);
    } else if (state.action == ActionKind::kPatrol) {
        mind.corner = nearest_corner(mind, state.radius_m, flat(here));
    }
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
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return {};
}

void stand(Mind& mind, const Surroundings& around) {
    mind.aim = motion::InputCommand{};
    mind.aim.yaw = around.entities.yaw[around.self];
    restart_progress(mind, around.entities.position[around.self], around.now);
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

/// True when it has walked for kPatienceS without getting anywhere.
bool blocked(Mind& mind, const Wish& wish, float speed, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    const float progress =
        wish.has_goal ? (wish.goal - flat(mind.anchor)).norm() - (wish.goal - flat(here)).norm()
                      : (flat(here) - flat(mind.anchor)).norm();
    // A slow walker needs to show less.
    if (progress >= std::min(kProgressM, 0.25F * kPatienceS * speed)) {
        restart_progress(mind, here, around.now);
        return false;
    }
    return static_cast<float>(around.now - mind.anchor_since) * around.dt >= kPatienceS;
}

/// What is in the way is passed by another target, the next corner, or a walk along it.
void get_around(Mind& mind, const State& state, const Vec2& direction, const Surroundings& around) {
    if (state.action == ActionKind::kWander) {
        pick_wander_target(mind, state.radius_m, around);
        return;
    }
    restart_progress(mind, around.entities.position[around.self], around.now);
    if (state.action == ActionKind::kPatrol) {
        mind.corner = static_cast<std::uint8_t>((mind.corner + 1) & 3);
        return;
    }
    const float side = (mind.rng.next() & 1U) != 0 ? 1.0F : -1.0F;
    aim_along(mind, state, Vec2(side * direction.y(), -side * direction.x()));
    mind.detour_until = around.now + std::max<Tick>(1, std::lround(kDetourS / around.dt));
}

bool needs_aim(const Mind& mind,
               const State& state,
               const Wish& wish,
               const Vec2& direction,
               bool entered) {
    if (entered || !moving(mind)) {
        return true;
    }
    const float share = std::min(1.0F, state.speed_factor * mind.band);
    const float aimed = Vec2(mind.aim.move_x, mind.aim.move_z).norm() / kFullMove;
    if (state.rubber_band && std::abs(aimed - share) > kBandChange) {
        return true;
    }
    const float cosine = aim_direction(mind).dot(direction);
    return cosine < (mind.fresh ? wish.fresh_cos : kReaimCos);
}

float full_speed(const State& state, const Surroundings& around) {
    const motion::CharacterLimits& limits =
        around.types[around.entities.type[around.self]].character;
    return limits.speed * state.speed_factor * (state.sprint ? limits.sprint_factor : 1.0F);
}

}  // namespace

void steer(Mind& mind, const CompiledMachine& machine, const Surroundings& around) {
    const State& state = machine.states[mind.doing];
    const bool entered = mind.entered;
    if (entered) {
        begin(mind, state, around);
        mind.entered = false;
    }
    follow_band(mind, state, around);
    if (const auto* choice = std::get_if<PolicyChoice>(&state.choice)) {
        steer_by_policy(mind, state, *choice, around);
        mind.fresh = false;
        return;
    }
    if (around.now < mind.detour_until) {
        mind.fresh = false;
        return;
    }
    const float speed = std::max(0.01F, full_speed(state, around));
    const Wish wish = wish_of(mind, state, speed, around);
    const float length = wish.keep ? 0.0F : wish.direction.norm();
    if (wish.keep) {
        if (blocked(mind, wish, speed, around)) {
            get_around(mind, state, aim_direction(mind), around);
        }
    } else if (!(length > 0.0F) || !std::isfinite(length)) {
        stand(mind, around);
    } else {
        const Vec2 direction = wish.direction / length;
        if (needs_aim(mind, state, wish, direction, entered)) {
            if (!moving(mind)) {
                restart_progress(mind, around.entities.position[around.self], around.now);
            }
            aim_along(mind, state, direction);
        }
        if (blocked(mind, wish, speed, around)) {
            get_around(mind, state, direction, around);
        }
    }
    mind.fresh = false;
}

}  // namespace zoned::ai
