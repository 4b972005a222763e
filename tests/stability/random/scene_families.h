// SceneFamilies: the things that random scenes are mixed from, each in coordinates of its own.
#pragma once

#include "tests/stability/random/random_scene.h"
#include "shared/core/rng.h"

#include <span>
#include <string_view>

namespace zoned::stability {

/// Where a scene happens.
enum class SceneSetting : std::uint8_t {
    kGround,  ///< gravity, and ground below
    kAdrift,  ///< neither
};

/// Draws numbers for a scene, and keeps what all its parts have in common. Draws stand in braces or
/// in statements of their own: compilers choose the order of a call's arguments, and each order
/// would be another scene.
class SceneDraw {
  public:
    SceneDraw(std::uint64_t seed, std::uint64_t index) : rng_(seed, index) {}

    float range(float lower, float upper) { return rng_.range(lower, upper); }

    /// From lower to upper, both included.
    int count(int lower, int upper) {
        return lower + static_cast<int>(rng_.below(static_cast<std::uint32_t>(upper - lower + 1)));
    }

    bool chance(float share) { return rng_.unit() < share; }

    /// Evenly in the logarithm.
    float decades(float lower, float upper) {
        return std::exp(range(std::log(lower), std::log(upper)));
    }

    Vec3 direction();
    /// A length in [shortest, longest], then a direction.
    Vec3 vector(float shortest, float longest);
    Quat turn();
    /// Any convex shape or compound of about `size` metres across.
    RandomBody body(float size);
    /// A body of one part, at rest, with the material of the scene and the mass of its density.
    RandomBody solid(const RandomPart& part);
    /// Multiplies by up to 10^decades_of_mass either way.
    void spread_mass(RandomBody& body);

    float friction = 0.5F;
    float restitution = 0.0F;
    float density = 1000.0F;       ///< kg/m3
    float decades_of_mass = 0.0F;  ///< 0..2: ratios up to 10^4
    SceneSetting setting = SceneSetting::kGround;

  private:
    core::Rng rng_;
};

/// Bodies and joints, to be put as a whole somewhere: its lowest point is taken to be on the
/// ground, or above it by `clearance`.
struct Assembly {
    std::vector<RandomBody> bodies;
    std::vector<RandomJoint> joints;
    float clearance = 0.0F;  ///< m
    bool at_origin = false;  ///< stays where it is, about the middle of level ground
};

struct SceneFamily {
    std::string_view name;
    bool adrift = false;  ///< makes sense without ground too
    bool level = false;   ///< needs level ground
    void (*make)(SceneDraw& draw, Assembly& out) = nullptr;
};

std::span<const SceneFamily> scene_families();

}  // namespace zoned::stability
