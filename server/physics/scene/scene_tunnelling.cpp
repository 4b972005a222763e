// The last guard against tunnelling: no body's centre passes through static geometry in a step.
#include "server/physics/query/shape_ray.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// How often an island is solved again because a body of it passed a surface: each time another
/// body may, which the first one has kept from it so far.
constexpr int kGuardRounds = 4;

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
    std::uint32_t row = kNoIndex;
    float way = 0.0F;  ///< m along the path
    Vec3 at = Vec3::Zero();
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
/// yield would sink through a surface bit by bit, as would one under a load that the most substeps
/// do not carry. Of compounds the parts are guarded: a ring may
/// have a pole through its centre.
template <class Visit>
void Scene::Impl::for_each_guarded(std::uint32_t row, float dt, Visit&& visit) const {
    const Shape& shape = bodies.shape[row];
    const float moved2 = (bodies.position[row] - starts[row].position).squaredNorm();
    const float spin2 = bodies.angular_velocity[row].squaredNorm();
    const bool pressed = bodies.substep_level[row] + 1U >= SubstepPolicy::kLevels;
    const auto guard = [&](const Vec3& local, float inner, const Filter& filter, bool round) {
        const float depth = 0.5F * inner;
        const float most2 = 2.0F * (moved2 + local.squaredNorm() * spin2 * dt * dt);
        const bool far = local.isZero(0.0F) ? moved2 > depth * depth : most2 > depth * depth;
        if (far || pressed ||
            (!round && (spin2 * dt * dt > 1.0F || inner < settings.error_budget_m))) {
            visit(GuardedPoint{local, inner, filter});
        }
    };
    if (shape.kind != ShapeKind::kCompound) {
        guard(Vec3::Zero(),
              depth_of_centre(shape, bodies.bounds[row]),
              bodies.filter[row],
              shape.kind == ShapeKind::kSphere);
        return;
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

/// The point goes straight on to where it would meet a surface, and from there to where the solve
/// has put it. The surface is the one that this second part goes through, and `before` lies on the
/// near side of it, by as much as the point lies inside the body.
Scene::Impl::Surface Scene::Impl::surface_passed(std::uint32_t row,
                                                 const GuardedPoint& point,
                                                 float dt,
                                                 Vec3& before) const {
    Vec3 from = starts[row].position + starts[row].orientation * point.local;
    const Vec3 ahead = dt * starts[row].velocity;
    const Surface hit = first_surface(row, point.filter, from, ahead);
    if (hit.met) {
        from += std::max(0.0F, hit.way - point.depth) * ahead.normalized();
    }
    const Vec3 way = bodies.position[row] + bodies.orientation[row] * point.local - from;
    const Surface wall = first_surface(row, point.filter, from, way);
    if (wall.met) {
        before = from + std::max(0.0F, wall.way - point.depth) * way.normalized();
    }
    return wall;
}

/// The last guard: a body that passed a surface is put back, and no longer moves towards it.
void Scene::Impl::hold_back(float dt) {
    for (const std::uint32_t row : bodies.awake_list) {
        for_each_guarded(row, dt, [&](const GuardedPoint& point) {
            Vec3 before;
            const Surface wall = surface_passed(row, point, dt, before);
            if (wall.met) {
                const Vec3 arm = bodies.orientation[row] * point.local;
                bodies.set_pose(row, before - arm, bodies.orientation[row]);
                const float inward = std::min(0.0F, wall.normal.dot(bodies.velocity[row]));
                bodies.velocity[row] -= inward * wall.normal;
                ++held_back;
            }
        });
    }
}

/// Solves islands with joints: put back after the solve, a body would leave its joints behind. So
/// an island in which one passed a surface is solved again with a further contact there.
void Scene::Impl::solve_guarded(const SubstepPolicy::SubstepBatch& batch, float dt) {
    const TornIslands::StepView view{bodies, graph, joints, substep_policy, starts};
    SubstepPolicy::SubstepBatch again = batch;
    for (int round = 0;; ++round) {
        solve_batch(again, dt);
        passed.clear();
        for (const std::uint32_t row : torn.rows()) {
            guard(row, dt);
        }
        if (passed.empty() || round == kGuardRounds ||
            !torn.take_back_of(view, passed, batch.substeps, broken)) {
            return;
        }
        again.contacts = torn.contacts();
        again.joints = torn.joints();
    }
}

/// Adds the contacts that would have held a body on joints.
void Scene::Impl::guard(std::uint32_t row, float dt) {
    if (bodies.first_joint[row] == kNoIndex) {
        return;
    }
    for_each_guarded(row, dt, [&](const GuardedPoint& point) {
        Vec3 before;
        const Surface wall = surface_passed(row, point, dt, before);
        const Vec3 now = bodies.position[row] + bodies.orientation[row] * point.local;
        const float budget = settings.error_budget_m;
        if (wall.met && (now - before).squaredNorm() > budget * budget) {
            add_guard(row, point, wall);
        }
    });
}

/// The ball about the point that lies inside the body stays before the surface, however the body
/// turns within the step. What the body's own contacts have to say about friction and bounces they
/// say themselves.
void Scene::Impl::add_guard(std::uint32_t row, const GuardedPoint& point, const Surface& wall) {
    // The broadphase may know of no pair: a blow can throw a body out of the box that it would
    // reach.
    const std::uint32_t record =
        graph.make_record(std::min(row, wall.row), std::max(row, wall.row));
    const bool first = graph.pair(record).a == row;
    Contact contact;
    contact.normal = first ? Vec3(-wall.normal) : wall.normal;
    contact.grip.friction = contact.grip.restitution = 0.0F;
    const Vec3 arm = starts[row].orientation * point.local;
    const Vec3 at = starts[row].position + arm;
    ContactPoint& touch = contact.points.front();
    touch.separation = touch.found_separation = wall.normal.dot(at - wall.at) - point.depth;
    touch.arm_a = first ? arm : Vec3(at - bodies.position[wall.row]);
    touch.arm_b = first ? Vec3(at - bodies.position[wall.row]) : arm;
    graph[record] = contact;
    graph.pair(record).count = 1;
    guards.push_back(record);
    torn.add(record, contact);
    passed.push_back(row);
}

/// Guards hold for one step.
void Scene::Impl::drop_guards() {
    held_back += static_cast<std::uint32_t>(guards.size());
    for (; !guards.empty(); guards.pop_back()) {
        graph.pair(guards.back()) = Pair();
        graph[guards.back()] = Contact();
        graph.drop_record(guards.back());
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
            first = {true, other, t, from + t * along, normal};
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
