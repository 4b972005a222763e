#include "server/physics/bodies/bodies.h"

#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/mass_properties.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics {

namespace {

/// A quaternion that is one but for rounding stays as it is: a body that comes from another scene
/// goes on to the bit. Normalised in double precision and rounded, its square is off by no more
/// than one unit of each of four components, and summing rounds thrice.
Quat unit_of(const Quat& q) {
    constexpr float kRounding = 4.0F * std::numeric_limits<float>::epsilon();
    return std::abs(q.squaredNorm() - 1.0F) <= kRounding ? q : Quat(q.normalized());
}

}  // namespace

std::uint32_t Bodies::row_of(BodyId id) const {
    const std::uint32_t number = id.value & 0xFFFFFU;
    if (number == 0 || number > rows()) {
        return kNoIndex;
    }
    const std::uint32_t row = number - 1;
    return alive[row] != 0 && generation[row] == (id.value >> 20) ? row : kNoIndex;
}

std::uint32_t Bodies::append_row() {
    const std::uint32_t row = rows();
    generation.push_back(0);
    alive.push_back(0);
    kind.push_back(BodyKind::kStatic);
    user.push_back(0);
    position.emplace_back(Vec3::Zero());
    orientation.emplace_back(Quat::Identity());
    velocity.emplace_back(Vec3::Zero());
    angular_velocity.emplace_back(Vec3::Zero());
    still_s.push_back(0.0F);
    settled_s.push_back(0.0F);
    settled_at.emplace_back(Vec3::Zero());
    settled_turn.emplace_back(Quat::Identity());
    substep_level.push_back(0);
    substep_patience.push_back(0);
    inv_mass_scale.push_back(1.0F);
    awake.push_back(0);
    listed.push_back(0);
    shape.emplace_back();
    material.emplace_back();
    filter.emplace_back();
    damping.emplace_back();
    force.emplace_back(Vec3::Zero());
    torque.emplace_back(Vec3::Zero());
    sensor.push_back(0);
    events.push_back(0);
    inv_mass.push_back(0.0F);
    inertia.emplace_back(Vec3::Zero());
    inv_inertia.emplace_back(Vec3::Zero());
    round.push_back(0);
    radius.push_back(0.0F);
    inner.push_back(0.0F);
    rotation.emplace_back(Mat3::Identity());
    bounds.emplace_back();
    fat.emplace_back();
    first_contact.push_back(kNoIndex);
    first_joint.push_back(kNoIndex);
    solver_slot.push_back(0);
    return row;
}

std::uint32_t Bodies::create(const BodyDef& def) {
    std::uint32_t row = kNoIndex;
    if (!free_rows.empty()) {
        row = free_rows.back();
        free_rows.pop_back();
    } else if (rows() < kMaxBodies) {
        row = append_row();
    } else {
        return kNoIndex;
    }
    const bool dynamic = def.kind == BodyKind::kDynamic || def.kind == BodyKind::kParticle;
    alive[row] = 1;
    kind[row] = def.kind;
    user[row] = def.user;
    velocity[row] = def.kind == BodyKind::kStatic ? Vec3(Vec3::Zero()) : def.velocity;
    angular_velocity[row] =
        def.kind == BodyKind::kStatic ? Vec3(Vec3::Zero()) : def.angular_velocity;
    stir(row);
    substep_level[row] = 0;
    substep_patience[row] = 0;
    inv_mass_scale[row] = 1.0F;
    awake[row] = 0;
    set_shape(row, def.shape);
    material[row] = def.material;
    filter[row] = def.filter;
    damping[row] = def.damping;
    force[row].setZero();
    torque[row].setZero();
    sensor[row] = def.sensor ? 1 : 0;
    inv_mass[row] = dynamic ? 1.0F / def.mass : 0.0F;
    events[row] = def.events;
    reporting += def.events != 0 ? 1 : 0;
    set_inertia(row, def);
    first_contact[row] = kNoIndex;
    first_joint[row] = kNoIndex;
    set_pose(row, def.position, def.orientation);
    fat[row] = bounds[row];
    ++count;
    return row;
}

