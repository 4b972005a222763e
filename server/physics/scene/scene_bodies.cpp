// How bodies enter, leave, wake and are stopped.
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/ranges.h"
#include "server/physics/solver_variants/variant_stepper.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// In a pile each body has some twelve neighbours within the margins and shares each with another.
constexpr std::size_t kContactsPerBody = 8;

spatial::BoxIndex make_index(const PhysicsSettings& s) {
    const auto kind =
        s.broadphase == BroadphaseKind::kAutomatic ? spatial::choose_kind(0) : s.broadphase;
    return {kind, {s.cell_m, s.cell_depth, s.boxes_per_cell}};
}

}  // namespace

Scene::Impl::Impl(const PhysicsSettings& s)
    : settings(s),
      boxes{make_index(s), make_index(s), make_index(s)},
      resting(s.cell_m) {
    ZONED_ASSERT(s.substeps >= 0 && s.substeps <= 64, "substeps out of range");
    ZONED_ASSERT(s.velocity_iterations >= 1 && s.velocity_iterations <= 64,
                 "velocity_iterations out of range");
    ZONED_ASSERT(s.relax_iterations >= 1 && s.relax_iterations <= 64,
                 "relax_iterations out of range");
    ZONED_ASSERT(s.cell_m > 0.0F && s.gravity.allFinite(), "cell_m or gravity out of range");
    if (s.method != SolverVariant::kSoftStep) {
        ZONED_ASSERT(s.methods.iterations >= 1 && s.methods.iterations <= 1000,
                     "iterations out of range");
        stepper = std::make_unique<VariantStepper>();
    } else if (s.substeps == 0) {
        exact = std::make_unique<VariantStepper>();
        exact_settings = s;
        exact_settings.method = SolverVariant::kDirect;
        exact_settings.methods = VariantSettings();
        exact->reserve(2 * SubstepPolicy::kExactContacts, SubstepPolicy::kExactContacts);
    }
}

void Scene::Impl::make_room(BodyKind kind) {
    const auto k = static_cast<std::size_t>(kind);
    if (kind_counts[k] < room[k]) {
        return;
    }
    room[k] = std::max<std::size_t>(16, 2 * room[k]);
    if (kind != BodyKind::kParticle) {
        const auto cheapest = settings.broadphase == BroadphaseKind::kAutomatic
                                  ? spatial::choose_kind(static_cast<std::uint32_t>(room[k]))
                                  : settings.broadphase;
        if (cheapest != boxes[k].kind()) {
            boxes[k].change_to(cheapest, room[k]);
        }
    }
    reserve_room(kind);
}

void Scene::Impl::reserve_all_room() {
    for (std::size_t k = 0; k < room.size(); ++k) {
        if (room[k] > 0) {
            reserve_room(static_cast<BodyKind>(k));
        }
    }
}

void Scene::Impl::reserve_room(BodyKind kind) {
    const auto k = static_cast<std::size_t>(kind);
    const std::size_t movers = room[1] + room[2];
    moved.reserve(movers + room[3]);
    broken.reserve(movers + room[3]);
    passed.reserve(movers);
    guards.reserve(movers);
    stopped.reserve(movers + room[3]);
    if (kind == BodyKind::kParticle) {
        resting.reserve(room[k]);
        resting.reserve_rows(bodies.rows() + room[k]);
        bodies.particle_list.reserve(room[k]);
        disturbed.reserve(room[k]);
        return;
    }
    boxes[k].reserve(room[k]);
    if (kind == BodyKind::kStatic) {
        return;
    }
    const std::size_t contacts = kContactsPerBody * movers;
    graph.reserve(contacts);
    breaks.reserve(movers);
    solver.reserve(movers, contacts);
    substep_policy.reserve(movers, contacts);
    torn.reserve(movers, contacts);
    if (stepper) {
        stepper->reserve(movers, contacts);
    }
    islands.reserve(movers);
    waker.reserve(movers);
    bodies.awake_list.reserve(movers);
    bodies.mover_list.reserve(movers);
    events.reserve(contacts);
    left_contacts.reserve(contacts);
    new_pairs.reserve(2 * contacts);
    solve_list.reserve(contacts);
    touch_changes.reserve(contacts);
    pending.reserve(4 * movers);
    refitted.reserve(movers);
}

