// Compound: several convex shapes that move as one body.
#pragma once

#include "server/physics/shapes/box_tree.h"
#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::physics {

inline constexpr std::size_t kMaxParts = 1024;

struct CompoundPart {
    Shape shape;  ///< sphere, box, capsule or hull
    Frame frame;  ///< of the shape, in the compound's frame
    Material material;
    Filter filter;
    bool sensor = false;  ///< has no mass and pushes nobody
};

/// Immutable. Its frame is about the centre of mass of its parts and along their common principal
/// axes. Parts may overlap: a shared volume counts twice.
class Compound final : public Geometry {
  public:
    struct CompoundChild {
        CompoundPart part;
        Mat3 rotation;  ///< of part.frame
    };

    struct CompoundTables {
        std::vector<CompoundChild> parts;
        BoxTree tree;
        float mass = 0.0F;    ///< kg, from the parts' densities
        float volume = 0.0F;  ///< m3
        float radius = 0.0F;
        Vec3 moments_per_kg = Vec3::Zero();
    };

    explicit Compound(CompoundTables tables)
        : Geometry(ShapeKind::kCompound),
          t_(std::move(tables)) {}

    [[nodiscard]] const std::vector<CompoundChild>& parts() const { return t_.parts; }

    [[nodiscard]] const BoxTree& tree() const { return t_.tree; }

    [[nodiscard]] float mass() const { return t_.mass; }

    [[nodiscard]] float volume() const { return t_.volume; }

    [[nodiscard]] float radius() const { return t_.radius; }

    [[nodiscard]] const Vec3& moments_per_kg() const { return t_.moments_per_kg; }

  private:
    CompoundTables t_;
};

/// The compound of a shape of kind kCompound.
inline const Compound& compound_of(const Shape& shape) {
    return static_cast<const Compound&>(*shape.geometry);
}

struct BuiltCompound {
    std::shared_ptr<const Compound> compound;
    /// Where the compound's own frame lies in the coordinates of the parts. To stand where the
    /// parts are, a body takes this pose.
    Frame frame;
    float mass = 0.0F;  ///< kg, from the parts' densities and volumes
};

/// Fails with the reason when there are no parts or more than kMaxParts, a part is not convex, not
/// finite or out of range, or none has a mass.
core::Result<BuiltCompound> build_compound(std::span<const CompoundPart> parts);

/// The compound with `tensor` (kg m2, about its centre of mass, along the axes of the parts) in
/// place of the densities' tensor, for a body of `mass` kg whose centre of mass is `centre`. A body
/// gets any inertia tensor by this, asymmetric ones too. The frame's axes are then the tensor's
/// principal ones. Fails also when no body can have the tensor.
core::Result<BuiltCompound> build_compound(std::span<const CompoundPart> parts,
                                           float mass,
                                           const Vec3& centre,
                                           const Mat3& tensor);

/// Mass of a solid of the material's density, kg; of a compound the sum of its parts.
float solid_mass(const Shape& shape, const Material& material);

}  // namespace zoned::physics
