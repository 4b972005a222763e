// Broadphase part of a step: which pairs of bodies may touch.
#include "server/physics/contacts/contact_persistence.h"
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/bounds.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// How far a body may go before the broadphase hears of it again, m.
constexpr float kFatMargin = 0.05F;

/// True when some part of the box lies below the plane.
bool dips_into(const Aabb& box, const Vec3& origin, const Vec3& up) {
    const Vec3 centre = 0.5F * (box.lower + box.upper);
    const Vec3 half = 0.5F * (box.upper - box.lower);
    return up.dot(centre - origin) <= up.cwiseAbs().dot(half);
}

/// The box of all that a body may reach in the coming step, margin included.
Aabb reach_of(const Aabb& bounds,
              const Vec3& position,
              float radius,
              const Vec3& travel,
              float turn) {
    // Turning carries no point farther than the arc, nor out of the bounding sphere.
    const Vec3 most = Vec3::Constant(radius + kContactMargin);
    const Vec3 spread = Vec3::Constant(kContactMargin + turn * radius);
    const Aabb turned{(bounds.lower - spread).cwiseMax(position - most),
                      (bounds.upper + spread).cwiseMin(position + most)};
    return swept(turned, travel);
}

/// Whether a ball of that radius stays inside `outer` all along a straight move.
bool encloses(const Ball& outer, const Vec3& from, const Vec3& travel, float radius) {
    const float slack = outer.radius - radius;
    const Vec3 off = from - outer.centre;
    const float far = std::max(off.squaredNorm(), (off + travel).squaredNorm());
    return slack >= 0.0F && far <= slack * slack;
}

}  // namespace

/// Bounds of a body that stays where it is; the contact margin is part of all bounds.
void Scene::Impl::fit_bounds_at_rest(std::uint32_t row) {
    const Aabb box = bodies.bounds[row].grown(kContactMargin);
    bodies.fat[row] = box;
    // Static bodies may lie anywhere about their position.
    const bool fixed = bodies.kind[row] == BodyKind::kStatic;
    fat_balls[row] =
        fixed ? Ball{0.5F * (box.lower + box.upper), 0.5F * (box.upper - box.lower).norm()}
              : Ball{bodies.position[row], bodies.radius[row] + kContactMargin};
}

void Scene::Impl::mark_pending(std::uint32_t row) {
    if (pending_mark[row] == 0) {
        pending_mark[row] = 1;
        pending.push_back(row);
    }
}

/// Tells the broadphase about the fat boxes that are new.
void Scene::Impl::hand_over_boxes(BodyKind kind) {
    boxes[static_cast<std::size_t>(kind)].update(refitted, bodies.fat);
    for (const std::uint32_t row : refitted) {
        mark_pending(row);
    }
    refitted.clear();
}

/// Sees to it that the fat box of each body that may move holds all that it can reach in the step.
void Scene::Impl::refresh_bounds(float dt) {
    const auto refresh = [&](std::uint32_t row, const Vec3& pull) {
        const Vec3 travel = dt * bodies.velocity[row] + dt * dt * pull;
        const float turn = std::min(1.0F, dt * bodies.angular_velocity[row].norm());
        const Vec3& x = bodies.position[row];
        const float radius = bodies.radius[row] + kContactMargin;
        const Aabb reach = reach_of(bodies.bounds[row], x, bodies.radius[row], travel, turn);
        if (!encloses(bodies.fat[row], reach) || !encloses(fat_balls[row], x, travel, radius)) {
            bodies.fat[row] = reach.grown(kFatMargin);
            fat_balls[row] = {x + 0.5F * travel, radius + 0.5F * travel.norm() + kFatMargin};
            refitted.push_back(row);
        }
    };
    for (const std::uint32_t row : bodies.awake_list) {
        refresh(row, settings.gravity);
    }
    hand_over_boxes(BodyKind::kDynamic);
    for (const std::uint32_t row : bodies.mover_list) {
        refresh(row, Vec3::Zero());
    }
    hand_over_boxes(BodyKind::kKinematic);
}

