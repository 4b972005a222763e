// The part of the contact solver that runs once per step: batches from contacts.
#include "server/physics/contact_solver.h"
#include "server/physics/lane_body.h"
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

/// Where friction acts: the middle of the points that carry.
Vec3 grip_of(const Contact& contact) {
    const auto count = static_cast<std::size_t>(contact.count);
    float lowest = contact.points[0].separation;
    for (std::size_t i = 1; i < count; ++i) {
        lowest = std::min(lowest, contact.points[i].separation);
    }
    Vec3 arm = Vec3::Zero();
    float carrying = 0.0F;
    for (std::size_t i = 0; i < count; ++i) {
        if (contact.points[i].separation <= lowest + kTouch) {
            arm += contact.points[i].arm_a;
            carrying += 1.0F;
        }
    }
    return arm / carrying;
}

Lanes angular_mass(const LanesTensor& inverse, const Lanes3& moment) {
    return dot(moment, inverse * moment);
}

}  // namespace

/// Soft constraint coefficients (E. Catto, "Soft Constraints", GDC 2011): an implicit spring and
/// damper over a substep as a bias velocity and a scaled impulse.
ContactSolver::Softness ContactSolver::contact_softness(float h) {
    const float hertz = std::min(kContactHertz, kContactRateShare / h);
    const float omega = 2.0F * std::numbers::pi_v<float> * hertz;
    const float a1 = 2.0F * kContactDamping + h * omega;
    const float a2 = h * omega * a1;
    const float a3 = 1.0F / (1.0F + a2);
    return {omega / a1, a2 * a3, a3};
}

void ContactSolver::prepare(Bodies& bodies,
                            const ContactGraph& graph,
                            std::span<const std::uint32_t> list) {
    softness_ = contact_softness(h_);
    moving_.begin(parameters_.gravity, parameters_.dt, h_);
    for (const std::uint32_t index : list) {
        for (const std::uint32_t row : {graph[index].a, graph[index].b}) {
            if (bodies.awake[row] != 0) {
                moving_.slot_of(bodies, row);
            }
        }
    }
    coloring_.build(bodies, graph, list, moving_.size());
    batches_.resize(coloring_.groups().size(), ContactBatch::none());
    points_.clear();
    watches_.clear();
    for (std::size_t g = 0; g < batches_.size(); ++g) {
        const ContactColoring::Group group = coloring_.groups()[g];
        const auto contacts =
            std::span(coloring_.order()).subspan(group.begin, group.end - group.begin);
        fill_batch(static_cast<std::uint32_t>(g), contacts, bodies, graph);
    }
}

void ContactSolver::fill_batch(std::uint32_t index,
                               std::span<const std::uint32_t> contacts,
                               const Bodies& bodies,
                               const ContactGraph& graph) {
    ContactBatch& batch = batches_[index];
    batch = ContactBatch::none();
    batch.points = static_cast<std::uint32_t>(points_.size());
    for (const std::uint32_t contact : contacts) {
        batch.count = std::max(batch.count, static_cast<std::uint32_t>(graph[contact].count));
    }
    points_.resize(points_.size() + batch.count, PointLanes::none());
    std::size_t lane = 0;
    for (const std::uint32_t contact : contacts) {
        batch.contact[lane] = contact;
        fill_lane(batch, lane, bodies, graph[contact]);
        const bool may_bounce = bodies.restitution_of(graph[contact].a, graph[contact].b) > 0.0F;
        if (may_bounce || !graph[contact].touching) {
            watches_.emplace_back();
            watches_.back().batch = index;
            watches_.back().lane = static_cast<std::uint32_t>(lane);
            watches_.back().restitution = bodies.restitution_of(graph[contact].a, graph[contact].b);
        }
        ++lane;
    }
    fill_masses(batch, lane, graph);
}

void ContactSolver::fill_lane(ContactBatch& batch,
                              std::size_t lane,
                              const Bodies& bodies,
                              const Contact& contact) {
    batch.a[lane] = bodies.awake[contact.a] != 0 ? bodies.solver_slot[contact.a] : 0;
    batch.b[lane] = bodies.awake[contact.b] != 0 ? bodies.solver_slot[contact.b] : 0;
    batch.normal.set(lane, contact.normal);
    const Vec3 tangent1 = any_perpendicular(contact.normal);
    const Vec3 tangent2 = contact.normal.cross(tangent1);
    batch.tangent.set(lane, tangent1);
    batch.between.set(lane, contact.points[0].arm_a - contact.points[0].arm_b);
    batch.lead.set(lane, contact.lead);
    batch.follow_b[lane] = share_of_b(bodies.shape[contact.a],
                                      bodies.shape[contact.b],
                                      moving_.moved_by_impulses(batch.a[lane]),
                                      moving_.moved_by_impulses(batch.b[lane]));
    batch.friction[lane] = bodies.friction_of(contact.a, contact.b);
    batch.impulse1[lane] = contact.friction.dot(tangent1);
    batch.impulse2[lane] = contact.friction.dot(tangent2);
    batch.twist[lane] = contact.twist;
    const Vec3 grip = grip_of(contact);
    batch.grip.set(lane, grip);
    for (std::size_t i = 0; i < static_cast<std::size_t>(contact.count); ++i) {
        const ContactPoint& from = contact.points[i];
        PointLanes& p = points_[batch.points + i];
        p.arm.set(lane, from.arm_a);
        p.separation[lane] = from.separation;
        p.impulse[lane] = from.impulse;
        p.lever[lane] = (from.arm_a - grip).norm();
    }
}

/// Friction acts at the middle of the points that carry, with one cone for the whole patch and a
/// moment about the normal: three unknowns instead of two per point, and isotropic.
void ContactSolver::fill_masses(ContactBatch& batch, std::size_t used, const ContactGraph& graph) {
    const LaneBody a(moving_, batch.a);
    const LaneBody b(moving_, batch.b);
    const Lanes linear = a.inv_mass + b.inv_mass;
    const auto mass = [&](const Lanes3& arm, const Lanes3& along) {
        return Lanes(linear + angular_mass(a.inverse, cross(arm, along)) +
                     angular_mass(b.inverse, cross(arm - batch.between, along)));
    };
    for (std::size_t k = 0; k < batch.count; ++k) {
        PointLanes& p = points_[batch.points + k];
        p.mass = lanes(1.0F) / mass(p.arm, batch.normal);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            if (lane >= used || k >= static_cast<std::size_t>(graph[batch.contact[lane]].count)) {
                p.mass[lane] = 0.0F;
            }
        }
    }
    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 grip_b = batch.grip - batch.between;
    const Lanes k11 = mass(batch.grip, batch.tangent);
    const Lanes k22 = mass(batch.grip, tangent2);
    const Lanes k12 =
        dot(cross(batch.grip, batch.tangent), a.inverse * cross(batch.grip, tangent2)) +
        dot(cross(grip_b, batch.tangent), b.inverse * cross(grip_b, tangent2));
    const Lanes inv_determinant = lanes(1.0F) / (k11 * k22 - k12 * k12);
    batch.inv11 = k22 * inv_determinant;
    batch.inv22 = k11 * inv_determinant;
    batch.inv12 = -k12 * inv_determinant;
    batch.twist_mass = lanes(1.0F) / (angular_mass(a.inverse, batch.normal) +
                                      angular_mass(b.inverse, batch.normal));
    for (std::size_t lane = used; lane < kLanes; ++lane) {
        for (Lanes* value : {&batch.inv11, &batch.inv12, &batch.inv22, &batch.twist_mass}) {
            (*value)[lane] = 0.0F;
        }
    }
}

}  // namespace zoned::physics
