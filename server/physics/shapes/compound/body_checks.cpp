#include "server/physics/shapes/compound/body_checks.h"

#include "server/physics/shapes/mass_properties.h"
#include "server/physics/shapes/ranges.h"

namespace zoned::physics {

namespace {

bool has_mass(BodyKind kind) {
    return kind == BodyKind::kDynamic || kind == BodyKind::kParticle;
}

std::string why_unfit_geometry(const Shape& shape, const std::string& name) {
    if (shape.geometry == nullptr) {
        return name + ": no geometry";
    }
    return shape.geometry->kind == shape.kind ? std::string() : name + ": geometry of another kind";
}

std::string why_unfit_shape(const Shape& shape, BodyKind kind) {
    switch (shape.kind) {
        case ShapeKind::kSphere:
            if (!within(shape.radius, kMinSize, kMaxSize)) {
                return "sphere: radius out of range";
            }
            return {};
        case ShapeKind::kBox:
            for (int i = 0; i < 3; ++i) {
                if (!within(shape.half_extents[i], kMinSize, kMaxSize)) {
                    return "box: half extent out of range";
                }
            }
            return {};
        case ShapeKind::kCapsule:
            if (!within(shape.radius, kMinSize, kMaxSize)) {
                return "capsule: radius out of range";
            }
            if (!within(shape.half_segment, kMinSize, kMaxSize)) {
                return "capsule: half segment out of range";
            }
            return {};
        case ShapeKind::kHull:
            return why_unfit_geometry(shape, "hull");
        case ShapeKind::kCompound:
            return why_unfit_geometry(shape, "compound");
        case ShapeKind::kMesh:
            return kind == BodyKind::kStatic ? why_unfit_geometry(shape, "mesh")
                                             : std::string("mesh: only for static bodies");
        case ShapeKind::kHeightfield:
            return kind == BodyKind::kStatic ? why_unfit_geometry(shape, "heightfield")
                                             : std::string("heightfield: only for static bodies");
        case ShapeKind::kPlane:
            return kind == BodyKind::kStatic ? std::string() : "plane: only for static bodies";
    }
    return "unknown shape kind";
}

std::string why_unfit_material(const Material& material) {
    if (!within(material.rolling_m, 0.0F, 100.0F) || !within(material.spinning_m, 0.0F, 100.0F)) {
        return "rolling or spinning friction out of range";
    }
    if (!within(material.friction, 0.0F, 100.0F)) {
        return "friction out of range";
    }
    if (!within(material.restitution, 0.0F, 1.0F)) {
        return "restitution out of range";
    }
    if (!within(material.density, kMinDensity, kMaxDensity)) {
        return "density out of range";
    }
    if (material.friction_rule > Combine::kMaximum ||
        material.restitution_rule > Combine::kMaximum) {
        return "unknown combine rule";
    }
    return {};
}

std::string why_unfit_moments(const BodyDef& def) {
    const bool whole = !def.inertia.isZero(0.0F);
    const bool diagonal = !def.moments.isZero(0.0F);
    if (!has_mass(def.kind) || (!whole && !diagonal)) {
        return {};
    }
    if (whole && diagonal) {
        return "inertia: both the tensor and principal moments are given";
    }
    const auto axes = principal_axes(whole ? Mat3d(def.inertia.cast<double>())
                                           : Mat3d(def.moments.cast<double>().asDiagonal()));
    if (!axes) {
        return axes.error();
    }
    const Vec3d& m = axes->moments;
    const bool in_range = m.minCoeff() >= static_cast<double>(kMinMoment) &&
                          m.maxCoeff() <= static_cast<double>(kMaxMoment);
    return in_range ? std::string() : "inertia: moments " + listed(m) + " out of range 1e-15..1e21";
}

}  // namespace

std::string why_unfit_part(const CompoundPart& part) {
    if (!is_convex(part.shape.kind) || part.shape.kind == ShapeKind::kPlane) {
        return "only spheres, boxes, capsules and hulls can be parts";
    }
    std::string reason = why_unfit_shape(part.shape, BodyKind::kDynamic);
    if (reason.empty()) {
        reason = why_unfit_material(part.material);
    }
    if (reason.empty() && !fit_position(part.frame.position)) {
        reason = "position out of range";
    }
    if (reason.empty() && !fit_orientation(part.frame.rotation)) {
        reason = "orientation is not a unit quaternion";
    }
    return reason;
}

std::string why_unfit(const BodyDef& def) {
    if (def.kind != BodyKind::kStatic && def.kind != BodyKind::kKinematic && !has_mass(def.kind)) {
        return "unknown body kind";
    }
    std::string reason = why_unfit_shape(def.shape, def.kind);
    if (!reason.empty()) {
        return reason;
    }
    if (def.kind == BodyKind::kParticle && def.sensor) {
        return "a particle cannot be a sensor";
    }
    if (has_mass(def.kind) && !within(def.mass, kMinMass, kMaxMass)) {
        return "mass out of range";
    }
    reason = why_unfit_moments(def);
    if (!reason.empty()) {
        return reason;
    }
    reason = why_unfit_material(def.material);
    if (!reason.empty()) {
        return reason;
    }
    if (!within(def.damping.linear, 0.0F, 1.0e4F) || !within(def.damping.angular, 0.0F, 1.0e4F)) {
        return "damping out of range";
    }
    if (!fit_position(def.position)) {
        return "position out of range";
    }
    if (!fit_orientation(def.orientation)) {
        return "orientation is not a unit quaternion";
    }
    if (!fit_velocity(def.velocity, def.angular_velocity)) {
        return "velocity out of range";
    }
    return {};
}

}  // namespace zoned::physics
