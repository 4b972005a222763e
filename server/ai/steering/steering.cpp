#include "server/ai/steering/steering.h"

#include "server/ai/steering/formation_following.h"
#include "server/ai/steering/path_following.h"
#include "server/ai/steering/policy_steering.h"
#include "server/ai/steering/rubber_band.h"

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
/// A blend slower than this share of walking speed stands. A blend whose speed differs by more than
/// this from the present one changes its pace.
constexpr float kBlendStands = 0.05F;
constexpr float kBlendPace = 0.1F;
/// A body this far from its segment's position is corrected, m. At this distance the commands are
/// worth a publication.
constexpr float kOffSegmentM = 0.2F;
/// The least time for a correction, s. It aims at the segment's position by then, or at its end.
constexpr float kPutRightS = 0.5F;
/// A body that falls faster than this, m/s, has left its floor: it is some 0.2 m below it.
constexpr float kFalls = 2.0F;

void stand(Agent& agent, const Surroundings& around) {
    agent.aim = motion::InputCommand{};
    agent.aim.yaw = around.ai.entities.yaw[around.self];
    restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
}

/// True when it has walked for kPatienceS without getting anywhere; `goal`: without one, anywhere
/// counts.
bool blocked(Agent& agent, const Vec2* goal, float speed, const Surroundings& around) {
    const Vec3& here = around.ai.entities.position[around.self];
    const Vec2 anchor(agent.anchor.x(), agent.anchor.z());
    const float progress = goal != nullptr
                               ? (*goal - anchor).norm() - (*goal - around.body()).norm()
                               : (around.body() - anchor).norm();
    // A slow walker needs to show less.
    if (progress >= std::min(kProgressM, 0.25F * kPatienceS * speed)) {
        restart_progress(agent, here, around.ai.now);
        return false;
    }
    return static_cast<float>(around.ai.now - agent.anchor_since) * around.ai.dt >= kPatienceS;
}

bool blocked(Agent& agent,
             const DesiredVelocity& desired,
             float speed,
             const Surroundings& around) {
    return blocked(agent, desired.has_goal ? &desired.goal : nullptr, speed, around);
}

/// Walks across its path for a while.
void step_aside(Agent& agent, const Pace& pace, const Vec2& direction, const Surroundings& around) {
    const float side = (agent.rng.next() & 1U) != 0 ? 1.0F : -1.0F;
    aim_along(agent, pace, Vec2(side * direction.y(), -side * direction.x()));
    agent.detour_until = around.ai.now + std::max<Tick>(1, std::lround(kDetourS / around.ai.dt));
    agent.timed = false;
}

/// Passes an obstacle by another target, the next corner, or a walk around it.
void get_around(Agent& agent,
                const BrainState& state,
                const Vec2& direction,
                const Surroundings& around) {
    if (state.action == ActionKind::kWander) {
        pick_wander_target(agent, state.radius_m, around);
        return;
    }
    restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
    if (state.action == ActionKind::kPatrol) {
        agent.corner = static_cast<std::uint8_t>((agent.corner + 1) & 3);
        return;
    }
    step_aside(agent, {state.speed_factor * agent.band, state.sprint}, direction, around);
}

Tick next_steering(const Agent& agent,
                   const DesiredVelocity& desired,
                   float speed,
                   const Surroundings& around) {
    const Tick period = next_turn(agent, around.ai.now) - around.ai.now;
    if (!desired.has_goal) {
        return around.ai.now + period;
    }
    const float path = desired.direction.norm() - kArriveM;
    const auto ticks = static_cast<Tick>(std::clamp(path / (speed * around.ai.dt), 0.0F, 8.0F));
    return around.ai.now + std::clamp<Tick>(ticks, 1, period);
}

/// True where the heading is off by too much.
bool turns(const Agent& agent,
           const DesiredVelocity& desired,
           const Vec2& direction,
           bool entered) {
    if (entered || !moving(agent)) {
        return true;
    }
    const float cosine = aim_direction(agent).dot(direction);
    return cosine < (agent.fresh ? desired.fresh_cos : kReaimCos);
}

/// The same, or the speed.
bool needs_aim(const Agent& agent,
               const BrainState& state,
               const DesiredVelocity& desired,
               const Vec2& direction,
               bool entered) {
    const float share = std::min(1.0F, state.speed_factor * agent.band);
    const float aimed = Vec2(agent.aim.move_x, agent.aim.move_z).norm() / kFullMove;
    const bool pace = state.rubber_band && std::abs(aimed - share) > kBandChange;
    return pace || turns(agent, desired, direction, entered);
}