/// A tensor is kept as its principal moments and the turn to their axes: bodies without such a turn
/// are computed as if there were none.
void Bodies::set_inertia(std::uint32_t row, const BodyDef& def) {
    if (row < tilt.size()) {
        tilt[row].setIdentity();
    }
    inertia[row].setZero();
    if (inv_mass[row] == 0.0F) {
        // Nothing turns it.
    } else if (!def.inertia.isZero(0.0F)) {
        const PrincipalAxes axes = *principal_axes(def.inertia.cast<double>());
        inertia[row] = axes.moments.cast<float>();
        const Quat turn(Eigen::Quaterniond(axes.rotation).cast<float>());
        if (!axes.rotation.isIdentity(0.0)) {
            tilt.resize(std::max<std::size_t>(tilt.size(), row + 1U), Quat::Identity());
            tilt[row] = turn.normalized();
        }
    } else {
        inertia[row] =
            def.moments.isZero(0.0F) ? principal_inertia(def.shape, def.mass) : def.moments;
    }
    const Vec3& moments = inertia[row];
    inv_inertia[row] = inv_mass[row] > 0.0F ? Vec3(moments.cwiseInverse()) : Vec3(Vec3::Zero());
    round[row] = moments.x() == moments.y() && moments.y() == moments.z() ? 1 : 0;
}

void Bodies::set_shape(std::uint32_t row, const Shape& to) {
    shape[row] = to;
    radius[row] = bounding_radius(to);
    inner[row] = inner_radius(to);
}

void Bodies::destroy(std::uint32_t row) {
    mark_asleep(row);
    reporting -= events[row] != 0 ? 1 : 0;
    alive[row] = 0;
    shape[row] = Shape();  // lets go of its geometry
    generation[row] = static_cast<std::uint16_t>((generation[row] + 1U) & 0xFFFU);
    free_rows.push_back(row);
    --count;
}

void Bodies::add_force(std::uint32_t row, const Vec3& f, const Vec3& t) {
    if (force[row].isZero(0.0F) && torque[row].isZero(0.0F)) {
        forced.push_back(row);
    }
    force[row] += f;
    torque[row] += t;
}

void Bodies::clear_forces() {
    for (const std::uint32_t row : forced) {
        force[row].setZero();
        torque[row].setZero();
    }
    forced.clear();
}

void Bodies::set_pose(std::uint32_t row, const Vec3& x, const Quat& q) {
    position[row] = x;
    orientation[row] = unit_of(q);
    rotation[row] = orientation[row].toRotationMatrix();
    bounds[row] = shape_bounds(shape[row], x, rotation[row]);
}

void Bodies::mark_awake(std::uint32_t row) {
    if (awake[row] != 0 || kind[row] == BodyKind::kStatic) {
        return;
    }
    awake[row] = 1;
    awake_dynamic += is_dynamic(row) ? 1 : 0;
    awake_particles += is_particle(row) ? 1 : 0;
    if (listed[row] == 0) {
        listed[row] = 1;
        list_of(kind[row]).push_back(row);
    }
}

void Bodies::mark_asleep(std::uint32_t row) {
    if (awake[row] == 0) {
        return;
    }
    awake[row] = 0;
    awake_dynamic -= is_dynamic(row) ? 1 : 0;
    awake_particles -= is_particle(row) ? 1 : 0;
}

std::vector<std::uint32_t>& Bodies::list_of(BodyKind k) {
    return k == BodyKind::kDynamic    ? awake_list
           : k == BodyKind::kParticle ? particle_list
                                      : mover_list;
}

void Bodies::compact_lists() {
    // A row may have been freed and taken again by a body of another kind since it was listed, so
    // every listed row is looked at anew and put where it belongs now.
    const auto keep = [this](std::vector<std::uint32_t>& list, BodyKind wanted) {
        std::size_t kept = 0;
        for (const std::uint32_t row : list) {
            if (awake[row] == 0) {
                listed[row] = 0;
            } else if (kind[row] == wanted) {
                list[kept++] = row;
            } else {
                list_of(kind[row]).push_back(row);
            }
        }
        list.resize(kept);
    };
    keep(awake_list, BodyKind::kDynamic);
    keep(mover_list, BodyKind::kKinematic);
    keep(particle_list, BodyKind::kParticle);
    for (auto* list : {&awake_list, &mover_list, &particle_list}) {
        if (!std::is_sorted(list->begin(), list->end())) {
            std::sort(list->begin(), list->end());
        }
    }
}

}  // namespace zoned::physics
