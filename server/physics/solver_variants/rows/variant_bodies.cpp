#include "server/physics/solver_variants/rows/variant_bodies.h"

#include "server/physics/bodies/solver_bodies.h"
#include "server/physics/integrator/integrate.h"
#include "server/physics/shapes/ranges.h"

namespace zoned::physics {

void VariantBodies::begin(const Vec3& gravity, RowSystem& system) {
    gravity_ = gravity;
    entries_.assign(1, VariantBody());
    system.clear();
}

std::uint32_t VariantBodies::slot_of(Bodies& bodies, std::uint32_t row, RowSystem& system) {
    if (row == kNoIndex || bodies.awake[row] == 0) {
        return 0;
    }
    std::uint32_t& slot = bodies.solver_slot[row];
    if (slot != 0) {
        return slot;
    }
    slot = static_cast<std::uint32_t>(entries_.size());
    VariantBody entry;
    entry.row = row;
    entry.orientation = bodies.orientation[row];
    entries_.push_back(entry);
    RowBody body;
    body.velocity = bodies.velocity[row].cast<double>();
    body.spin = bodies.angular_velocity[row].cast<double>();
    body.inv_mass = static_cast<double>(bodies.inv_mass[row]);
    system.add_body(body);
    return slot;
}

void VariantBodies::gain(const Bodies& bodies, double h, RowSystem& system) {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
        VariantBody& entry = entries_[i];
        RowBody& body = system.bodies[i];
        const std::uint32_t row = entry.row;
        entry.velocity = body.velocity;
        entry.spin = body.spin;
        if (body.inv_mass > 0.0) {
            const Mat3d axes =
                bodies.inertia_axes(row, entry.orientation.toRotationMatrix()).cast<double>();
            body.inverse =
                axes * bodies.inv_inertia[row].cast<double>().asDiagonal() * axes.transpose();
            const Damping& damping = bodies.damping[row];
            body.velocity +=
                h * (gravity_.cast<double>() + body.inv_mass * bodies.force[row].cast<double>());
            body.velocity /= 1.0 + h * static_cast<double>(damping.linear);
            body.spin += h * (body.inverse * bodies.torque[row].cast<double>());
            body.spin /= 1.0 + h * static_cast<double>(damping.angular);
        }
        entry.free_velocity = body.velocity;
        entry.free_spin = body.spin;
    }
}

void VariantBodies::move(const Bodies& bodies, double h, bool mean, RowSystem& system) {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
        VariantBody& entry = entries_[i];
        RowBody& body = system.bodies[i];
        const bool untouched =
            mean && body.velocity == entry.free_velocity && body.spin == entry.free_spin;
        entry.shift += untouched ? Vec3d(0.5 * h * (entry.velocity + body.velocity))
                                 : Vec3d(h * body.velocity);
        entry.turn += h * body.spin;
        if (body.spin.isZero(0.0)) {
            continue;
        }
        if (body.inv_mass > 0.0 && bodies.round[entry.row] == 0) {
            Vec3 spin = body.spin.cast<float>();
            rotate_body(bodies, entry.row, static_cast<float>(h), entry.orientation, spin);
            body.spin = spin.cast<double>();
        } else {
            entry.orientation = turned(entry.orientation, Vec3((h * body.spin).cast<float>()));
        }
    }
}

void VariantBodies::displace(double h, const std::vector<RowBody>& push) {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
        entries_[i].shift += h * push[i].velocity;
        entries_[i].turn += h * push[i].spin;
        entries_[i].orientation =
            turned(entries_[i].orientation, Vec3((h * push[i].spin).cast<float>()));
    }
}

void VariantBodies::release(Bodies& bodies) const {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
        bodies.solver_slot[entries_[i].row] = 0;
    }
}

void VariantBodies::store(Bodies& bodies,
                          const RowSystem& system,
                          std::vector<std::uint32_t>& broken) const {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
        const VariantBody& entry = entries_[i];
        const std::uint32_t row = entry.row;
        bodies.solver_slot[row] = 0;
        if (system.bodies[i].inv_mass == 0.0) {
            continue;
        }
        const Vec3 position = (bodies.position[row].cast<double>() + entry.shift).cast<float>();
        const Vec3 velocity = system.bodies[i].velocity.cast<float>();
        const Vec3 spin = system.bodies[i].spin.cast<float>();
        if (!fit_position(position) || !fit_velocity(velocity, spin) ||
            !fit_orientation(entry.orientation)) {
            broken.push_back(row);
            bodies.velocity[row].setZero();
            bodies.angular_velocity[row].setZero();
            continue;
        }
        bodies.set_pose(row, position, entry.orientation);
        bodies.velocity[row] = velocity;
        bodies.angular_velocity[row] = spin;
    }
}

}  // namespace zoned::physics