/// The broadphase answers queries between steps too, so its boxes must hold the bodies wherever the
/// solver put them.
void Scene::Impl::follow_bounds() {
    const auto follow = [&](const std::vector<std::uint32_t>& list, BodyKind kind) {
        for (const std::uint32_t row : list) {
            if (!encloses(bodies.fat[row], bodies.bounds[row])) {
                fit_bounds_at_rest(row);
                refitted.push_back(row);
            }
        }
        hand_over_boxes(kind);
    };
    follow(bodies.awake_list, BodyKind::kDynamic);
    follow(bodies.mover_list, BodyKind::kKinematic);
}

bool Scene::Impl::near(std::uint32_t a, std::uint32_t b) const {
    if (bodies.is_plane(a)) {
        return dips_into(bodies.fat[b], bodies.position[a], bodies.rotation[a].col(1));
    }
    if (bodies.is_plane(b)) {
        return dips_into(bodies.fat[a], bodies.position[b], bodies.rotation[b].col(1));
    }
    return fat_balls[a].overlaps(fat_balls[b]) && bodies.fat[a].overlaps(bodies.fat[b]);
}

/// Ends the pairs of a body whose filters allow them no more.
void Scene::Impl::drop_unmet_pairs(std::uint32_t row) {
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        if (!bodies.filter[row].meets(bodies.filter[other])) {
            drop_pair(contact, other);
        }
    });
}

/// Wakes the dynamic bodies near a static or kinematic one that did not meet it before: asleep,
/// they would stay within it for ever.
void Scene::Impl::wake_who_is_met(std::uint32_t row, const Filter& before) {
    disturbed.clear();
    const auto consider = [&](std::uint32_t other) {
        if (bodies.filter[row].meets(bodies.filter[other]) && !before.meets(bodies.filter[other]) &&
            near(row, other)) {
            disturbed.push_back(other);
        }
    };
    if (!bodies.is_plane(row)) {
        boxes[static_cast<std::size_t>(BodyKind::kDynamic)].query(bodies.fat[row], consider);
    } else {
        for (std::uint32_t other = 0; other < bodies.rows(); ++other) {
            if (bodies.alive[other] != 0 && bodies.is_dynamic(other)) {
                consider(other);
            }
        }
    }
    // The next passes must not depend on the structure that found them.
    std::sort(disturbed.begin(), disturbed.end());
    for (const std::uint32_t other : disturbed) {
        wake(other);
    }
}

void Scene::Impl::set_filter(std::uint32_t row, const Filter& filter) {
    const Filter before = bodies.filter[row];
    if (before.category == filter.category && before.mask == filter.mask) {
        return;
    }
    bodies.filter[row] = filter;
    wake(row);
    if (bodies.is_particle(row)) {
        return;  // asks at each bump
    }
    drop_unmet_pairs(row);
    disturb_particles(row);
    if (!bodies.is_dynamic(row)) {
        wake_who_is_met(row, before);
    }
    mark_pending(row);
}

/// Drops stale rows, and rows that came twice because another body took a row over.
void Scene::Impl::sort_pending() {
    std::erase_if(pending, [&](std::uint32_t row) { return pending_mark[row] == 0; });
    if (!std::is_sorted(pending.begin(), pending.end())) {
        std::sort(pending.begin(), pending.end());
    }
    pending.erase(std::unique(pending.begin(), pending.end()), pending.end());
}

/// Ends the pairs of the bodies whose box is new that are not near any more.
void Scene::Impl::drop_far_pairs() {
    // With many new boxes it is cheaper to go through all pairs in a row than from one pair of a
    // body to the next; the rest are the pairs at rest.
    const bool many = 16 * pending.size() > graph.active().size();
    for (std::size_t i = 0; many && i < graph.active().size();) {
        const std::uint32_t contact = graph.active()[i];
        const Pair& pair = graph.pair(contact);
        const bool fresh = pending_mark[pair.a] != 0 || pending_mark[pair.b] != 0;
        if (fresh && !near(pair.a, pair.b)) {
            end_sensing(contact, sensor_events);
            end_touch(contact, events);
            graph.destroy(bodies, contact);  // another one takes its place in the list
        } else {
            ++i;
        }
    }
    for (const std::uint32_t row : pending) {
        if (many && bodies.simulated(row)) {
            continue;
        }
        graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
            if (!near(row, other)) {
                end_sensing(contact, sensor_events);
                end_touch(contact, events);
                graph.destroy(bodies, contact);
            }
        });
    }
}

