#include "server/config/types/type_shapes.h"

#include "server/config/text/config_numbers.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/compound/outer_hull.h"
#include "server/physics/shapes/convex/hull.h"
#include "proto/config/config.pb.h"

#include <string>
#include <vector>

namespace zoned::config {

namespace {

core::Result<physics::BuiltHull> hull_of_points(const proto::config::Hull& hull) {
    std::vector<Vec3> points;
    for (const auto& point : hull.point()) {
        points.emplace_back(narrow(point.x_m()), narrow(point.y_m()), narrow(point.z_m()));
    }
    return physics::build_hull(points);
}

core::Result<physics::CompoundPart> part_of(const proto::config::Part& part,
                                            const proto::config::Type& type) {
    physics::CompoundPart out;
    out.frame.position = Vec3(narrow(part.x_m()), narrow(part.y_m()), narrow(part.z_m()));
    out.frame.rotation = narrow(turn(part.yaw_deg(), part.pitch_deg(), part.roll_deg()));
    out.material.friction = narrow(type.friction());
    out.material.restitution = narrow(type.restitution());
    out.material.rolling_m = narrow(type.rolling_friction_m());
    out.material.spinning_m = narrow(type.spinning_friction_m());
    out.material.density = narrow(part.density_kgpm3());
    switch (part.shape_case()) {
        case proto::config::Part::kBox:
            out.shape = physics::Shape::box(0.5F * Vec3(narrow(part.box().x_m()),
                                                        narrow(part.box().y_m()),
                                                        narrow(part.box().z_m())));
            return out;
        case proto::config::Part::kSphere:
            out.shape = physics::Shape::sphere(narrow(part.sphere().radius_m()));
            return out;
        case proto::config::Part::kCapsule:
            out.shape = physics::Shape::capsule(narrow(part.capsule().radius_m()),
                                                narrow(0.5 * part.capsule().length_m()));
            return out;
        case proto::config::Part::kHull: {
            auto hull = hull_of_points(part.hull());
            if (!hull) {
                return core::Result<physics::CompoundPart>::failure(hull.error());
            }
            out.shape = physics::Shape::hull(hull->hull);
            out.frame = out.frame * hull->frame;
            return out;
        }
        case proto::config::Part::SHAPE_NOT_SET:
            break;
    }
    return core::Result<physics::CompoundPart>::failure(
        "it needs a shape: box, sphere, capsule or hull { ... }");
}

Solid solid_of(const physics::Shape& shape, const physics::Frame& frame, float radius) {
    Solid out;
    out.shape = shape;
    out.stands = frame.rotation;
    out.centre = frame.position;
    out.standing = physics::shape_bounds(shape, Vec3::Zero(), frame.rotation.toRotationMatrix());
    out.radius = radius;
    return out;
}

}  // namespace

core::Result<Solid> build_solid(const proto::config::Type& type) {
    if (type.has_hull()) {
        const auto built = hull_of_points(type.hull());
        if (!built) {
            return core::Result<Solid>::failure(built.error());
        }
        return solid_of(physics::Shape::hull(built->hull), built->frame, built->hull->radius());
    }
    std::vector<physics::CompoundPart> parts;
    for (int i = 0; i < type.compound().part_size(); ++i) {
        auto part = part_of(type.compound().part(i), type);
        if (!part) {
            return core::Result<Solid>::failure("part " + std::to_string(i + 1) + ": " +
                                                part.error());
        }
        parts.push_back(std::move(*part));
    }
    const auto built = physics::build_compound(parts);
    if (!built) {
        return core::Result<Solid>::failure(built.error());
    }
    Solid out = solid_of(
        physics::Shape::compound(built->compound), built->frame, built->compound->radius());
    if (type.representation().single_beyond_m() > 0.0) {
        const auto outer = physics::outer_hull_of(*built->compound);
        if (!outer) {
            return core::Result<Solid>::failure("the hull around it: " + outer.error());
        }
        out.outer = physics::Shape::compound(outer->compound);
        out.outer_cut_m = outer->cut_off;
    }
    return out;
}

Mat3 given_inertia(const proto::config::Type& type, const Quat& stands) {
    const proto::config::Inertia& from = type.inertia();
    Eigen::Matrix3d given;
    given << from.xx_kg_m2(), from.xy_kg_m2(), from.xz_kg_m2(),  //
        from.xy_kg_m2(), from.yy_kg_m2(), from.yz_kg_m2(),       //
        from.xz_kg_m2(), from.yz_kg_m2(), from.zz_kg_m2();
    const Eigen::Matrix3d turn = stands.cast<double>().toRotationMatrix();
    const Eigen::Matrix3d turned = turn.transpose() * given * turn;
    return (0.5 * (turned + turned.transpose())).cast<float>();
}

}  // namespace zoned::config
