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
    /// Rolling is resisted by a moment of at most this times the load, m: as if the load stood so
    /// far ahead of the point of contact (K. L. Johnson, "Contact Mechanics", 1985, chapter 9). A
    /// ball of radius r rolls as with the dimensionless coefficient rolling_m / r. Of a pair the
    /// larger counts.
    float rolling_m = 0.0F;  ///< 0..100
    /// The same for turning about the normal; an elastic patch of radius a under Coulomb's friction
    /// f has 3 pi f a / 16.
    float spinning_m = 0.0F;  ///< 0..100
};

/// The numbers that a contact needs of two materials.
struct Grip {
    float friction = 0.0F;
    float restitution = 0.0F;
    float rolling_m = 0.0F;
    float spinning_m = 0.0F;

    /// Whether turning is resisted besides Coulomb's friction of the patch.
    [[nodiscard]] bool rolls_stiffly() const { return rolling_m > 0.0F || spinning_m > 0.0F; }
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