/// Of two bodies whose boxes are new, the one that is looked at first finds the pair.
bool Scene::Impl::found_before(std::uint32_t row, std::uint32_t other) const {
    return pending_mark[other] != 0 && other <= row;
}

/// Adds a pair, unless it is known or must not collide.
void Scene::Impl::meet(std::uint32_t row, std::uint32_t other) {
    if (bodies.filter[row].meets(bodies.filter[other]) && !joints.parts(bodies, row, other) &&
        !graph.contains(row, other)) {
        new_pairs.emplace_back(std::min(row, other), std::max(row, other));
    }
}

/// Meets the bodies of one kind that are near.
void Scene::Impl::meet_kind(std::uint32_t row, BodyKind kind) {
    const Ball ball = fat_balls[row];
    boxes[static_cast<std::size_t>(kind)].query(bodies.fat[row], [&](std::uint32_t other) {
        if (!found_before(row, other) && ball.overlaps(fat_balls[other])) {
            meet(row, other);
        }
    });
}

/// Pairs of a body whose box is new in which only one of the two is dynamic.
void Scene::Impl::meet_fixed(std::uint32_t row) {
    if (bodies.is_plane(row)) {
        for (std::uint32_t other = 0; other < bodies.rows(); ++other) {
            if (bodies.alive[other] != 0 && bodies.is_dynamic(other) && !found_before(row, other) &&
                near(row, other)) {
                meet(row, other);
            }
        }
    } else if (!bodies.is_dynamic(row)) {
        meet_kind(row, BodyKind::kDynamic);
    } else {
        meet_kind(row, BodyKind::kStatic);
        meet_kind(row, BodyKind::kKinematic);
        for (const std::uint32_t plane : planes) {
            if (!found_before(row, plane) && near(row, plane)) {
                meet(row, plane);
            }
        }
    }
}

/// Looks for partners of the first `count` pending bodies until there are more than `most` pairs:
/// then the lowest pairs of the last body are kept. Returns for how many bodies all were found.
template <class Meet>
std::size_t Scene::Impl::meet_each(std::size_t count, std::size_t most, Meet&& meet_all) {
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t before = new_pairs.size();
        meet_all(pending[i]);
        if (new_pairs.size() > most) {
            std::sort(new_pairs.begin() + static_cast<std::ptrdiff_t>(before), new_pairs.end());
            new_pairs.resize(std::max(before, most));
            return i;
        }
    }
    return count;
}

/// Looks for partners of the bodies whose box is new, by ascending rows. Pairs with the bodies that
/// hold the dynamic ones up come first and have room of their own: a crowd must not make others
/// fall through the floor. A body that finds no room waits for the next step.
void Scene::Impl::find_pairs(float dt) {
    new_pairs.clear();
    sort_pending();
    drop_far_pairs();
    const auto room_within = [&](std::size_t limit) {
        return limit - std::min<std::size_t>(limit, graph.size());
    };
    const std::size_t limit = settings.max_pairs;
    const std::size_t room_for_dynamic = room_within(limit);
    std::size_t done = meet_each(
        pending.size(), room_within(2 * limit), [&](std::uint32_t row) { meet_fixed(row); });
    const std::size_t most = new_pairs.size() + room_for_dynamic;
    done = meet_each(done, most, [&](std::uint32_t row) {
        if (bodies.is_dynamic(row)) {
            meet_kind(row, BodyKind::kDynamic);
        }
    });
    for (std::size_t i = 0; i < done; ++i) {
        pending_mark[pending[i]] = 0;
    }
    pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(done));
    unpaired = static_cast<std::uint32_t>(pending.size());
    // The order of contacts must not depend on the structure that found them.
    std::sort(new_pairs.begin(), new_pairs.end());
    for (const auto& [a, b] : new_pairs) {
        const std::uint32_t contact = graph.create(bodies, a, b);
        classify(contact);
        if (graph.pair(contact).active_place == kNoIndex) {
            // Nobody will look at a pair at rest again: it must know now whether it touches.
            update_contact(contact, dt);
            note_sensing(contact);
            graph.pair(contact).touching = lowest_gap(graph, contact) <= kTouch;
        }
    }
}

}  // namespace zoned::physics
