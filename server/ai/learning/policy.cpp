#include "server/ai/learning/policy.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::learning {

namespace {

constexpr float kOnTheSpotM = 1e-4F;

}  // namespace

const char* name_of(Ego sense) {
    constexpr std::array<const char*, kEgoSenses> kNames{"HAS_TARGET",
                                                         "TARGET_DISTANCE",
                                                         "TARGET_SPEED_ALONG",
                                                         "TARGET_SPEED_ACROSS",
                                                         "HOME_DISTANCE",
                                                         "HOME_ALONG",
                                                         "HOME_ACROSS",
                                                         "SPEED_ALONG",
                                                         "SPEED_ACROSS"};
    return kNames[static_cast<std::size_t>(sense)];
}

std::string defect_of(const Policy& policy) {
    if (policy.inputs.empty() || policy.inputs.size() > kMostInputs) {
        return "it has " + std::to_string(policy.inputs.size()) + " inputs; 1 to " +
               std::to_string(kMostInputs) + " are allowed";
    }
    if (policy.inputs.size() != policy.network.inputs) {
        return "it names " + std::to_string(policy.inputs.size()) + " inputs for a network with " +
               std::to_string(policy.network.inputs);
    }
    for (const PolicyInput& input : policy.inputs) {
        if (!std::isfinite(input.scale) || !std::isfinite(input.offset)) {
            return "an input has a scale or offset that is not finite";
        }
    }
    const std::size_t outputs = policy.network.outputs.size();
    if (outputs < kLeastOutputs || outputs > kMostOutputs) {
        return "its network has " + std::to_string(outputs) +
               " outputs; two (along, across) or three (and sprint) have a meaning";
    }
    return defect_of(policy.network);
}

Vec2 facing_of(Facing facing, const Situation& situation) {
    const bool at_target = facing == Facing::kTarget && situation.has_target;
    const Vec2 way = (at_target ? situation.target : situation.home) - situation.here;
    const float length = way.norm();
    // Written so that no number leads to the second answer as well.
    return length > kOnTheSpotM ? Vec2(way / length) : Vec2(0.0F, 1.0F);
}

std::array<float, kEgoSenses> ego_senses(Facing facing, const Situation& situation) {
    const Vec2 along = facing_of(facing, situation);
    const Vec2 home = situation.home - situation.here;
    const Vec2 home_part = to_ego(along, home);
    const Vec2 speed = to_ego(along, situation.velocity);
    Vec2 target_speed = Vec2::Zero();
    float distance = 0.0F;
    if (situation.has_target) {
        target_speed = to_ego(along, situation.target_velocity);
        distance = (situation.target - situation.here).norm();
    }
    return {situation.has_target ? 1.0F : 0.0F,
            distance,
            target_speed.x(),
            target_speed.y(),
            home.norm(),
            home_part.x(),
            home_part.y(),
            speed.x(),
            speed.y()};
}

void sense(const Policy& policy,
           const Situation& situation,
           std::span<const float> variables,
           std::span<float> out) {
    ZONED_ASSERT(out.size() == policy.inputs.size(), "a place for each input");
    const std::array<float, kEgoSenses> ego = ego_senses(policy.facing, situation);
    for (std::size_t k = 0; k < out.size(); ++k) {
        const PolicyInput& input = policy.inputs[k];
        const float value =
            input.variable.empty() ? ego[static_cast<std::size_t>(input.ego)] : variables[k];
        const float scaled = value * input.scale + input.offset;
        out[k] = std::isnan(scaled) ? 0.0F : std::clamp(scaled, -kInputLimit, kInputLimit);
    }
}

Wanted decide(const Policy& policy,
              const Situation& situation,
              std::span<const float> variables,
              std::span<float> values) {
    std::array<float, kMostInputs> in;
    const std::span<float> sensed(in.data(), policy.inputs.size());
    sense(policy, situation, variables, sensed);
    std::array<float, kMostOutputs> out{};
    const std::size_t outputs = policy.network.outputs.size();
    evaluate(policy.network, sensed, values, std::span(out.data(), outputs));
    Wanted wanted;
    wanted.move = to_world(facing_of(policy.facing, situation), out[0], out[1]);
    const float length = wanted.move.norm();
    if (length > 1.0F) {
        wanted.move /= length;
    }
    wanted.sprint = outputs > kLeastOutputs && out[2] > 0.0F;
    return wanted;
}

std::array<float, kMostOutputs> outputs_for(Facing facing,
                                            const Situation& situation,
                                            const Wanted& wanted) {
    const Vec2 part = to_ego(facing_of(facing, situation), wanted.move);
    return {part.x(), part.y(), wanted.sprint ? 1.0F : -1.0F};
}

}  // namespace zoned::ai::learning
