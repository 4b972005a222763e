// Policy: a network that steers an agent, with the meaning of its inputs and outputs.
#pragma once

#include "server/ai/learning/neural_network.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::learning {

/// Situation: positions and velocities on the ground (x, z), m and m/s, in any one frame of
/// reference.
struct Situation {
    Vec2 here = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();
    Vec2 home = Vec2::Zero();
    bool has_target = false;  ///< the target is the nearest player or a goal
    Vec2 target = Vec2::Zero();
    Vec2 target_velocity = Vec2::Zero();
};

/// Ego: the senses of a policy. "Along" is towards the point that it faces (Facing); "across" is a
/// quarter turn from there, from +z to +x. So the senses stay the same when the agent and all
/// around it are rotated.
enum class Ego : std::uint8_t {
    kHasTarget,         ///< 1 or 0
    kTargetDistance,    ///< m; 0 without a target, as are all senses of the target
    kTargetSpeedAlong,  ///< of the target, m/s
    kTargetSpeedAcross,
    kHomeDistance,  ///< m
    kHomeAlong,     ///< component of the path home, m
    kHomeAcross,
    kSpeedAlong,  ///< own speed, m/s
    kSpeedAcross,
};

inline constexpr std::size_t kEgoSenses = 9;

/// The name for people and files: "TARGET_DISTANCE".
const char* name_of(Ego sense);

/// Facing: the point that a policy faces: its target, or home without a target; or always home.
enum class Facing : std::uint8_t {
    kTarget,
    kHome,
};

/// A number that a policy reads: `value * scale + offset`, kept within kInputLimit of 0.
struct PolicyInput {
    Ego ego = Ego::kTargetDistance;
    std::string variable{};  ///< a variable of the agent, in place of `ego`
    float scale = 1.0F;
    float offset = 0.0F;
};

inline constexpr float kInputLimit = 4.0F;
/// Outputs: along, across and, where there is a third, sprint above 0. The first two give the
/// direction. Their length gives the share of full speed, at most 1.
inline constexpr std::size_t kLeastOutputs = 2;
inline constexpr std::size_t kMostOutputs = 3;
inline constexpr std::size_t kMostInputs = 32;

struct Policy {
    std::string name;
    Facing facing = Facing::kTarget;
    std::vector<PolicyInput> inputs;
    NeuralNetwork network;
};

/// The defect of a policy from outside; empty: it can decide.
std::string defect_of(const Policy& policy);

/// The direction in which a policy faces, of unit length; +z where it stands exactly at the point.
Vec2 facing_of(Facing facing, const Situation& situation);

/// A vector from its parts along and across, and the reverse.
inline Vec2 to_world(const Vec2& along, float forward, float sideways) {
    return {along.x() * forward + along.y() * sideways, along.y() * forward - along.x() * sideways};
}

inline Vec2 to_ego(const Vec2& along, const Vec2& v) {
    return {along.x() * v.x() + along.y() * v.y(), along.y() * v.x() - along.x() * v.y()};
}

/// All ego senses, by Ego.
std::array<float, kEgoSenses> ego_senses(Facing facing, const Situation& situation);

/// The network's inputs: `inputs.size()` numbers. `variables`: by input, read where the input names
/// one. A value that is not a number becomes 0, so the network never gets one.
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

/// The outputs that mean this movement: the reverse of decide().
std::array<float, kMostOutputs> outputs_for(Facing facing,
                                            const Situation& situation,
                                            const Wanted& wanted);

}  // namespace zoned::ai::learning
