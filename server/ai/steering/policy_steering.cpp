#include "server/ai/steering/policy_steering.h"

#include "server/ai/agent/decision.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr float kFreshTurnCos = 0.99452F;  // 6 degrees, at a decision
constexpr float kTurnCos = 0.93969F;       // 20 degrees, in between
constexpr float kShareChange = 0.15F;      // of full speed

Vec2 on_plane(const Vec3& v) {
    return {v.x(), v.z()};
}

/// True where the aim is nearly the wanted one: the difference is not worth a notification.
bool near_enough(const motion::InputCommand& aim, const learning::Wanted& wanted, bool fresh) {
    const Vec2 moves = Vec2(aim.move_x, aim.move_z) / 127.0F;
    const float share = moves.norm();
    const float asked = wanted.move.norm();
    const bool sprints = (aim.buttons & motion::kButtonSprint) != 0;
    if (share == 0.0F || asked == 0.0F || sprints != wanted.sprint) {
        return false;
    }
    const float cosine = moves.dot(wanted.move) / (share * asked);
    return cosine > (fresh ? kFreshTurnCos : kTurnCos) && std::abs(share - asked) < kShareChange;
}

/// True where `aim` equals the guard's command but for what eight bits lose of a movement, and is
/// itself within the guard's speed. The state before this one may have been faster.
bool repeats(const motion::InputCommand& aim,
             const motion::InputCommand& said,
             const learning::Guard& guard) {
    return std::abs(aim.move_x - said.move_x) <= 2 && std::abs(aim.move_z - said.move_z) <= 2 &&
           aim.buttons == said.buttons &&
           Vec2(aim.move_x, aim.move_z).norm() <= guard.max_speed * 127.0F;
}

learning::Wanted wanted_of(const Agent& agent,
                           const CompiledBrain& brain,
                           const PolicyChoice& choice,
                           Tick now,
                           const learning::Situation& situation) {
    std::array<float, learning::kMostInputs> variables{};
    for (std::size_t k = 0; k < choice.variable.size(); ++k) {
        // Inputs that name none have a number all the same.
        if (choice.variable[k] < brain.variables.size()) {
            variables[k] = variable_at(agent, brain, choice.variable[k], now);
        }
    }
    std::array<float, learning::kMaxValues> values;
    return decide(choice.policy->policy, situation, variables, values);
}

}  // namespace

learning::Situation situation_of(const Agent& agent, const Surroundings& around) {
    const world::Entities& e = around.ai.entities;
    learning::Situation s;
    s.here = on_plane(e.position[around.self]);
    s.velocity = on_plane(e.velocity[around.self]);
    s.home = on_plane(agent.home);
    const world::Row prey = agent.prey ? e.find(agent.prey) : world::kNoRow;
    s.has_target = prey != world::kNoRow && !e.has(prey, world::kHidden);
    if (s.has_target) {
        s.target = on_plane(e.position[prey]);
        s.target_velocity = on_plane(e.velocity[prey]);
    }
    return s;
}

void steer_by_policy(Agent& agent,
                     const CompiledBrain& brain,
                     const BrainState& state,
                     const PolicyChoice& choice,
                     const Surroundings& around) {
    ZONED_ASSERT(choice.policy != nullptr, "a policy is given before its brain is compiled");
    const learning::Situation s = situation_of(agent, around);
    learning::Wanted wanted = wanted_of(agent, brain, choice, around.ai.now, s);
    wanted.move *= std::clamp(state.speed_factor * agent.band, 0.0F, 1.0F);
    const learning::Guard& guard = choice.policy->guard;
    wanted.sprint = wanted.sprint && guard.may_sprint;
    const bool keep = near_enough(agent.aim, wanted, agent.fresh);
    if (keep) {
        wanted.move = Vec2(agent.aim.move_x, agent.aim.move_z) / 127.0F;
    }
    const learning::Guarded body{s.here - s.home,
                                 s.velocity,
                                 around.ai.entities.yaw[around.self],
                                 around.ai.dt,
                                 static_cast<float>(kFarPeriod) * around.ai.dt};
    const motion::InputCommand command = guarded(
        guard, wanted, body, around.ai.types[around.ai.entities.type[around.self]].character);
    if (!keep || !repeats(agent.aim, command, guard)) {
        agent.aim = command;
    }
}

}  // namespace zoned::ai
