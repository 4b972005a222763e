// Narrowphase part of a step: manifolds, who wakes by being touched, and the events.
#include "server/physics/scene_impl.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

float lowest_gap(const Contact& contact) {
    float lowest = INFINITY;
    for (std::size_t i = 0; i < static_cast<std::size_t>(contact.count); ++i) {
        lowest = std::min(lowest, contact.points[i].separation);
    }
    return lowest;
}

/// Two points of one contact that lie closer than this in successive steps are one, m.
constexpr float kSamePoint = 0.05F;

/// A pair whose surfaces have moved less than this against each other since its manifold was found
/// keeps it, m.
constexpr float kSamePose = 2.0e-4F;

/// The rotation vector from one orientation to a nearby one, to first order. Large where they are
/// not near, or where the signs of the quaternions differ.
Vec3 small_turn(const Quat& from, const Quat& to) {
    const Vec3 u = from.vec();
    const Vec3 v = to.vec();
    if (from.w() * to.w() + u.dot(v) < 0.5F) {
        return Vec3::Constant(1.0e6F);
    }
    return 2.0F * (from.w() * v - to.w() * u - v.cross(u));
}

/// Takes the impulses over from the points of the last step: from the one that names the same
/// features, else from the nearest. Boxes that lie corner on corner change the names of their
/// points with every breath, and a stack that forgets its load each time sags and walks.
void adopt_points(const Manifold& manifold, const Vec3& xa, const Vec3& xb, Contact& contact) {
    const std::array<ContactPoint, kMaxManifoldPoints> old = contact.points;
    std::array<bool, kMaxManifoldPoints> taken{};
    std::array<bool, kMaxManifoldPoints> served{};
    const auto old_count = static_cast<std::size_t>(contact.count);
    const auto count = static_cast<std::size_t>(manifold.count);
    contact.count = manifold.count;
    for (std::size_t i = 0; i < count; ++i) {
        const ManifoldPoint& from = manifold.points[i];
        ContactPoint& to = contact.points[i];
        to = {
            from.point - xa, from.point - xb, from.separation, from.separation, 0.0F, from.feature};
        for (std::size_t k = 0; k < old_count; ++k) {
            if (!taken[k] && old[k].feature == from.feature) {
                to.impulse = old[k].impulse;
                taken[k] = true;
                served[i] = true;
                break;
            }
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (served[i]) {
            continue;
        }
        std::size_t best = kMaxManifoldPoints;
        float least = kSamePoint * kSamePoint;
        for (std::size_t k = 0; k < old_count; ++k) {
            const float d = (old[k].arm_a - contact.points[i].arm_a).squaredNorm();
            if (!taken[k] && d < least) {
                least = d;
                best = k;
            }
        }
        if (best < kMaxManifoldPoints) {
            contact.points[i].impulse = old[best].impulse;
            taken[best] = true;
        }
    }
    if (manifold.count == 0) {
        contact.friction.setZero();
        contact.twist = 0.0F;
    }
}

}  // namespace

/// How the pair moves in the coming step.
PairMotion Scene::Impl::motion_of(std::uint32_t a, std::uint32_t b, float dt) const {
    const auto turn_of = [&](std::uint32_t row) {
        return bodies.shape[row].kind == ShapeKind::kSphere
                   ? 0.0F
                   : bodies.radius[row] * std::min(1.0F, dt * bodies.angular_velocity[row].norm());
    };
    // A long bar that spins would see contacts all around; what is missed so is found next step.
    const float turn = std::min(turn_of(a) + turn_of(b), 0.1F);
    return {bodies.velocity[a], bodies.velocity[b], turn, dt};
}

/// Most pairs of a pile at rest stand as they stood. The points then stay where they are, and the
/// gaps follow to first order; what that leaves out is of the order of the square of kSamePose.
/// False when the pair has moved, or may within the step come nearer than was looked at.
bool Scene::Impl::reuse_manifold(Contact& contact, const PairMotion& motion) const {
    const std::uint32_t a = contact.a;
    const std::uint32_t b = contact.b;
    const FoundAt& found = contact.found;
    const Vec3 shift = bodies.position[b] - bodies.position[a] - found.between;
    if (!(shift.squaredNorm() < kSamePose * kSamePose)) {
        return false;
    }
    const Vec3 turn_a = small_turn(found.orientation_a, bodies.orientation[a]);
    const Vec3 turn_b = small_turn(found.orientation_b, bodies.orientation[b]);
    const float sweep = std::max(turn_a.squaredNorm() * bodies.radius[a] * bodies.radius[a],
                                 turn_b.squaredNorm() * bodies.radius[b] * bodies.radius[b]);
    const float travel = motion.dt * (motion.velocity_b - motion.velocity_a).norm();
    if (!(sweep < kSamePose * kSamePose) ||
        !(kContactMargin + travel + motion.turn <= found.margin)) {
        return false;
    }
    const float closing = contact.normal.dot(shift);
    for (std::size_t i = 0; i < static_cast<std::size_t>(contact.count); ++i) {
        ContactPoint& p = contact.points[i];
        p.separation = p.found_separation + closing +
                       contact.normal.dot(turn_b.cross(p.arm_b) - turn_a.cross(p.arm_a));
    }
    return true;
}

