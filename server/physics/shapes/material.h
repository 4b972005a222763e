// Material and collision filter: the surface of a shape, and the shapes that it collides with.
#pragma once

#include <cstdint>

namespace zoned::physics {

/// How the coefficients of a pair become one. Where both sides ask for a rule, the later one in
/// this list applies.
enum class Combine : std::uint8_t {
    kDefault,  ///< friction: geometric mean; restitution: maximum
    kAverage,
    kGeometricMean,
    kMinimum,
    kMultiply,
    kMaximum,
};

struct Material {
    float friction = 0.5F;     ///< 0..100
    float restitution = 0.0F;  ///< 0..1
    Combine friction_rule = Combine::kDefault;
    Combine restitution_rule = Combine::kDefault;
    float density = 1000.0F;  ///< kg/m3, for `solid_mass` and the parts of compounds
};

/// The numbers that a contact needs of two materials.
struct Grip {
    float friction = 0.0F;
    float restitution = 0.0F;
};

Grip combine(const Material& a, const Material& b);

/// Two shapes meet when each one's mask holds the other's category.
struct Filter {
    std::uint32_t category = 1;
    std::uint32_t mask = 0xFFFFFFFFU;

    [[nodiscard]] bool meets(const Filter& other) const {
        return (mask & other.category) != 0 && (other.mask & category) != 0;
    }
};

}  // namespace zoned::physics
