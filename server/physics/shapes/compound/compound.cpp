#include "server/physics/shapes/compound/compound.h"

#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/mass_properties.h"
#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <utility>

namespace zoned::physics {

namespace {

std::string why_unfit(std::span<const CompoundPart> parts) {
    if (parts.empty() || parts.size() > kMaxParts) {
        return "compound: needs 1.." + std::to_string(kMaxParts) + " parts";
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string reason = why_unfit_part(parts[i]);
        if (!reason.empty()) {
            return "compound: part " + std::to_string(i) + ": " + reason;
        }
    }
    return {};
}

MassProperties mass_of(const CompoundPart& part) {
    if (part.sensor) {
        return {};
    }
    MassProperties solid;
    solid.mass = solid_mass(part.shape, part.material);
    const Vec3 moments = principal_inertia(part.shape, static_cast<float>(solid.mass));
    solid.inertia = moments.cast<double>().asDiagonal();
    const Eigen::Quaterniond turn(part.frame.rotation.cast<double>());
    return moved(solid, turn.normalized().toRotationMatrix(), part.frame.position.cast<double>());
}

/// Puts the parts into the frame and fills the tables.
core::Result<BuiltCompound> assemble(std::span<const CompoundPart> parts,
                                     const MassProperties& solid) {
    using Built = core::Result<BuiltCompound>;
    const core::Result<PrincipalAxes> axes = principal_axes(solid.inertia);
    if (!axes) {
        return Built::failure("compound: " + axes.error());
    }
    const Eigen::Quaterniond turn = Eigen::Quaterniond(axes->rotation).normalized();
    Compound::CompoundTables t;
    std::vector<Aabb> boxes;
    for (const CompoundPart& given : parts) {
        CompoundPart part = given;
        const Vec3d from_centre = given.frame.position.cast<double>() - solid.centre;
        part.frame.position = (turn.conjugate() * from_centre).cast<float>();
        const Eigen::Quaterniond rotation(given.frame.rotation.cast<double>());
        part.frame.rotation = Quat((turn.conjugate() * rotation.normalized()).cast<float>());
        const Mat3 matrix = part.frame.rotation.toRotationMatrix();
        boxes.push_back(shape_bounds(part.shape, part.frame.position, matrix));
        t.radius = std::max(t.radius, part.frame.position.norm() + bounding_radius(part.shape));
        t.volume += part.sensor ? 0.0F : volume(part.shape);
        t.parts.push_back({std::move(part), matrix});
    }
    t.tree = BoxTree(boxes);
    t.mass = static_cast<float>(solid.mass);
    t.moments_per_kg = (axes->moments / solid.mass).cast<float>();
    BuiltCompound out;
    out.compound = std::make_shared<const Compound>(std::move(t));
    out.frame = {solid.centre.cast<float>(), Quat(turn.cast<float>())};
    out.mass = static_cast<float>(solid.mass);
    return out;
}

}  // namespace

core::Result<BuiltCompound> build_compound(std::span<const CompoundPart> parts) {
    using Built = core::Result<BuiltCompound>;
    std::string reason = why_unfit(parts);
    if (!reason.empty()) {
        return Built::failure(std::move(reason));
    }
    std::vector<MassProperties> solids;
    for (const CompoundPart& part : parts) {
        solids.push_back(mass_of(part));
    }
    const MassProperties solid = sum_of(solids);
    if (!(solid.mass > 0.0)) {
        return Built::failure("compound: no part has a mass");
    }
    return assemble(parts, solid);
}

core::Result<BuiltCompound> build_compound(std::span<const CompoundPart> parts,
                                           float mass,
                                           const Vec3& centre,
                                           const Mat3& tensor) {
    using Built = core::Result<BuiltCompound>;
    std::string reason = why_unfit(parts);
    if (!reason.empty()) {
        return Built::failure(std::move(reason));
    }
    if (!(mass >= kMinMass && mass <= kMaxMass)) {
        return Built::failure("compound: mass out of range");
    }
    if (!fit_position(centre)) {
        return Built::failure("compound: centre out of range");
    }
    return assemble(parts, {mass, centre.cast<double>(), tensor.cast<double>()});
}

float solid_mass(const Shape& shape, const Material& material) {
    return shape.kind == ShapeKind::kCompound ? compound_of(shape).mass()
                                              : volume(shape) * material.density;
}

Shape Shape::compound(std::shared_ptr<const Compound> compound) {
    Shape shape;
    shape.kind = ShapeKind::kCompound;
    shape.geometry = std::move(compound);
    return shape;
}

}  // namespace zoned::physics