void Scene::Impl::find_manifold(Contact& contact, const PairMotion& motion) const {
    const std::uint32_t a = contact.a;
    const std::uint32_t b = contact.b;
    Manifold manifold;
    const Impact impact = collide_ahead(placed(a), placed(b), motion, manifold);
    contact.normal = manifold.normal;
    contact.lead = -impact.time * (motion.velocity_b - motion.velocity_a);
    adopt_points(manifold,
                 bodies.position[a] + impact.time * motion.velocity_a,
                 bodies.position[b] + impact.time * motion.velocity_b,
                 contact);
    contact.found.margin = impact.time > 0.0F ? -1.0F : impact.margin;
    contact.found.between = bodies.position[b] - bodies.position[a];
    contact.found.orientation_a = bodies.orientation[a];
    contact.found.orientation_b = bodies.orientation[b];
}

/// Finds the contact of a pair for this step, and how it approaches.
void Scene::Impl::update_contact(std::uint32_t index, float dt) {
    Contact& contact = graph[index];
    const std::uint32_t a = contact.a;
    const std::uint32_t b = contact.b;
    const PairMotion motion = motion_of(a, b, dt);
    if (!reuse_manifold(contact, motion)) {
        find_manifold(contact, motion);
    }
    const float pull = dt * contact.normal.dot(settings.gravity) *
                       ((bodies.simulated(b) ? 1.0F : 0.0F) - (bodies.simulated(a) ? 1.0F : 0.0F));
    contact.closing = !contact.lead.isZero(0.0F) && contact.count > 0;
    contact.approach_speed = 0.0F;
    for (std::size_t i = 0; i < static_cast<std::size_t>(contact.count); ++i) {
        const ContactPoint& p = contact.points[i];
        const Vec3 at_a = bodies.velocity[a] + bodies.angular_velocity[a].cross(p.arm_a);
        const Vec3 at_b = bodies.velocity[b] + bodies.angular_velocity[b].cross(p.arm_b);
        const float closing = contact.normal.dot(at_a - at_b);
        contact.approach_speed = std::max(contact.approach_speed, closing);
        contact.closing |= p.separation <= kTouch || p.separation <= dt * closing - pull;
    }
}

/// Looks at the pairs of awake bodies and of moving kinematic ones; who is touched wakes, and its
/// contacts join the list while it is walked.
void Scene::Impl::update_contacts(float dt) {
    for (const std::uint32_t mover : bodies.mover_list) {
        graph.for_each_of(bodies, mover, [&](std::uint32_t index, std::uint32_t other) {
            if (bodies.simulated(other)) {
                return;  // is in the active list
            }
            const bool held = graph[index].touching;
            if (!near(mover, other)) {
                graph.destroy(bodies, index);
            } else {
                update_contact(index, dt);
            }
            if (held || (near(mover, other) && graph[index].closing)) {
                waker.wake(bodies, graph, other);
            }
        });
    }
    const std::vector<std::uint32_t>& active = graph.active();
    for (std::size_t i = 0; i < active.size();) {
        const std::uint32_t index = active[i];
        const std::uint32_t a = graph[index].a;
        const std::uint32_t b = graph[index].b;
        if (!near(a, b)) {
            graph.destroy(bodies, index);  // another one takes its place in the list
            continue;
        }
        update_contact(index, dt);
        if (graph[index].closing) {
            for (const std::uint32_t row : {a, b}) {
                if (bodies.is_dynamic(row) && bodies.awake[row] == 0) {
                    waker.wake(bodies, graph, row);
                }
            }
        }
        ++i;
    }
    solve_list.clear();
    for (const std::uint32_t index : active) {
        if (graph[index].count > 0) {
            solve_list.push_back(index);
        }
    }
}

/// After the solve: who touches whom now, and what began.
void Scene::Impl::finish_contacts() {
    for (const std::uint32_t index : graph.active()) {
        Contact& contact = graph[index];
        if (contact.count == 0) {
            contact.touching = false;
            contact.step_impulse = 0.0F;
            continue;
        }
        const bool touches = contact.step_impulse > 0.0F ||
                             (contact.lead.isZero(0.0F) && lowest_gap(contact) <= kTouch);
        const bool began = touches && !contact.touching;
        contact.touching = touches;
        const bool tagged = bodies.user[contact.a] != 0 || bodies.user[contact.b] != 0;
        if ((began && tagged) || contact.step_impulse >= settings.event_impulse_ns) {
            report(contact, began);
        }
    }
}

void Scene::Impl::report(const Contact& contact, bool began) {
    std::size_t deepest = 0;
    for (std::size_t i = 1; i < static_cast<std::size_t>(contact.count); ++i) {
        if (contact.points[i].separation < contact.points[deepest].separation) {
            deepest = i;
        }
    }
    ContactEvent event;
    event.a = bodies.id_of(contact.a);
    event.b = bodies.id_of(contact.b);
    event.user_a = bodies.user[contact.a];
    event.user_b = bodies.user[contact.b];
    event.point = bodies.position[contact.a] + contact.points[deepest].arm_a;
    event.normal = contact.normal;
    event.impulse = contact.step_impulse;
    event.approach_speed = contact.approach_speed;
    event.began = began;
    events.push_back(event);
}

}  // namespace zoned::physics
