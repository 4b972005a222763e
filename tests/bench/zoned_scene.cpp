#include "tests/bench/zoned_scene.h"

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"
#include "server/physics/shapes/mesh.h"
#include "tests/scenario/solid_geometry.h"

#include <deque>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

/// A shape of ours, and where its axes lie in the solid's.
struct PlacedShape {
    physics::Shape shape;
    physics::Frame frame;
};

template <typename T>
T accepted(core::Result<T> result, const char* thing) {
    if (!result) {
        throw std::runtime_error(std::string("our engine refused a ") + thing + ": " +
                                 result.error());
    }
    return std::move(*result);
}

PlacedShape hull_shape(const scenario::SolidGeometry& geometry) {
    std::vector<Vec3> points;
    for (const Vec3d& p : geometry.points) {
        points.push_back(p.cast<float>());
    }
    const physics::BuiltHull built = accepted(physics::build_hull(points), "hull");
    return {physics::Shape::hull(built.hull), built.frame};
}

PlacedShape mesh_shape(const scenario::SolidGeometry& geometry) {
    std::vector<Vec3> points;
    for (const Vec3d& p : geometry.points) {
        points.push_back(p.cast<float>());
    }
    std::vector<std::uint32_t> indices;
    for (const scenario::SolidFace& face : geometry.faces) {
        indices.insert(indices.end(), face.ring.begin(), face.ring.end());
    }
    return {physics::Shape::mesh(accepted(physics::build_mesh(points, indices), "mesh").mesh), {}};
}

/// Each form is built once, as a world does.
class Shapes {
  public:
    const PlacedShape& of(const scenario::Solid& solid, const physics::Material& material) {
        for (const Known& known : known_) {
            if (known.solid == solid && known.material.friction == material.friction &&
                known.material.restitution == material.restitution) {
                return known.shape;
            }
        }
        known_.push_back({solid, material, build(solid, material)});
        return known_.back().shape;
    }

  private:
    struct Known {
        scenario::Solid solid;
        physics::Material material;
        PlacedShape shape;
    };

    PlacedShape build(const scenario::Solid& solid, const physics::Material& material) {
        switch (solid.form) {
            case scenario::Form::kSphere:
                return {physics::Shape::sphere(static_cast<float>(solid.radius)), {}};
            case scenario::Form::kBox:
                return {physics::Shape::box(solid.half_extents.cast<float>()), {}};
            case scenario::Form::kCapsule:
                return {physics::Shape::capsule(static_cast<float>(solid.radius),
                                                static_cast<float>(solid.half_segment)),
                        {}};
            case scenario::Form::kHull:
                return hull_shape(*solid.geometry);
            case scenario::Form::kMesh:
                return mesh_shape(*solid.geometry);
            case scenario::Form::kCompound:
                return compound_shape(*solid.geometry, material);
        }
        throw std::logic_error("a solid of no form");
    }

    PlacedShape compound_shape(const scenario::SolidGeometry& geometry,
                               const physics::Material& material) {
        std::vector<physics::CompoundPart> parts;
        for (const scenario::SolidPart& part : geometry.parts) {
            const PlacedShape placed = of(part.solid, material);
            const physics::Frame at{part.pose.position.cast<float>(),
                                    part.pose.orientation.cast<float>()};
            physics::CompoundPart out;
            out.shape = placed.shape;
            out.frame = at * placed.frame;
            out.material = material;
            parts.push_back(out);
        }
        const physics::BuiltCompound built = accepted(physics::build_compound(parts), "compound");
        return {physics::Shape::compound(built.compound), built.frame};
    }

    std::deque<Known> known_;  // references stay valid while it grows
};

physics::BodyDef definition(const scenario::Body& body, Shapes& shapes, physics::Frame& frame) {
    physics::BodyDef def;
    def.kind = body.mass > 0.0 ? physics::BodyKind::kDynamic : physics::BodyKind::kStatic;
    def.material.friction = static_cast<float>(body.friction);
    def.material.restitution = static_cast<float>(body.restitution);
    const PlacedShape& placed = shapes.of(body.solid, def.material);
    def.shape = placed.shape;
    frame = placed.frame;
    def.mass = static_cast<float>(body.mass > 0.0 ? body.mass : 1.0);
    const physics::Frame at{body.pose.position.cast<float>(), body.pose.orientation.cast<float>()};
    const physics::Frame engine = at * frame;
    def.position = engine.position;
    def.orientation = engine.rotation;
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

physics::JointKind kind_of(scenario::Link link) {
    switch (link) {
        case scenario::Link::kBall:
            return physics::JointKind::kBall;
        case scenario::Link::kHinge:
            return physics::JointKind::kHinge;
        case scenario::Link::kFixed:
            return physics::JointKind::kFixed;
    }
    throw std::logic_error("a joint of no kind");
}

void add_joint(const scenario::LinkedPair& joint, ZonedScene& out) {
    physics::JointDef def;
    def.kind = kind_of(joint.link);
    def.a =
        joint.a == scenario::kWorld ? zoned::BodyId() : out.ids[static_cast<std::size_t>(joint.a)];
    def.b = out.ids[static_cast<std::size_t>(joint.b)];
    def.anchor = joint.anchor.cast<float>();
    def.axis = joint.axis.cast<float>();
    def.limited = joint.limited;
    def.lower = static_cast<float>(joint.lower);
    def.upper = static_cast<float>(joint.upper);
    def.motor = joint.motor_torque > 0.0;
    def.motor_speed = static_cast<float>(joint.motor_speed);
    def.motor_max = static_cast<float>(joint.motor_torque);
    accepted(out.scene.add_joint(def), "joint");
}

}  // namespace

ZonedScene build_scene(const scenario::Description& description,
                       physics::PhysicsSettings settings) {
    ZonedScene out{physics::Scene(with_description(settings, description)),
                   {},
                   {},
                   static_cast<float>(description.dt)};
    Shapes shapes;
    for (const scenario::Body& body : description.bodies) {
        physics::Frame frame;
        physics::BodyDef def = definition(body, shapes, frame);
        def.filter.mask = description.colliding ? def.filter.mask : 0;
        out.ids.push_back(accepted(out.scene.add(def), "body"));
        out.frames.push_back(frame);
    }
    for (const scenario::LinkedPair& joint : description.joints) {
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
