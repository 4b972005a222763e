#include "server/ai/steering.h"

#include "server/ai/form_up.h"
#include "server/ai/policy_steering.h"
#include "server/ai/walk.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

namespace {

constexpr float kReaimCos = 0.93969F;  ///< cos 20 degrees
constexpr float kProgressM = 0.5F;
constexpr float kDetourS = 1.0F;
/// A rubber band that has changed the speed by this part of full speed is worth a command.
constexpr float kBandChange = 0.05F;
/// A blend that wants less than this share of walking speed stands; one that wants so much more or
/// less than it goes changes its pace.
constexpr float kBlendStands = 0.05F;
constexpr float kBlendPace = 0.1F;
/// Whose body is so far from where its segment says is put right, m: commands are worth a
/// publication.
constexpr float kOffSegmentM = 0.2F;
/// In what time at least, s: where the segment has come by then, or at its end.
constexpr float kPutRightS = 0.5F;
/// Who falls faster, m/s, has left its floor: some 0.2 m below it.
constexpr float kFalls = 2.0F;

void stand(Mind& mind, const Surroundings& around) {
    mind.aim = motion::InputCommand{};
    mind.aim.yaw = around.entities.yaw[around.self];
    restart_progress(mind, around.entities.position[around.self], around.now);
}

/// True when it has walked for kPatienceS without getting anywhere; `goal`: without one, anywhere
/// counts.
bool blocked(Mind& mind, const Vec2* goal, float speed, const Surroundings& around) {
    const Vec3& here = around.entities.position[around.self];
    const Vec2 anchor(mind.anchor.x(), mind.anchor.z());
    const float progress = goal != nullptr
                               ? (*goal - anchor).norm() - (*goal - around.body()).norm()
                               : (around.body() - anchor).norm();
    // A slow walker needs to show less.
    if (progress >= std::min(kProgressM, 0.25F * kPatienceS * speed)) {
        restart_progress(mind, here, around.now);
        return false;
    }
    return static_cast<float>(around.now - mind.anchor_since) * around.dt >= kPatienceS;
}

bool blocked(Mind& mind, const DesiredVelocity& desired, float speed, const Surroundings& around) {
    return blocked(mind, desired.has_goal ? &desired.goal : nullptr, speed, around);
}

/// Walks across its path for a while.
void step_aside(Mind& mind, const Pace& pace, const Vec2& direction, const Surroundings& around) {
    const float side = (mind.rng.next() & 1U) != 0 ? 1.0F : -1.0F;
    aim_along(mind, pace, Vec2(side * direction.y(), -side * direction.x()));
    mind.detour_until = around.now + std::max<Tick>(1, std::lround(kDetourS / around.dt));
    mind.timed = false;
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
    step_aside(mind, {state.speed_factor * mind.band, state.sprint}, direction, around);
}

Tick next_steering(const Mind& mind,
                   const DesiredVelocity& desired,
                   float speed,
                   const Surroundings& around) {
    const Tick period = next_turn(mind, around.now) - around.now;
    if (!desired.has_goal) {
        return around.now + period;
    }
    const float path = desired.direction.norm() - kArriveM;
    const auto ticks = static_cast<Tick>(std::clamp(path / (speed * around.dt), 0.0F, 8.0F));
    return around.now + std::clamp<Tick>(ticks, 1, period);
}

/// True where the heading is off by too much.
bool turns(const Mind& mind, const DesiredVelocity& desired, const Vec2& direction, bool entered) {
    if (entered || !moving(mind)) {
        return true;
    }
    const float cosine = aim_direction(mind).dot(direction);
    return cosine < (mind.fresh ? desired.fresh_cos : kReaimCos);
}

/// The same, or the speed.
bool needs_aim(const Mind& mind,
               const State& state,
               const DesiredVelocity& desired,
               const Vec2& direction,
               bool entered) {
    const float share = std::min(1.0F, state.speed_factor * mind.band);
    const float aimed = Vec2(mind.aim.move_x, mind.aim.move_z).norm() / kFullMove;
    const bool pace = state.rubber_band && std::abs(aimed - share) > kBandChange;
    return pace || turns(mind, desired, direction, entered);
}

/// What all deeds of a blend want together, as a velocity in units of walking speed: each wants its
/// own speed along its own direction, or to stand, with its degree as its weight.
Vec2 blended_velocity(Mind& mind,
                      const CompiledMachine& machine,
                      const CompiledMachine::Choice& choice,
                      std::size_t count,
                      const Surroundings& around) {
    const float sprint_factor =
        around.types[around.entities.type[around.self]].character.sprint_factor;
    Vec2 sum = Vec2::Zero();
    float total = 0.0F;
    for (std::size_t d = 0; d < count; ++d) {
        if (!(mind.degrees[d] > 0.0F)) {
            continue;
        }
        const State& deed = machine.states[choice.first + d];
        const DesiredVelocity desired =
            desired_velocity(mind, deed, full_speed(deed, around), around);
        const float length = desired.direction.norm();
        total += mind.degrees[d];
        if (length > 0.0F && std::isfinite(length)) {
            const float speed = deed.speed_factor * (deed.sprint ? sprint_factor : 1.0F);
            sum += desired.direction * (mind.degrees[d] * speed / length);
        }
    }
    return total > 0.0F ? Vec2(sum / total) : Vec2::Zero();
}

void steer_blend(Mind& mind,
                 const CompiledMachine& machine,
                 const CompiledMachine::Choice& choice,
                 bool entered,
                 const Surroundings& around) {
    const std::size_t count =
        machine.blends[static_cast<std::size_t>(choice.blend)].machine.states();
    for (std::size_t d = 0; entered && d < count; ++d) {
        begin_deed(mind, machine.states[choice.first + d], around);
    }
    if (around.now < mind.detour_until) {
        return;
    }
    const motion::CharacterLimits& limits =
        around.types[around.entities.type[around.self]].character;
    const Vec2 desired = blended_velocity(mind, machine, choice, count, around);
    const float speed = desired.norm();
    mind.next_steering = next_steering(mind, DesiredVelocity(), std::max(0.01F, speed), around);
    if (!(speed >= kBlendStands)) {
        stand(mind, around);
        return;
    }
    const Pace pace{speed > 1.0F ? speed / limits.sprint_factor : speed, speed > 1.0F};
    const Vec2 direction = desired / speed;
    const float now = Vec2(mind.aim.move_x, mind.aim.move_z).norm() / kFullMove *
                      (mind.aim.buttons != 0 ? limits.sprint_factor : 1.0F);
    if (turns(mind, DesiredVelocity(), direction, entered) || std::abs(now - speed) > kBlendPace) {
        if (!moving(mind)) {
            restart_progress(mind, around.entities.position[around.self], around.now);
        }
        aim_along(mind, pace, direction);
    }
    if (blocked(mind, DesiredVelocity(), limits.speed * speed, around)) {
        restart_progress(mind, around.entities.position[around.self], around.now);
        step_aside(mind, pace, direction, around);
    }
}

/// What hangs on others: looked at anew whenever it steers. True: it needs a path.
bool steer_freely(Mind& mind, const State& state, bool entered, const Surroundings& around) {
    const float speed = std::max(0.01F, full_speed(state, around));
    DesiredVelocity desired = desired_velocity(mind, state, speed, around);
    const Vec2 goal = desired.goal;
    const bool asks = turn_to_path(mind, state, desired, around);
    if (asks) {
        mind.segment = PathSegment();
        mind.segment.goal = goal;
    }
    mind.next_steering = next_steering(mind, desired, speed, around);
    const float length = desired.keep ? 0.0F : desired.direction.norm();
    if (desired.keep) {
        if (blocked(mind, desired, speed, around)) {
            get_around(mind, state, aim_direction(mind), around);
        }
    } else if (!(length > 0.0F) || !std::isfinite(length)) {
        stand(mind, around);
    } else {
        const Vec2 direction = desired.direction / length;
        if (needs_aim(mind, state, desired, direction, entered)) {
            if (!moving(mind)) {
                restart_progress(mind, around.entities.position[around.self], around.now);
            }
            aim_along(mind, state, direction);
        }
        if (blocked(mind, desired, speed, around)) {
            get_around(mind, state, direction, around);
        }
    }
    return asks;
}

/// A command that leads the body to where the segment is at its end, or some time on: so soon that
/// the correction is worth a step of the command.
void correct_drift(Mind& mind, const State& state, const Surroundings& around) {
    const float full = full_speed(state, around) / std::max(state.speed_factor, 1e-3F);
    const float soon_s = std::max(kPutRightS, kOffSegmentM * kFullMove / full);
    const float left_s = time_on(mind.segment, arrival_of(mind.segment, around.dt), around.dt) -
                         time_on(mind.segment, around.now, around.dt);
    const float time_s = std::clamp(left_s, kPutRightS, soon_s);
    const auto ticks = static_cast<Tick>(std::lround(time_s / around.dt));
    const Vec2 path = position_at(mind.segment, around.now - 1 + ticks, around.dt) - around.body();
    const float length = path.norm();
    if (length > 0.0F) {
        const float speed = length / (static_cast<float>(ticks) * around.dt);
        // It faces the path of its segment, as one that nobody sees does.
        const std::uint16_t facing = mind.aim.yaw;
        aim_along(mind, Pace{speed / full, state.sprint}, path / length);
        mind.aim.yaw = facing;
    }
}

/// Off its floor: not merely over a step.
bool falls(const Surroundings& around) {
    const world::Entities& e = around.entities;
    return !e.has(around.self, world::kGrounded) && e.velocity[around.self].y() < -kFalls;
}

/// Keeps the body to the segment, which is set anew where it has come to its end, or the body was
/// pushed away or held up. True: it needs a path.
bool steer_by_segment(Mind& mind, const State& state, bool entered, const Surroundings& around) {
    Surroundings self = around;
    const Vec2 off = position_at(mind.segment, around.now - 1, around.dt) - around.body();
    const bool anew = !mind.timed || off.norm() > kDriftM;
    if (falls(around)) {
        mind.timed = false;  // where it lands its path may lead elsewhere
        mind.next_steering = around.now + 1;
        return false;
    }
    const bool over = segment_is_over(mind, around.now, around.dt);
    // In another zone than the one that knew its path.
    const bool lost =
        mind.on_path && (around.paths == nullptr || !around.paths->has(around.slot, mind.entity));
    if (over || mind.segment.length == 0.0F || !mind.timed) {
        restart_progress(mind, around.entities.position[around.self], around.now);
    }
    if (anew) {
        start_segment(mind, around);
        self.at = around.body();
    }
    bool asks = false;
    if (anew || lost || entered || over) {
        asks = plan_segment(mind, state, entered, self);
    } else if (mind.segment.length > 0.0F && off.norm() > kOffSegmentM &&
               time_on(mind.segment, around.now, around.dt) > mind.segment.bend_s) {
        correct_drift(mind, state, around);
        const Vec2 end = end_of(mind.segment);
        if (blocked(mind, &end, mind.segment.speed, around)) {
            get_around(mind, state, mind.segment.direction, around);
            mind.timed = false;
        }
    }
    const Tick turn = next_turn(mind, around.now);
    if (asks || mind.segment.length > 0.0F) {
        mind.next_steering =
            asks ? around.now + 1
                 : std::clamp(arrival_of(mind.segment, around.dt), around.now + 1, turn);
        return asks;
    }
    mind.next_steering = std::clamp(mind.again_at, around.now + 1, turn);
    stand(mind, around);
    return false;
}

}  // namespace

