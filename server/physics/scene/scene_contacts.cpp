// Narrowphase part of a step: manifolds, bodies that wake because they are touched, and the events.
#include "server/physics/contacts/contact_persistence.h"
#include "server/physics/scene/scene_impl.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// A pair whose surfaces have moved less than this against each other since its manifold was found
/// keeps it, m.
constexpr float kSamePose = 2.0e-4F;
/// Pairs that one thread looks at at a time.
constexpr std::size_t kPairGrain = 64;

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

}  // namespace

/// How the pair moves in the coming step.
PairMotion Scene::Impl::motion_of(std::uint32_t a, std::uint32_t b, float dt) const {
    const auto turn_of = [&](std::uint32_t row) {
        return bodies.shape[row].kind == ShapeKind::kSphere
                   ? 0.0F
                   : bodies.radius[row] * std::min(1.0F, dt * bodies.angular_velocity[row].norm());
    };
    // A long bar that spins would see contacts all around; one that is missed so is found next
    // step.
    const float turn = std::min(turn_of(a) + turn_of(b), 0.1F);
    return {bodies.velocity[a], bodies.velocity[b], turn, dt};
}

/// True when the last result for a pair still holds.
///
/// Points: most pairs of a pile at rest stand as they stood. The points then stay where they are,
/// and the gaps follow to first order; the error is of the order of the square of kSamePose. No
/// points: the surfaces were apart by `reach` along some axis, and have not come nearer than they
/// moved.
bool Scene::Impl::reuse_manifold(std::uint32_t index, const PairMotion& motion) {
    const Pair& pair = graph.pair(index);
    PairShift shifted;
    shifted.shift = bodies.position[pair.b] - bodies.position[pair.a] - pair.found.between;
    const float moved2 = shifted.shift.squaredNorm();
    const float spare = pair.found.reach - kContactMargin - motion.turn -
                        motion.dt * (motion.velocity_b - motion.velocity_a).norm();
    const bool empty = pair.several != 0 ? graph[index].chain == kNoIndex : pair.count == 0;
    const float most = empty ? spare : kSamePose;
    if (!(spare >= 0.0F) || !(moved2 < most * most)) {
        return false;
    }
    shifted.turn_a = small_turn(pair.found.orientation_a, bodies.orientation[pair.a]);
    shifted.turn_b = small_turn(pair.found.orientation_b, bodies.orientation[pair.b]);
    const float sweep = shifted.turn_a.norm() * bodies.radius[pair.a] +
                        shifted.turn_b.norm() * bodies.radius[pair.b];
    if (empty) {
        return std::sqrt(moved2) + sweep <= spare;
    }
    if (!(sweep < kSamePose)) {
        return false;
    }
    graph.for_chain(index, [&](std::uint32_t record) {
        follow_gaps(shifted, graph.pair(record).points(), graph[record]);
    });
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
        contact.grip = combine(bodies.material[a], bodies.material[b]);
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

/// Works out how the found points approach each other.
void Scene::Impl::approach(std::uint32_t index, const PairMotion& motion) {
    Pair& pair = graph.pair(index);
    const std::uint32_t a = pair.a;
    const std::uint32_t b = pair.b;
    const float dt = motion.dt;
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

/// Finds the contact of a pair of simple shapes for this step, and how it approaches. Writes
/// nothing but the records of the pair.
void Scene::Impl::update_pair(std::uint32_t index, float dt) {
    const PairMotion motion = motion_of(graph.pair(index).a, graph.pair(index).b, dt);
    if (!reuse_manifold(index, motion)) {
        find_manifold(index, motion);
    }
    approach(index, motion);
}

/// The same for any pair.
void Scene::Impl::update_contact(std::uint32_t index, float dt) {
    const Pair& pair = graph.pair(index);
    if (pair.sensor != 0) {
        look_into_sensor(index);
    } else if (pair.several != 0) {
        update_chain(index, motion_of(pair.a, pair.b, dt));
    } else {
        update_pair(index, dt);
    }
}

/// Puts the contacts of a pair on the list for the solver; a touched body wakes.
void Scene::Impl::take_part(std::uint32_t index) {
    note_sensing(index);
    const Pair& pair = graph.pair(index);
    graph.for_chain(index, [&](std::uint32_t record) {
        if (graph.pair(record).count > 0) {
            solve_list.push_back(record);
        }
    });
    if (pair.closing) {
        for (const std::uint32_t row : {pair.a, pair.b}) {
            if (bodies.is_dynamic(row) && bodies.awake[row] == 0) {
                waker.wake(bodies, graph, joints, row);
            }
        }
    }
}

/// Looks at the pairs of awake bodies and of moving kinematic ones: first those of simple shapes,
/// by all threads. Then one thread goes through the list and sees to the others. A touched body
/// wakes, and its contacts join the list while it is walked.
void Scene::Impl::update_contacts(float dt) {
    for (const std::uint32_t mover : bodies.mover_list) {
        graph.for_each_of(bodies, mover, [&](std::uint32_t index, std::uint32_t other) {
            if (bodies.simulated(other)) {
                return;  // is in the active list
            }
            const bool held = graph.pair(index).touching;
            update_contact(index, dt);
            note_sensing(index);
            if (held || graph.pair(index).closing) {
                waker.wake(bodies, graph, joints, other);
            }
        });
    }
    solve_list.clear();
    const std::vector<std::uint32_t>& active = graph.active();
    const std::size_t count = active.size();
    const auto simple = [&](std::uint32_t index) {
        return graph.pair(index).sensor == 0 && graph.pair(index).several == 0;
    };
    team->run(count, kPairGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (simple(active[i])) {
                update_pair(active[i], dt);
            }
        }
    });
    for (std::size_t i = 0; i < active.size(); ++i) {
        if (i >= count || !simple(active[i])) {
            update_contact(active[i], dt);
        }
        take_part(active[i]);
    }
}