/// The sum of all actions of a blend, as a velocity in units of walking speed. Each action adds its
/// own speed and direction, or standing, weighted by its degree.
Vec2 blended_velocity(Agent& agent,
                      const CompiledBrain& brain,
                      const CompiledBrain::LeafChoice& choice,
                      std::size_t count,
                      const Surroundings& around) {
    const float sprint_factor =
        around.ai.types[around.ai.entities.type[around.self]].character.sprint_factor;
    Vec2 sum = Vec2::Zero();
    float total = 0.0F;
    for (std::size_t d = 0; d < count; ++d) {
        if (!(agent.degrees[d] > 0.0F)) {
            continue;
        }
        const BrainState& action = brain.states[choice.first + d];
        const DesiredVelocity desired =
            desired_velocity(agent, action, full_speed(action, around), around);
        const float length = desired.direction.norm();
        total += agent.degrees[d];
        if (length > 0.0F && std::isfinite(length)) {
            const float speed = action.speed_factor * (action.sprint ? sprint_factor : 1.0F);
            sum += desired.direction * (agent.degrees[d] * speed / length);
        }
    }
    return total > 0.0F ? Vec2(sum / total) : Vec2::Zero();
}

void steer_blend(Agent& agent,
                 const CompiledBrain& brain,
                 const CompiledBrain::LeafChoice& choice,
                 bool entered,
                 const Surroundings& around) {
    const std::size_t count = brain.blends[static_cast<std::size_t>(choice.blend)].brain.states();
    for (std::size_t d = 0; entered && d < count; ++d) {
        begin_action(agent, brain.states[choice.first + d], around);
    }
    if (around.ai.now < agent.detour_until) {
        return;
    }
    const motion::CharacterLimits& limits =
        around.ai.types[around.ai.entities.type[around.self]].character;
    const Vec2 desired = blended_velocity(agent, brain, choice, count, around);
    const float speed = desired.norm();
    agent.next_steering = next_steering(agent, DesiredVelocity(), std::max(0.01F, speed), around);
    if (!(speed >= kBlendStands)) {
        stand(agent, around);
        return;
    }
    const Pace pace{speed > 1.0F ? speed / limits.sprint_factor : speed, speed > 1.0F};
    const Vec2 direction = desired / speed;
    const float now = Vec2(agent.aim.move_x, agent.aim.move_z).norm() / kFullMove *
                      (agent.aim.buttons != 0 ? limits.sprint_factor : 1.0F);
    if (turns(agent, DesiredVelocity(), direction, entered) || std::abs(now - speed) > kBlendPace) {
        if (!moving(agent)) {
            restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
        }
        aim_along(agent, pace, direction);
    }
    if (blocked(agent, DesiredVelocity(), limits.speed * speed, around)) {
        restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
        step_aside(agent, pace, direction, around);
    }
}

/// Steers an action that depends on others: it is planned anew at each steering. True: it needs a
/// path.
bool steer_freely(Agent& agent, const BrainState& state, bool entered, const Surroundings& around) {
    const float speed = std::max(0.01F, full_speed(state, around));
    DesiredVelocity desired = desired_velocity(agent, state, speed, around);
    const Vec2 goal = desired.goal;
    const bool asks = turn_to_path(agent, state, desired, around);
    if (asks) {
        agent.segment = PathSegment();
        agent.segment.goal = goal;
    }
    agent.next_steering = next_steering(agent, desired, speed, around);
    const float length = desired.keep ? 0.0F : desired.direction.norm();
    if (desired.keep) {
        if (blocked(agent, desired, speed, around)) {
            get_around(agent, state, aim_direction(agent), around);
        }
    } else if (!(length > 0.0F) || !std::isfinite(length)) {
        stand(agent, around);
    } else {
        const Vec2 direction = desired.direction / length;
        if (needs_aim(agent, state, desired, direction, entered)) {
            if (!moving(agent)) {
                restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
            }
            aim_along(agent, state, direction);
        }
        if (blocked(agent, desired, speed, around)) {
            get_around(agent, state, direction, around);
        }
    }
    return asks;
}

/// A command that leads the body to the segment's end, or to the segment's position some time
/// ahead. The time is just short enough for the correction to be worth a step of the command.
void correct_drift(Agent& agent, const BrainState& state, const Surroundings& around) {
    const float full = full_speed(state, around) / std::max(state.speed_factor, 1e-3F);
    const float soon_s = std::max(kPutRightS, kOffSegmentM * kFullMove / full);
    const float left_s =
        time_on(agent.segment, arrival_of(agent.segment, around.ai.dt), around.ai.dt) -
        time_on(agent.segment, around.ai.now, around.ai.dt);
    const float time_s = std::clamp(left_s, kPutRightS, soon_s);
    const auto ticks = static_cast<Tick>(std::lround(time_s / around.ai.dt));
    const Vec2 path =
        position_at(agent.segment, around.ai.now - 1 + ticks, around.ai.dt) - around.body();
    const float length = path.norm();
    if (length > 0.0F) {
        const float speed = length / (static_cast<float>(ticks) * around.ai.dt);
        // It faces along its segment, as a suspended agent does.
        const std::uint16_t facing = agent.aim.yaw;
        aim_along(agent, Pace{speed / full, state.sprint}, path / length);
        agent.aim.yaw = facing;
    }
}