void Scene::Impl::enter_broadphase(std::uint32_t row) {
    ++kind_counts[static_cast<std::size_t>(bodies.kind[row])];
    fat_balls.resize(bodies.rows());
    pending_mark.resize(bodies.rows(), 0);
    if (bodies.is_particle(row)) {
        return;  // finds others by itself
    }
    if (bodies.is_plane(row)) {
        planes.push_back(row);
    } else {
        fit_bounds_at_rest(row);
        boxes_of(row).insert(row, bodies.fat[row]);
    }
    mark_pending(row);
}

void Scene::Impl::leave_broadphase(std::uint32_t row) {
    --kind_counts[static_cast<std::size_t>(bodies.kind[row])];
    if (bodies.is_particle(row)) {
        if (bodies.awake[row] == 0) {
            resting.remove(row);
        }
        return;
    }
    if (bodies.is_plane(row)) {
        planes.erase(std::find(planes.begin(), planes.end(), row));
    } else {
        boxes_of(row).remove(row);
    }
    pending_mark[row] = 0;
}

void Scene::Impl::drop_pair(std::uint32_t contact, std::uint32_t other) {
    const bool touched = graph.pair(contact).touching;
    end_sensing(contact, left_sensors);
    end_touch(contact, left_contacts);
    graph.destroy(bodies, contact);
    if (touched) {
        waker.wake(bodies, graph, joints, other);
    }
}

void Scene::Impl::drop_contacts(std::uint32_t row) {
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        drop_pair(contact, other);
    });
}

void Scene::Impl::teleport(std::uint32_t row, const Vec3& x, const Quat& q) {
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        if (graph.pair(contact).touching) {
            waker.wake(bodies, graph, joints, other);
        }
    });
    wake_joined(row);
    if (bodies.is_particle(row)) {
        wake(row);
        bodies.set_pose(row, x, q);
        return;
    }
    disturb_particles(row);
    bodies.set_pose(row, x, q);
    disturb_particles(row);
    if (!bodies.is_plane(row)) {
        fit_bounds_at_rest(row);
        boxes_of(row).update({&row, 1}, bodies.fat);
    }
    mark_pending(row);
    graph.for_each_of(bodies, row, [&](std::uint32_t contact, std::uint32_t other) {
        if (!near(row, other)) {
            end_sensing(contact, left_sensors);
            end_touch(contact, left_contacts);
            graph.destroy(bodies, contact);
        }
    });
}

void Scene::Impl::set_velocity(std::uint32_t row, const Vec3& velocity, const Vec3& spin) {
    if (bodies.kind[row] == BodyKind::kStatic) {
        return;
    }
    if (!fit_velocity(velocity, spin)) {
        quarantine(row);
        return;
    }
    if (bodies.velocity[row] == velocity && bodies.angular_velocity[row] == spin) {
        return;
    }
    bodies.velocity[row] = velocity;
    bodies.angular_velocity[row] = spin;
    if (bodies.inv_mass[row] > 0.0F) {
        wake(row);
    } else if (velocity.isZero(0.0F) && spin.isZero(0.0F)) {
        bodies.mark_asleep(row);
    } else {
        bodies.mark_awake(row);
    }
}

void Scene::Impl::push(std::uint32_t row, const Vec3& impulse, const Vec3& moment) {
    if (bodies.inv_mass[row] > 0.0F) {
        const Mat3 r = bodies.inertia_axes(row, bodies.rotation[row]);
        const Vec3 spin = r * bodies.inv_inertia[row].cwiseProduct(r.transpose() * moment);
        set_velocity(row,
                     bodies.velocity[row] + bodies.inv_mass[row] * impulse,
                     bodies.is_particle(row) ? bodies.angular_velocity[row]
                                             : Vec3(bodies.angular_velocity[row] + spin));
    }
}

void Scene::Impl::add_force(std::uint32_t row, const Vec3& force, const Vec3& torque) {
    if (bodies.inv_mass[row] == 0.0F) {
        return;
    }
    if (!fit_force(force, torque)) {
        quarantine(row);
        return;
    }
    bodies.add_force(row, force, torque);
    wake(row);
}

void Scene::Impl::quarantine(std::uint32_t row) {
    stop(row);
    ++quarantined;
}

void Scene::Impl::stop(std::uint32_t row) {
    if (bodies.is_particle(row)) {
        rest_particle(row);
    } else {
        put_to_sleep(bodies, graph, row);
        stopped.push_back(row);
    }
}

void Scene::Impl::wake(std::uint32_t row) {
    if (bodies.is_particle(row)) {
        bodies.still_s[row] = 0.0F;
        if (bodies.awake[row] == 0) {
            resting.remove(row);
            bodies.mark_awake(row);
        }
        return;
    }
    waker.wake(bodies, graph, joints, row);
}

}  // namespace zoned::physics