Tick next_turn(const Mind& mind, Tick now) {
    return now + kFarPeriod - (now + static_cast<Tick>(mind.entity.value)) % kFarPeriod;
}

void get_unstuck(Mind& mind, const State& state, const Surroundings& around) {
    if (moving(mind) && blocked(mind, DesiredVelocity(), full_speed(state, around), around)) {
        get_around(mind, state, aim_direction(mind), around);
    }
}

bool steer(Mind& mind, const CompiledMachine& machine, const Surroundings& around) {
    const State& state = machine.states[mind.doing];
    const bool entered = std::exchange(mind.entered, false);
    const CompiledMachine::Choice& choice = machine.choices[mind.fsm.state()];
    const auto* const policy = std::get_if<PolicyChoice>(&state.choice);
    if (choice.blend >= 0 && mind.doing >= choice.first) {
        mind.timed = false;
        steer_blend(mind, machine, choice, entered, around);
        mind.fresh = false;
        return false;
    }
    bool asks = false;
    if (entered) {
        begin_deed(mind, state, around);
    }
    follow_band(mind, state, around);
    if (policy != nullptr) {
        mind.timed = false;
        mind.next_steering = around.now + 1;
        steer_by_policy(mind, machine, state, *policy, around);
    } else if (state.action == ActionKind::kFormUp && !straggles(mind)) {
        mind.timed = false;
        steer_in_formation(mind, state, entered, around);
    } else if (around.now < mind.detour_until) {
        // It walks on across its path.
    } else if (goes_by_segments(mind, state)) {
        asks = steer_by_segment(mind, state, entered, around);
    } else {
        mind.timed = false;
        asks = steer_freely(mind, state, entered, around);
    }
    mind.fresh = false;
    return asks;
}

}  // namespace zoned::ai
