#include "server/ai/offscreen/herd.h"

#include "server/ai/agent/decision.h"
#include "server/ai/steering/desired_velocity.h"
#include "shared/core/block_hash.h"
#include "shared/motion/apply_input.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr float kRoam_s = 1.0F;
/// A character with this share of its walk left is at its end, but for rounding.
constexpr float kAtEndShare = 1e-3F;

/// The command that leads along `way` (m) in `time_s`. `limits` bound its speed.
motion::InputCommand command_along(const Vec2& way,
                                   float time_s,
                                   const motion::CharacterLimits& limits) {
    motion::InputCommand command;
    float share = way.norm() / (time_s * std::max(limits.speed, 1e-3F));
    if (share > 1.0F) {
        command.buttons = motion::kButtonSprint;
        share /= std::max(limits.sprint_factor, 1e-3F);
    }
    if (share > 0.0F) {
        const Vec2 move = way * (kFullMove * std::min(share, 1.0F) / way.norm());
        command.move_x = static_cast<std::int8_t>(std::lround(move.x()));
        command.move_z = static_cast<std::int8_t>(std::lround(move.y()));
    }
    return command;
}

}  // namespace

StepEnd walk_along(const motion::CharacterState& from,
                   const Vec2& way,
                   float time_s,
                   const motion::CharacterLimits& limits,
                   const motion::StaticGeometry& statics,
                   Tick now) {
    const Walked to =
        walked(from, command_along(way, time_s, limits), limits, statics, time_s, now);
    const Vec2 end =
        to.free ? Vec2(over_ground(from.position) + way) : over_ground(to.state.position);
    return {Vec3(end.x(), to.state.position.y(), end.y()), to.state.grounded};
}

bool at_step_end(const Agent& agent, const Vec2& at) {
    return (at - agent.segment.goal).norm() <= kAtEndShare * step_of(agent);
}

float roam_speed(const BrainState& state, const motion::CharacterLimits& limits) {
    return limits.speed * std::clamp(state.speed_factor, 0.0F, 1.0F) *
           (state.sprint ? limits.sprint_factor : 1.0F);
}

Tick roams_until(const CompiledBrain& brain, Tick now, float dt) {
    const Tick period =
        std::max<Tick>(decision_period(brain, dt), std::max(1L, std::lround(kRoam_s / dt)));
    return (now / period + 1) * period;
}

Vec2 path_ahead(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row) {
    const auto ticks = static_cast<float>(roams_until(brain, ai.now, ai.dt) - ai.now);
    return wanted_by(agent.aim, ai.types[ai.entities.type[row]].character) * (ticks * ai.dt);
}

void take_step(Agent& agent,
               const CompiledBrain& brain,
               const AiContext& ai,
               const Vec3& from,
               const StepEnd& end) {
    const Tick until = roams_until(brain, ai.now, ai.dt);
    const float time_s = static_cast<float>(until - ai.now) * ai.dt;
    const Vec2 here = over_ground(from);
    const float length = end.stands ? (over_ground(end.at) - here).norm() : 0.0F;
    agent.segment = PathSegment();
    agent.segment.from = here;
    agent.segment.goal = end.stands ? over_ground(end.at) : here;
    agent.segment.since = ai.now - 1;
    if (length > 0.0F) {
        agent.segment.direction = (agent.segment.goal - here) / length;
        agent.segment.speed = length / time_s;
    }
    agent.target = Vec3(agent.segment.goal.x(), end.at.y(), agent.segment.goal.y());
    agent.timed = true;
    agent.on_path = false;
    agent.fresh = false;
    agent.again_at = until;
}

bool roam(Agent& agent,
          const CompiledBrain& brain,
          const AiContext& ai,
          world::Row row,
          const Vec3& from,
          const Vec2& way) {
    const Tick until = roams_until(brain, ai.now, ai.dt);
    const float time_s = static_cast<float>(until - ai.now) * ai.dt;
    const Vec2 velocity = velocity_at(agent.segment, ai.now - 1, ai.dt);
    const motion::CharacterState begin{
        from, Vec3(velocity.x(), 0.0F, velocity.y()), ai.entities.yaw[row], true};
    const motion::CharacterLimits& limits = ai.types[ai.entities.type[row]].character;
    const StepEnd end = walk_along(begin, way, time_s, limits, ai.statics, ai.now);
    take_step(agent, brain, ai, from, end);
    return end.stands;
}

bool only_steps(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row) {
    if (agent.entered || !on_step(agent) || !roams(agent, brain) || agent.again_at != ai.now ||
        agent.next_decision <= ai.now || ai.now < agent.detour_until) {
        return false;
    }
    const motion::CharacterLimits& limits = ai.types[ai.entities.type[row]].character;
    const float wanted = wanted_by(agent.aim, limits).norm();
    return agent.segment.speed >= kHinderedShare * wanted;
}

void hash_step(core::StateHash& hash, const Agent& agent) {
    core::BlockHash block;
    block.pack(agent.entity.value);
    for (int axis = 0; axis < 2; ++axis) {
        block.pack(agent.segment.from[axis]);
        block.pack(agent.segment.goal[axis]);
        block.pack(agent.placed[axis]);
    }
    block.pack(agent.segment.speed);
    block.pack(agent.segment.since);
    block.pack(agent.target.y());
    block.pack(agent.aim.move_x);
    block.pack(agent.aim.move_z);
    block.pack(agent.aim.yaw);
    block.pack(agent.again_at);
    block.pack(agent.next_event);
    block.pack(agent.rng.state);
    hash.add(block.value());
}

}  // namespace zoned::ai
