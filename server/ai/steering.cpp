#include "server/ai/steering.h"

#include "server/ai/policy_steering.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr float kReaimCos = 0.93969F;  ///< cos 20 degrees
constexpr float kProgressM = 0.5F;
constexpr float kDetourS = 1.0F;
/// A rubber band that has changed the speed by this part of full speed is worth a command.
constexpr float kBandChange = 0.05F;

void stand(Mind& mind, const Surroundings& around) {
    mind.aim = motion::InputCommand{};
    mind.aim.yaw = around.entities.yaw[around.self];
    restart_progress(mind, around.entities.position[around.self], around.now);
}

/// True when it has walked for kPatienceS without getting anywhere.
bool blocked(Mind& mind, const Wish& wish, float speed, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    const float progress = wish.has_goal
                               ? (wish.goal - Vec2(mind.anchor.x(), mind.anchor.z())).norm() -
                                     (wish.goal - around.here()).norm()
                               : (around.here() - Vec2(mind.anchor.x(), mind.anchor.z())).norm();
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

/// Who is far steers every few ticks, taking turns by entity id so that the load is even over
/// ticks, and when its goal is reached: late turns would add up.
Tick next_steering(const Mind& mind, const Wish& wish, float speed, const Surroundings& around) {
    const Tick turn = (around.now + static_cast<Tick>(mind.entity.value)) % kFarPeriod;
    const Tick period = kFarPeriod - turn;
    if (!wish.has_goal) {
        return around.now + period;
    }
    const float way = wish.direction.norm() - kArriveM;
    const auto ticks = static_cast<Tick>(std::clamp(way / (speed * around.dt), 0.0F, 8.0F));
    return around.now + std::clamp<Tick>(ticks, 1, period);
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

}  // namespace

void steer(Mind& mind, const CompiledMachine& machine, const Surroundings& around) {
    const State& state = machine.states[mind.doing];
    const bool entered = mind.entered;
    if (entered) {
        begin_deed(mind, state, around);
        mind.entered = false;
    }
    follow_band(mind, state, around);
    if (const auto* choice = std::get_if<PolicyChoice>(&state.choice)) {
        mind.next_steering = around.now + 1;
        steer_by_policy(mind, machine, state, *choice, around);
        mind.fresh = false;
        return;
    }
    if (around.now < mind.detour_until) {
        mind.fresh = false;
        return;
    }
    const float speed = std::max(0.01F, full_speed(state, around));
    const Wish wish = wish_of(mind, state, speed, around);
    mind.next_steering = next_steering(mind, wish, speed, around);
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
