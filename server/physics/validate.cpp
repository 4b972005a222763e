#include "server/physics/validate.h"

#include "server/physics/shapes/mass_properties.h"

#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// Written so that NaN fails: every comparison with it is false.
bool within(float value, float lower, float upper) {
    return value >= lower && value <= upper;
}

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

std::string why_unfit_integrator(IntegratorKind kind) {
    if (static_cast<std::size_t>(kind) >= kIntegratorKinds.size()) {
        return "unknown integrator";
    }
    if (kind == IntegratorKind::kVerlet) {
        return "verlet: goes by the positions of earlier steps, which impulses and contacts make "
               "void; started anew in each step it is velocity_verlet: take that";
    }
    return {};
}

bool fit_position(const Vec3& position) {
    return (position.array().abs() <= kMaxCoordinate).all();
}

bool fit_velocity(const Vec3& velocity, const Vec3& angular_velocity) {
    return velocity.squaredNorm() <= kMaxSpeed * kMaxSpeed &&
           angular_velocity.squaredNorm() <= kMaxSpin * kMaxSpin;
}

bool fit_force(const Vec3& force, const Vec3& torque) {
    return (force.array().abs() <= kMaxForce).all() && (torque.array().abs() <= kMaxForce).all();
}

bool fit_motor(float speed, float most) {
    return within(most, 0.0F, kMaxForce) && within(speed, -kMaxSpeed, kMaxSpeed);
}

bool fit_orientation(const Quat& orientation) {
    return within(orientation.coeffs().norm(), 0.99F, 1.01F);
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

std::string why_unfit(const JointDef& def) {
    if (static_cast<unsigned>(def.kind) > static_cast<unsigned>(JointKind::kSpring)) {
        return "unknown joint kind";
    }
    if (!fit_position(def.anchor) || !fit_position(def.anchor_b)) {
        return "joint: anchor out of range";
    }
    if (!within(def.axis.norm(), 1.0e-6F, 1.0e6F)) {
        return "joint: axis has no direction";
    }
    if (!(def.length_m <= kMaxSize)) {
        return "joint: length out of range";
    }
    if (!within(def.spring_hz, 0.0F, 1000.0F) || !within(def.spring_damping_ratio, 0.0F, 1000.0F)) {
        return "joint: spring frequency or damping out of range";
    }
    if (def.limited) {
        // A hinge knows its angle up to half a turn either way.
        const float most = def.kind == JointKind::kHinge ? std::numbers::pi_v<float> : kMaxSize;
        if (def.lower > def.upper) {
            return "joint: lower limit above the upper one";
        }
        if (!(def.lower <= most && def.upper >= -most)) {
            return "joint: limit out of range";
        }
    }
    if (def.motor && !fit_motor(def.motor_speed, def.motor_max)) {
        return "joint: motor speed or greatest force out of range";
    }
    if (!(def.break_force_n > 0.0F)) {
        return "joint: force to break at must be positive";
    }
    return {};
}

}  // namespace zoned::physics
