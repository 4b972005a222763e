// The part of the contact solver that runs once per step: constraints from contacts.
#include "server/physics/contact_solver.h"
#include "server/physics/inertia.h"
#include "server/physics/narrowphase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

/// Contacts are springs of this frequency at most. A column of boxes buckles when its contacts are
/// too soft for its height: 30 Hz carries some fifteen unit boxes, 60 Hz some twenty-five.
constexpr float kContactHertz = 60.0F;
/// More than a quarter of the substep rate cannot be resolved.
constexpr float kContactRateShare = 0.25F;
constexpr float kContactDamping = 10.0F;

Vec3 any_perpendicular(const Vec3& n) {
    // Crossing with the axis of the smallest component keeps the result long.
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    return n.cross(Vec3::Unit(axis)).normalized();
}

/// With which body the point of contact travels within a step, as b's share. A round body takes it
/// along wherever it rolls; between two round ones it lies on the line of centres; on the unmoving
/// world it goes with the body that moves. Any choice conserves momentum: the point is one and the
/// same for both bodies.
float share_of_b(const Shape& a, const Shape& b, bool a_moves, bool b_moves) {
    const bool a_round = a.kind == ShapeKind::kSphere || a.kind == ShapeKind::kCapsule;
    const bool b_round = b.kind == ShapeKind::kSphere || b.kind == ShapeKind::kCapsule;
    if (a_round && b_round) {
        return a.radius / (a.radius + b.radius);
    }
    if (a_round != b_round) {
        return b_round ? 1.0F : 0.0F;
    }
    return a_moves == b_moves ? 0.5F : (b_moves ? 1.0F : 0.0F);
}

float angular_mass(const Mat3& inv_inertia, const Vec3& moment) {
    return moment.dot(inv_inertia * moment);
}

}  // namespace

void ContactSolver::gather(Bodies& bodies) {
    moving_.clear();
    moving_.emplace_back();
    const auto take = [&](std::uint32_t row) {
        SolverBody body;
        body.velocity = bodies.velocity[row];
        body.spin = bodies.angular_velocity[row];
        body.inv_mass = bodies.inv_mass[row];
        body.orientation = bodies.orientation[row];
        body.inv_inertia = rotated_tensor(bodies.rotation[row], bodies.inv_inertia[row]);
        body.row = row;
        bodies.solver_slot[row] = static_cast<std::uint32_t>(moving_.size());
        moving_.push_back(body);
    };
    for (const std::uint32_t row : bodies.awake_list) {
        take(row);
    }
    for (const std::uint32_t row : bodies.mover_list) {
        take(row);
    }
}

void ContactSolver::prepare(const Bodies& bodies,
                            const ContactGraph& graph,
                            const std::vector<std::uint32_t>& list) {
    // Soft constraint coefficients (E. Catto, "Soft Constraints", GDC 2011): an implicit spring and
    // damper over a substep as a bias velocity and a scaled impulse.
    const float hertz = std::min(kContactHertz, kContactRateShare / h_);
    const float omega = 2.0F * std::numbers::pi_v<float> * hertz;
    const float a1 = 2.0F * kContactDamping + h_ * omega;
    const float a2 = h_ * omega * a1;
    const float a3 = 1.0F / (1.0F + a2);
    softness_ = {omega / a1, a2 * a3, a3};
    constraints_.clear();
    for (const std::uint32_t index : list) {
        const Contact& contact = graph[index];
        constraints_.emplace_back();
        Constraint& c = constraints_.back();
        c.contact = index;
        c.a = bodies.awake[contact.a] != 0 ? bodies.solver_slot[contact.a] : 0;
        c.b = bodies.awake[contact.b] != 0 ? bodies.solver_slot[contact.b] : 0;
        const SolverBody& a = moving_[c.a];
        const SolverBody& b = moving_[c.b];
        c.count = contact.count;
        c.normal = contact.normal;
        c.lead = contact.lead;
        const Material& ma = bodies.material[contact.a];
        const Material& mb = bodies.material[contact.b];
        c.friction = std::sqrt(ma.friction * mb.friction);
        c.restitution = std::max(ma.restitution, mb.restitution);
        c.watched = c.restitution > 0.0F || !contact.touching;
        c.impact = false;
        c.follow_b = share_of_b(
            bodies.shape[contact.a], bodies.shape[contact.b], a.inv_mass > 0.0F, b.inv_mass > 0.0F);
        for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
            const ContactPoint& from = contact.points[i];
            Point& p = c.points[i];
            p.moment_a = from.arm_a.cross(c.normal);
            p.moment_b = from.arm_b.cross(c.normal);
            p.separation = from.separation;
            p.mass = 1.0F / (a.inv_mass + b.inv_mass + angular_mass(a.inv_inertia, p.moment_a) +
                             angular_mass(b.inv_inertia, p.moment_b));
            p.impulse = from.impulse;
            p.total = 0.0F;
            p.impact = 0.0F;
        }
        prepare_friction(c, a, b, contact);
    }
}

/// Friction acts at the middle of the points that carry, with one cone for the whole patch and a
/// moment about the normal: three unknowns instead of two per point, and isotropic.
void ContactSolver::prepare_friction(Constraint& c,
                                     const SolverBody& a,
                                     const SolverBody& b,
                                     const Contact& contact) const {
    c.tangent1 = any_perpendicular(c.normal);
    c.tangent2 = c.normal.cross(c.tangent1);
    const auto count = static_cast<std::size_t>(c.count);
    float lowest = contact.points[0].separation;
    for (std::size_t i = 1; i < count; ++i) {
        lowest = std::min(lowest, contact.points[i].separation);
    }
    Vec3 arm_a = Vec3::Zero();
    Vec3 arm_b = Vec3::Zero();
    float carrying = 0.0F;
    for (std::size_t i = 0; i < count; ++i) {
        if (contact.points[i].separation <= lowest + kTouch) {
            arm_a += contact.points[i].arm_a;
            arm_b += contact.points[i].arm_b;
            carrying += 1.0F;
        }
    }
    arm_a /= carrying;
    arm_b /= carrying;
    for (std::size_t i = 0; i < count; ++i) {
        c.points[i].lever = (contact.points[i].arm_a - arm_a).norm();
    }
    c.moment1_a = arm_a.cross(c.tangent1);
    c.moment1_b = arm_b.cross(c.tangent1);
    c.moment2_a = arm_a.cross(c.tangent2);
    c.moment2_b = arm_b.cross(c.tangent2);
    const float linear = a.inv_mass + b.inv_mass;
    const float k11 = linear + angular_mass(a.inv_inertia, c.moment1_a) +
                      angular_mass(b.inv_inertia, c.moment1_b);
    const float k22 = linear + angular_mass(a.inv_inertia, c.moment2_a) +
                      angular_mass(b.inv_inertia, c.moment2_b);
    const float k12 =
        c.moment1_a.dot(a.inv_inertia * c.moment2_a) + c.moment1_b.dot(b.inv_inertia * c.moment2_b);
    const float determinant = k11 * k22 - k12 * k12;
    c.inv11 = k22 / determinant;
    c.inv22 = k11 / determinant;
    c.inv12 = -k12 / determinant;
    c.twist_mass =
        1.0F / (angular_mass(a.inv_inertia, c.normal) + angular_mass(b.inv_inertia, c.normal));
    c.impulse1 = contact.friction.dot(c.tangent1);
    c.impulse2 = contact.friction.dot(c.tangent2);
    c.twist = contact.twist;
}

}  // namespace zoned::physics