/// Off its floor: not merely over a step.
bool falls(const Surroundings& around) {
    const world::Entities& e = around.ai.entities;
    return !e.has(around.self, world::kGrounded) && e.velocity[around.self].y() < -kFalls;
}

/// Keeps the body on the segment. The segment is planned anew at its end, or after the body was
/// pushed away or held up. True: it needs a path.
bool steer_by_segment(Agent& agent,
                      const BrainState& state,
                      bool entered,
                      const Surroundings& around) {
    Surroundings self = around;
    const Vec2 off = position_at(agent.segment, around.ai.now - 1, around.ai.dt) - around.body();
    const bool anew = !agent.timed || off.norm() > kDriftM;
    if (falls(around)) {
        agent.timed = false;  // where it lands its path may lead elsewhere
        agent.next_steering = around.ai.now + 1;
        return false;
    }
    const bool over = segment_is_over(agent, around.ai.now, around.ai.dt);
    // The agent is in another zone than the one that knew its path.
    const bool lost = agent.on_path && (around.ai.paths == nullptr ||
                                        !around.ai.paths->has(around.slot, agent.entity));
    if (over || agent.segment.length == 0.0F || !agent.timed) {
        restart_progress(agent, around.ai.entities.position[around.self], around.ai.now);
    }
    if (anew) {
        start_segment(agent, around);
        self.at = around.body();
    }
    bool asks = false;
    if (anew || lost || entered || over) {
        asks = plan_segment(agent, state, entered, self);
    } else if (agent.segment.length > 0.0F && off.norm() > kOffSegmentM &&
               time_on(agent.segment, around.ai.now, around.ai.dt) > agent.segment.bend_s) {
        correct_drift(agent, state, around);
        const Vec2 end = end_of(agent.segment);
        if (blocked(agent, &end, agent.segment.speed, around)) {
            get_around(agent, state, agent.segment.direction, around);
            agent.timed = false;
        }
    }
    const Tick turn = next_turn(agent, around.ai.now);
    if (asks || agent.segment.length > 0.0F) {
        agent.next_steering =
            asks ? around.ai.now + 1
                 : std::clamp(arrival_of(agent.segment, around.ai.dt), around.ai.now + 1, turn);
        return asks;
    }
    agent.next_steering = std::clamp(agent.again_at, around.ai.now + 1, turn);
    stand(agent, around);
    return false;
}

}  // namespace

Tick next_turn(const Agent& agent, Tick now) {
    return now + kFarPeriod - (now + static_cast<Tick>(agent.entity.value)) % kFarPeriod;
}

void get_unstuck(Agent& agent, const BrainState& state, const Surroundings& around) {
    if (moving(agent) && blocked(agent, DesiredVelocity(), full_speed(state, around), around)) {
        get_around(agent, state, aim_direction(agent), around);
    }
}

bool steer(Agent& agent, const CompiledBrain& brain, const Surroundings& around) {
    const BrainState& state = brain.states[agent.current_action];
    const bool entered = std::exchange(agent.entered, false);
    const CompiledBrain::LeafChoice& choice = brain.choices[agent.state_machine.leaf];
    const auto* const policy = std::get_if<PolicyChoice>(&state.choice);
    follow_band(agent, state, around);
    if (choice.blend >= 0 && agent.current_action >= choice.first) {
        agent.timed = false;
        steer_blend(agent, brain, choice, entered, around);
        agent.fresh = false;
        return false;
    }
    bool asks = false;
    if (entered) {
        begin_action(agent, state, around);
    }
    if (policy != nullptr) {
        agent.timed = false;
        agent.next_steering = around.ai.now + 1;
        steer_by_policy(agent, brain, state, *policy, around);
    } else if (state.action == ActionKind::kFormUp && !straggles(agent)) {
        agent.timed = false;
        steer_in_formation(agent, state, entered, around);
    } else if (around.ai.now < agent.detour_until) {
        // It walks on across its path.
    } else if (goes_by_segments(agent, state)) {
        asks = steer_by_segment(agent, state, entered, around);
    } else {
        agent.timed = false;
        asks = steer_freely(agent, state, entered, around);
    }
    agent.fresh = false;
    return asks;
}

}  // namespace zoned::ai
