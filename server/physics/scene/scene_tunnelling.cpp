// The last guard against tunnelling: no body's centre passes through static geometry in a step.
#include "server/physics/query/shape_ray.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// How deep the centre lies inside the shape, m; of hulls an estimate.
float depth_of_centre(const Shape& shape, const Aabb& bounds) {
    return shape.kind == ShapeKind::kHull ? 0.125F * (bounds.upper - bounds.lower).minCoeff()
                                          : inner_radius(shape);
}

}  // namespace

struct Scene::Impl::GuardedPoint {
    Vec3 local = Vec3::Zero();  ///< in the body's axes, from its centre of mass, m
    float depth = 0.0F;         ///< how deep it lies inside the body, m
    Filter filter;
};

struct Scene::Impl::Surface {
    bool met = false;
    float way = 0.0F;  ///< m along the path
    Vec3 normal = Vec3::Zero();
};

void Scene::Impl::note_starts() {
    starts.resize(bodies.rows());
    for (const std::uint32_t row : bodies.awake_list) {
        starts[row] = {bodies.position[row],
                       bodies.orientation[row],
                       bodies.velocity[row],
                       bodies.angular_velocity[row]};
    }
}

/// Contacts are found for bodies that move straight on. One that is hit off its centre turns within
/// the step, by more than a radian if it is fast: its surface is then not where its contacts are,
/// and they let it through. So may a slow one that spins: a step sees it in one pose of many, and
/// may see the part that is in the wall come out of it each time. A body thinner than contacts may
/// yield would sink through a surface bit by bit. Of compounds the parts are guarded: a ring may
/// have a pole through its centre.
void Scene::Impl::hold_back(float dt) {
    for (const std::uint32_t row : bodies.awake_list) {
        const Shape& shape = bodies.shape[row];
        const float moved2 = (bodies.position[row] - starts[row].position).squaredNorm();
        const float spin2 = bodies.angular_velocity[row].squaredNorm();
        const auto guard = [&](const Vec3& local, float inner, const Filter& filter, bool round) {
            const float depth = 0.5F * inner;
            const float most2 = 2.0F * (moved2 + local.squaredNorm() * spin2 * dt * dt);
            const bool far = local.isZero(0.0F) ? moved2 > depth * depth : most2 > depth * depth;
            if (far || (!round && (spin2 * dt * dt > 1.0F || inner < settings.error_budget_m))) {
                hold_back(row, {local, inner, filter}, dt);
            }
        };
        if (shape.kind != ShapeKind::kCompound) {
            guard(Vec3::Zero(),
                  depth_of_centre(shape, bodies.bounds[row]),
                  bodies.filter[row],
                  shape.kind == ShapeKind::kSphere);
            continue;
        }
        for (const Compound::CompoundChild& child : compound_of(shape).parts()) {
            const Shape& part = child.part.shape;
            if (!child.part.sensor) {
                guard(child.part.frame.position,
                      depth_of_centre(part, shape_bounds(part, Vec3::Zero(), child.rotation)),
                      child.part.filter,
                      part.kind == ShapeKind::kSphere);
            }
        }
    }
}

/// The point goes straight on to where it would meet a surface, and from there to where the solve
/// has put it. Where this second part goes through a surface, the body is put back before it, as
/// deep as the point lies inside the body, and no longer moves towards it.
void Scene::Impl::hold_back(std::uint32_t row, const GuardedPoint& point, float dt) {
    const Vec3 arm = bodies.orientation[row] * point.local;
    Vec3 from = starts[row].position + starts[row].orientation * point.local;
    const Vec3 ahead = dt * starts[row].velocity;
    const Surface hit = first_surface(row, point.filter, from, ahead);
    if (hit.met) {
        from += std::max(0.0F, hit.way - point.depth) * ahead.normalized();
    }
    const Vec3 way = bodies.position[row] + arm - from;
    const Surface wall = first_surface(row, point.filter, from, way);
    if (wall.met) {
        const Vec3 to = from + std::max(0.0F, wall.way - point.depth) * way.normalized();
        bodies.set_pose(row, to - arm, bodies.orientation[row]);
        const float inward = std::min(0.0F, wall.normal.dot(bodies.velocity[row]));
        bodies.velocity[row] -= inward * wall.normal;
        ++held_back;
    }
}

Scene::Impl::Surface Scene::Impl::first_surface(std::uint32_t row,
                                                const Filter& filter,
                                                const Vec3& from,
                                                const Vec3& way) const {
    Surface first;
    first.way = way.norm();
    if (!(first.way > 0.0F)) {
        return first;
    }
    const Vec3 along = way / first.way;
    const auto test = [&](std::uint32_t other, float within) {
        float t = 0.0F;
        Vec3 normal;
        // A body that starts inside comes out as it can.
        if (bodies.sensor[other] == 0 && filter.meets(bodies.filter[other]) &&
            !joints.parts(bodies, row, other) &&
            cast_ray(placed(other), from, along, within, t, normal) && t > 0.0F) {
            first = {true, t, normal};
        }
        return first.way;
    };
    boxes[static_cast<std::size_t>(BodyKind::kStatic)].cast(
        {from, along, Vec3::Zero()}, first.way, test);
    for (const std::uint32_t plane : planes) {
        test(plane, first.way);
    }
    return first;
}

}  // namespace zoned::physics
