// Narrowphase part of a step: manifolds, who wakes by being touched, and the events.
#include "server/physics/scene_impl.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

float lowest_gap(const Contact& contact, std::size_t count) {
    float lowest = INFINITY;
    for (std::size_t i = 0; i < count; ++i) {
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
void adopt_points(const Manifold& manifold,
                  const Vec3& xa,
                  const Vec3& xb,
                  std::size_t old_count,
                  Contact& contact) {
    const std::array<ContactPoint, kMaxManifoldPoints> old = contact.points;
    std::array<bool, kMaxManifoldPoints> taken{};
    std::array<bool, kMaxManifoldPoints> served{};
    const auto count = static_cast<std::size_t>(manifold.count);
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

/// True when what was found about a pair still holds.
///
/// Points: most pairs of a pile at rest stand as they stood. The points then stay where they are,
/// and the gaps follow to first order; what that leaves out is of the order of the square of
/// kSamePose. No points: the surfaces were apart by `reach` along some axis, and have not come
/// nearer than they moved.
bool Scene::Impl::reuse_manifold(std::uint32_t index, const PairMotion& motion) {
    const Pair& pair = graph.pair(index);
    const Vec3 shift = bodies.position[pair.b] - bodies.position[pair.a] - pair.found.between;
    const float moved2 = shift.squaredNorm();
    const float spare = pair.found.reach - kContactMargin - motion.turn -
                        motion.dt * (motion.velocity_b - motion.velocity_a).norm();
    const float most = pair.count == 0 ? spare : kSamePose;
    if (!(spare >= 0.0F) || !(moved2 < most * most)) {
        return false;
    }
    const Vec3 turn_a = small_turn(pair.found.orientation_a, bodies.orientation[pair.a]);
    const Vec3 turn_b = small_turn(pair.found.orientation_b, bodies.orientation[pair.b]);
    const float sweep =
        turn_a.norm() * bodies.radius[pair.a] + turn_b.norm() * bodies.radius[pair.b];
    if (pair.count == 0) {
        return std::sqrt(moved2) + sweep <= spare;
    }
    if (!(sweep < kSamePose)) {
        return false;
    }
    Contact& contact = graph[index];
    const float closing = contact.normal.dot(shift);
    for (std::size_t i = 0; i < pair.points(); ++i) {
        ContactPoint& p = contact.points[i];
        p.separation = p.found_separation + closing +
                       contact.normal.dot(turn_b.cross(p.arm_b) - turn_a.cross(p.arm_a));
    }
    return true;
}

void Scene::Impl::find_manifold(std::uint32_t index, const PairMotion& motion) {
    Pair& pair = graph.pair(index);
    const std::uint32_t a = pair.a;
    const std::uint32_t b = pair.b;
    Manifold manifold;
    const Impact impact = collide_ahead(placed(a), placed(b), motion, manifold);
    if (manifold.count > 0 || pair.count > 0) {
        Contact& contact = graph[index];
        contact.normal = manifold.normal;
        contact.lead = -impact.time * (motion.velocity_b - motion.velocity_a);
        adopt_points(manifold,
                     bodies.position[a] + impact.time * motion.velocity_a,
                     bodies.position[b] + impact.time * motion.velocity_b,
                     pair.points(),
                     contact);
    }
    pair.count = static_cast<std::uint8_t>(manifold.count);
    const float gap = manifold.count == 0 ? manifold.separation : 0.0F;
    pair.found.reach = impact.time > 0.0F ? -1.0F : std::max(impact.margin, gap);
    pair.found.between = bodies.position[b] - bodies.position[a];
    pair.found.orientation_a = bodies.orientation[a];
    pair.found.orientation_b = bodies.orientation[b];
}

/// Finds the contact of a pair for this step, and how it approaches.
void Scene::Impl::update_contact(std::uint32_t index, float dt) {
    Pair& pair = graph.pair(index);
    const std::uint32_t a = pair.a;
    const std::uint32_t b = pair.b;
    const PairMotion motion = motion_of(a, b, dt);
    if (!reuse_manifold(index, motion)) {
        find_manifold(index, motion);
    }
    pair.closing = false;
    if (pair.count == 0) {
        pair.age = 0;
        return;
    }
    pair.age = static_cast<std::uint8_t>(std::min(pair.age + 1, 255));
    Contact& contact = graph[index];
    const float pull = dt * contact.normal.dot(settings.gravity) *
                       ((bodies.simulated(b) ? 1.0F : 0.0F) - (bodies.simulated(a) ? 1.0F : 0.0F));
    pair.closing = !contact.lead.isZero(0.0F);
    contact.approach_speed = 0.0F;
    for (std::size_t i = 0; i < pair.points(); ++i) {
        const ContactPoint& p = contact.points[i];
        const Vec3 at_a = bodies.velocity[a] + bodies.angular_velocity[a].cross(p.arm_a);
        const Vec3 at_b = bodies.velocity[b] + bodies.angular_velocity[b].cross(p.arm_b);
        const float closing = contact.normal.dot(at_a - at_b);
        contact.approach_speed = std::max(contact.approach_speed, closing);
        pair.closing |= p.separation <= kTouch || p.separation <= dt * closing - pull;
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
            const bool held = graph.pair(index).touching;
            update_contact(index, dt);
            if (held || graph.pair(index).closing) {
                waker.wake(bodies, graph, joints, other);
            }
        });
    }
    solve_list.clear();
    const std::vector<std::uint32_t>& active = graph.active();
    for (std::size_t i = 0; i < active.size(); ++i) {
        const std::uint32_t index = active[i];
        update_contact(index, dt);
        const Pair& pair = graph.pair(index);
        if (pair.count > 0) {
            solve_list.push_back(index);
        }
        if (pair.closing) {
            for (const std::uint32_t row : {pair.a, pair.b}) {
                if (bodies.is_dynamic(row) && bodies.awake[row] == 0) {
                    waker.wake(bodies, graph, joints, row);
                }
            }
        }
    }
}

/// After the solve: who touches whom now, and what began.
void Scene::Impl::finish_contacts() {
    for (const std::uint32_t index : graph.active()) {
        Pair& pair = graph.pair(index);
        if (pair.count == 0) {
            pair.touching = false;
            continue;
        }
        const Contact& contact = graph[index];
        const bool touches =
            contact.step_impulse > 0.0F ||
            (contact.lead.isZero(0.0F) && lowest_gap(contact, pair.points()) <= kTouch);
        const bool began = touches && !pair.touching;
        pair.touching = touches;
        const bool tagged = bodies.user[pair.a] != 0 || bodies.user[pair.b] != 0;
        if ((began && tagged) || contact.step_impulse >= settings.event_impulse_ns) {
            report(index, began);
        }
    }
}

void Scene::Impl::report(std::uint32_t index, bool began) {
    const Pair& pair = graph.pair(index);
    const Contact& contact = graph[index];
    std::size_t deepest = 0;
    for (std::size_t i = 1; i < pair.points(); ++i) {
        if (contact.points[i].separation < contact.points[deepest].separation) {
            deepest = i;
        }
    }
    ContactEvent event;
    event.a = bodies.id_of(pair.a);
    event.b = bodies.id_of(pair.b);
    event.user_a = bodies.user[pair.a];
    event.user_b = bodies.user[pair.b];
    event.point = bodies.position[pair.a] + contact.points[deepest].arm_a;
    event.normal = contact.normal;
    event.impulse = contact.step_impulse;
    event.approach_speed = contact.approach_speed;
    event.began = began;
    events.push_back(event);
}

}  // namespace zoned::physics
