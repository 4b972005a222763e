// Policy: a network that says where to go: what it senses, how its answers are meant.
#pragma once

#include "server/ai/learning/neural_network.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::learning {

/// Where somebody stands, on the ground (x, z), m and m/s, in any one frame of reference.
struct Situation {
    Vec2 here = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();
    Vec2 home = Vec2::Zero();
    bool has_target = false;  ///< somebody to go by: the nearest player, a goal
    Vec2 target = Vec2::Zero();
    Vec2 target_velocity = Vec2::Zero();
};

/// What a policy can sense. "Along" is towards what it looks at (Facing), "across" a quarter turn
/// from there from +z to +x: who is turned about, with all around, senses the same.
enum class Ego : std::uint8_t {
    kHasTarget,         ///< 1 or 0
    kTargetDistance,    ///< m; without a target 0, as all that is the target's
    kTargetSpeedAlong,  ///< of the target, m/s
    kTargetSpeedAcross,
    kHomeDistance,  ///< m
    kHomeAlong,     ///< of the way home, m
    kHomeAcross,
    kSpeedAlong,  ///< its own, m/s
    kSpeedAcross,
};

inline constexpr std::size_t kEgoSenses = 9;

/// Name for people and files: "TARGET_DISTANCE".
const char* name_of(Ego sense);

/// What a policy looks at: its target, or home where it has none; or always home.
enum class Facing : std::uint8_t {
    kTarget,
    kHome,
};

/// A number that a policy reads: `value * scale + offset`, kept within kInputLimit of 0.
struct PolicyInput {
    Ego ego = Ego::kTargetDistance;
    std::string variable{};  ///< of the agent, in place of `ego`
    float scale = 1.0F;
    float offset = 0.0F;
};

inline constexpr float kInputLimit = 4.0F;
/// Outputs: along, across (together the direction, and as length the share of full speed, at most
/// 1), and, where there is a third, sprint above 0.
inline constexpr std::size_t kLeastOutputs = 2;
inline constexpr std::size_t kMostOutputs = 3;
inline constexpr std::size_t kMostInputs = 32;

struct Policy {
    std::string name;
    Facing facing = Facing::kTarget;
    std::vector<PolicyInput> inputs;
    NeuralNetwork network;
};

/// What is wrong with a policy from outside; empty: it can decide.
std::string defect_of(const Policy& policy);

/// What a policy looks along, of unit length; on the very spot of what it looks at +z.
Vec2 facing_of(Facing facing, const Situation& situation);

/// A vector by its parts along and across, and the reverse.
inline Vec2 to_world(const Vec2& along, float forward, float sideways) {
    return {along.x() * forward + along.y() * sideways, along.y() * forward - along.x() * sideways};
}

inline Vec2 to_ego(const Vec2& along, const Vec2& v) {
    return {along.x() * v.x() + along.y() * v.y(), along.y() * v.x() - along.x() * v.y()};
}

/// All that can be sensed, by Ego.
std::array<float, kEgoSenses> ego_senses(Facing facing, const Situation& situation);

/// What the network reads: `inputs.size()` numbers. `variables`: by input, read where it names one.
/// What is no number becomes 0, so that the network never sees one.
void sense(const Policy& policy,
           const Situation& situation,
           std::span<const float> variables,
           std::span<float> out);

struct Wanted {
    Vec2 move = Vec2::Zero();  ///< direction in the world and share of full speed, length <= 1
    bool sprint = false;
};

/// `values`: policy.network.values() places of working memory; `variables` as in sense().
Wanted decide(const Policy& policy,
              const Situation& situation,
              std::span<const float> variables,
              std::span<float> values);

/// The outputs that mean this movement: the reverse of what decide() makes of them.
std::array<float, kMostOutputs> outputs_for(Facing facing,
                                            const Situation& situation,
                                            const Wanted& wanted);

}  // namespace zoned::ai::learning
