// The last guard against tunnelling: no body's centre passes through static geometry in a step.
#include "server/physics/query/shape_ray.h"
#include "server/physics/scene/scene_impl.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// How deep the centre lies inside the shape, m; of hulls an estimate.
float depth_of_centre(const Shape& shape, const Aabb& bounds) {
    return shape.kind == ShapeKind::kHull ? 0.125F * (bounds.upper - bounds.lower).minCoeff()
                                          : inner_radius(shape);
}

}  // namespace

struct Scene::Impl::Surface {
    bool met = false;
    float way = 0.0F;  ///< m along the path
    Vec3 normal = Vec3::Zero();
};

void Scene::Impl::note_starts() {
    starts.resize(bodies.rows());
    for (const std::uint32_t row : bodies.awake_list) {
        starts[row] = {bodies.position[row], bodies.velocity[row]};
    }
}

/// Contacts are found for bodies that move straight on. One that is hit off its centre turns within
/// the step, by more than a radian if it is fast: its surface is then not where its contacts are,
/// and they let it through. So may a slow one that spins: a step sees it in one pose of many, and
/// may see the part that is in the wall come out of it each time. Compounds are left alone: a ring
/// may have a pole through its centre.
void Scene::Impl::hold_back(float dt) {
    for (const std::uint32_t row : bodies.awake_list) {
        const float moved2 = (bodies.position[row] - starts[row].position).squaredNorm();
        const float depth = 0.5F * depth_of_centre(bodies.shape[row], bodies.bounds[row]);
        const ShapeKind kind = bodies.shape[row].kind;
        const bool whirls = kind != ShapeKind::kSphere &&
                            bodies.angular_velocity[row].squaredNorm() * dt * dt > 1.0F;
        if ((moved2 > depth * depth || whirls) && kind != ShapeKind::kCompound) {
            hold_back(row, dt);
        }
    }
}

/// The centre goes straight on to where it would meet a surface, and from there to where the solve
/// has put it. Where this second part goes through a surface, the body is put back before it, as
/// deep as the centre lies inside the body, and no longer moves towards it.
void Scene::Impl::hold_back(std::uint32_t row, float dt) {
    const float depth = depth_of_centre(bodies.shape[row], bodies.bounds[row]);
    Vec3 from = starts[row].position;
    const Vec3 ahead = dt * starts[row].velocity;
    const Surface hit = first_surface(row, from, ahead);
    if (hit.met) {
        from += std::max(0.0F, hit.way - depth) * ahead.normalized();
    }
    const Vec3 way = bodies.position[row] - from;
    const Surface wall = first_surface(row, from, way);
    if (wall.met) {
        const Vec3 to = from + std::max(0.0F, wall.way - depth) * way.normalized();
        bodies.set_pose(row, to, bodies.orientation[row]);
        const float inward = std::min(0.0F, wall.normal.dot(bodies.velocity[row]));
        bodies.velocity[row] -= inward * wall.normal;
        ++held_back;
    }
}

Scene::Impl::Surface Scene::Impl::first_surface(std::uint32_t row,
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
        if (bodies.sensor[other] == 0 && bodies.filter[row].meets(bodies.filter[other]) &&
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
