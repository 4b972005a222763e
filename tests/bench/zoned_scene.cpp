#include "tests/bench/zoned_scene.h"

#include <stdexcept>

namespace zoned::bench {

namespace {

physics::Shape zoned_shape_of(const scenario::Solid& solid) {
    switch (solid.form) {
        case scenario::Form::kSphere:
            return physics::Shape::sphere(static_cast<float>(solid.radius));
        case scenario::Form::kBox:
            return physics::Shape::box(solid.half_extents.cast<float>());
        case scenario::Form::kCapsule:
            return physics::Shape::capsule(static_cast<float>(solid.radius),
                                           static_cast<float>(solid.half_segment));
    }
    throw std::logic_error("a solid of no form");
}

physics::BodyDef definition(const scenario::Body& body) {
    physics::BodyDef def;
    def.kind = body.mass > 0.0 ? physics::BodyKind::kDynamic : physics::BodyKind::kStatic;
    def.shape = zoned_shape_of(body.solid);
    def.material.friction = static_cast<float>(body.friction);
    def.material.restitution = static_cast<float>(body.restitution);
    def.mass = static_cast<float>(body.mass > 0.0 ? body.mass : 1.0);
    def.position = body.pose.position.cast<float>();
    def.orientation = body.pose.orientation.cast<float>();
    def.velocity = body.velocity.cast<float>();
    def.angular_velocity = body.spin.cast<float>();
    return def;
}

physics::PhysicsSettings with_description(physics::PhysicsSettings settings,
                                          const scenario::Description& description) {
    settings.gravity = description.gravity.cast<float>();
    if (!description.sleeping) {
        settings.sleep_after_s = 0.0F;
    }
    return settings;
}

void add_joint(const scenario::BallJoint& joint, ZonedScene& out) {
    physics::JointDef def;
    def.a =
        joint.a == scenario::kWorld ? zoned::BodyId() : out.ids[static_cast<std::size_t>(joint.a)];
    def.b = out.ids[static_cast<std::size_t>(joint.b)];
    def.anchor = joint.anchor.cast<float>();
    auto id = out.scene.add_joint(def);
    if (!id) {
        throw std::runtime_error("our engine refused a joint: " + id.error());
    }
}

}  // namespace

ZonedScene build_scene(const scenario::Description& description,
                       physics::PhysicsSettings settings) {
    ZonedScene out{physics::Scene(with_description(settings, description)),
                   {},
                   static_cast<float>(description.dt)};
    for (const scenario::Body& body : description.bodies) {
        physics::BodyDef def = definition(body);
        def.filter.mask = description.colliding ? def.filter.mask : 0;
        auto id = out.scene.add(def);
        if (!id) {
            throw std::runtime_error("our engine refused a body: " + id.error());
        }
        out.ids.push_back(*id);
    }
    for (const scenario::BallJoint& joint : description.joints) {
        add_joint(joint, out);
    }
    return out;
}

std::vector<NamedMethod> contact_methods() {
    using physics::SolverVariant;
    const auto points = physics::ManifoldMode::kPoints;
    return {{"jacobi", SolverVariant::kJacobi, points},
            {"gauss_seidel", SolverVariant::kGaussSeidel, points},
            {"over_relaxation", SolverVariant::kOverRelaxation, points},
            {"conjugate_gradient", SolverVariant::kConjugateGradient, points},
            {"direct", SolverVariant::kDirect, points},
            {"direct_divided", SolverVariant::kDirect, physics::ManifoldMode::kDivided},
            {"impulse", SolverVariant::kImpulse, points},
            {"projection", SolverVariant::kProjection, points},
            {"penalty", SolverVariant::kPenalty, points}};
}

}  // namespace zoned::bench
