// How a scene is saved and loaded: its state as it lies, since the order of bodies, boxes and
// contacts decides later steps.
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/shape_archive.h"
#include "server/physics/solver_variants/variant_stepper.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>

namespace zoned::physics {

template <class Archive>
void Scene::Impl::serialize(Archive& archive) {
    archive.section("bodies", [&] { archive(bodies, kind_counts, room); });
    archive.section("contacts", [&] { archive(graph); });
    archive.section("joints", [&] { archive(joints); });
    archive.section("broadphase", [&] {
        archive(fat_balls, boxes, resting, planes, pending, pending_mark, unpaired);
    });
    // A zone whose physics rests asks for the events of the last step again.
    archive.section("events", [&] {
        archive(events, left_contacts, breaks, sensor_events, left_sensors, moved, stopped);
        archive(substeps, substep_limited, far_bodies, held_back, quarantined, in_contact);
    });
}

bool Scene::Impl::is_sound() const {
    const std::size_t rows = bodies.rows();
    const auto fits = [rows](const auto&... column) {
        return ((column.size() == rows) && ...);
    };
    const Bodies& b = bodies;
    bool sound =
        fits(b.generation, b.kind, b.user, b.position, b.orientation, b.velocity) &&
        fits(b.angular_velocity, b.force, b.torque, b.still_s, b.settled_s) &&
        fits(b.settled_at, b.settled_turn, b.substep_level) &&
        fits(b.substep_patience, b.inv_mass_scale, b.awake, b.listed, b.shape, b.material) &&
        fits(b.filter, b.damping, b.sensor, b.events, b.inv_mass, b.inertia, b.inv_inertia) &&
        fits(b.round, b.radius, b.inner, b.rotation, b.bounds, b.fat, b.first_contact) &&
        fits(b.first_joint, b.solver_slot, fat_balls, pending_mark) && b.tilt.size() <= rows &&
        in_contact.size() <= rows;
    for (const auto* list : {&b.free_rows,
                             &b.forced,
                             &b.awake_list,
                             &b.mover_list,
                             &b.particle_list,
                             &planes,
                             &pending,
                             &stopped}) {
        sound = sound && std::all_of(list->begin(), list->end(), [rows](std::uint32_t row) {
                    return row < rows;
                });
    }
    for (std::uint32_t row = 0; sound && row < rows; ++row) {
        sound = b.kind[row] <= BodyKind::kParticle;
        sound = sound &&
                (b.first_contact[row] == kNoIndex || (b.first_contact[row] >> 1) < graph.records());
        sound =
            sound && (b.first_joint[row] == kNoIndex || (b.first_joint[row] >> 1) < joints.rows());
    }
    for (std::uint32_t contact = 0; sound && contact < graph.records(); ++contact) {
        const Pair& pair = graph.pair(contact);
        sound = (pair.a == kNoIndex || pair.a < rows) && (pair.b == kNoIndex || pair.b < rows);
    }
    for (const spatial::BoxIndex& index : boxes) {
        sound = sound && index.is_sound(rows);
    }
    // Room grows by doubling as bodies come.
    for (const std::size_t places : room) {
        sound = sound && places <= std::max<std::size_t>(16, 2 * rows);
    }
    return sound && resting.is_sound(rows) && joints.is_sound(bodies);
}

void Scene::save(core::FieldWriter& archive) const {
    impl_->serialize(archive);
}

void Scene::load(core::FieldReader& archive) {
    impl_->serialize(archive);
    if (archive.good() && !impl_->is_sound()) {
        archive.fail("numbers name bodies, contacts or joints that there are not");
    }
    if (archive.good()) {
        impl_->reserve_all_room();
    }
}

}  // namespace zoned::physics