/// After the solve: finds the touching pairs, and those of them with touch_changes.
void Scene::Impl::settle_contacts() {
    const std::vector<std::uint32_t>& active = graph.active();
    touch_changes.resize(active.size());
    team->run(active.size(), kPairGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            touch_changes[i] = settle_pair(active[i]);
        }
    });
}

/// Writes nothing but the records of the pair.
Scene::Impl::TouchChange Scene::Impl::settle_pair(std::uint32_t index) {
    const bool touched = graph.pair(index).touching;
    bool touches = false;
    float impulse = 0.0F;
    graph.for_chain(index, [&](std::uint32_t record) {
        Pair& pair = graph.pair(record);
        pair.touching = false;
        if (pair.count == 0) {
            return;
        }
        const Contact& contact = graph[record];
        for (std::size_t i = 0; i < pair.points(); ++i) {
            pair.touching |= contact.step_impulse > 0.0F ||
                             (contact.lead.isZero(0.0F) && contact.points[i].separation <= kTouch);
        }
        touches |= pair.touching;
        impulse += contact.step_impulse;
    });
    Pair& pair = graph.pair(index);
    pair.touching = touches;
    if (impulse == 0.0F && !touches && !touched) {
        return TouchChange::kNone;
    }
    const TouchChange change = touch_change_of(pair, touched, impulse);
    if (change != TouchChange::kNone) {
        graph[index].step_impulse = impulse;
    }
    return change;
}

void Scene::Impl::report_contacts() {
    for (std::size_t i = 0; i < graph.active().size(); ++i) {
        if (touch_changes[i] != TouchChange::kNone) {
            ContactEvent event = contact_event(graph.active()[i]);
            event.began = touch_changes[i] == TouchChange::kBegan;
            event.ended = touch_changes[i] == TouchChange::kEnded;
            events.push_back(event);
        }
    }
}

/// The change to report of a pair, if a body asked for it.
Scene::Impl::TouchChange Scene::Impl::touch_change_of(const Pair& pair,
                                                      bool touched,
                                                      float impulse) const {
    const bool began = pair.touching && !touched;
    const bool tagged = bodies.user[pair.a] != 0 || bodies.user[pair.b] != 0;
    const TouchChange change = began                       ? TouchChange::kBegan
                               : pair.touching || !touched ? TouchChange::kLasts
                                                           : TouchChange::kEnded;
    if ((began && tagged) || impulse >= settings.event_impulse_ns) {
        return change;
    }
    if (bodies.reporting > 0 && (pair.touching || touched)) {
        const int asked = bodies.events[pair.a] | bodies.events[pair.b];
        const int phase = began ? kTellBegin : pair.touching ? kTellPersist : kTellEnd;
        return (asked & phase) != 0 ? change : TouchChange::kNone;
    }
    return TouchChange::kNone;
}

void Scene::Impl::end_touch(std::uint32_t index, std::vector<ContactEvent>& out) {
    const Pair& pair = graph.pair(index);
    if (bodies.reporting == 0 || !pair.touching ||
        ((bodies.events[pair.a] | bodies.events[pair.b]) & kTellEnd) == 0) {
        return;
    }
    ContactEvent event = contact_event(index);
    event.impulse = 0.0F;
    event.approach_speed = 0.0F;
    event.ended = true;
    out.push_back(event);
}

/// Point, normal and depth are those of the deepest point of all; where there is none any more, the
/// point is the middle between the bodies.
ContactEvent Scene::Impl::contact_event(std::uint32_t index) const {
    const Pair& pair = graph.pair(index);
    ContactEvent event;
    event.a = bodies.id_of(pair.a);
    event.b = bodies.id_of(pair.b);
    event.user_a = bodies.user[pair.a];
    event.user_b = bodies.user[pair.b];
    event.impulse = graph[index].step_impulse;
    event.approach_speed = graph[index].approach_speed;
    event.point = 0.5F * (bodies.position[pair.a] + bodies.position[pair.b]);
    event.normal = graph[index].normal;
    float lowest = INFINITY;
    graph.for_chain(index, [&](std::uint32_t record) {
        const Contact& contact = graph[record];
        for (std::size_t i = 0; i < graph.pair(record).points(); ++i) {
            if (contact.points[i].separation < lowest) {
                lowest = contact.points[i].separation;
                event.point = bodies.position[pair.a] + contact.points[i].arm_a;
                event.normal = contact.normal;
                event.depth = std::max(0.0F, -lowest);
            }
        }
    });
    return event;
}

}  // namespace zoned::physics
