// The part of the contact solver that runs once per step: batches from contacts.
#include "server/physics/contacts/contact_persistence.h"
#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/simd/lane_body.h"
#include "server/physics/solver/contact_solver.h"
#include "shared/math/perpendicular.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::physics {

namespace {

constexpr float kContactDamping = 10.0F;
/// Masses hold for as long as the arms have changed by less than this share of the shorter one.
constexpr float kSameArm = 0.1F;

/// Batches that one thread fills at a time.
constexpr std::size_t kFillGrain = 8;

/// Where friction acts: the middle of the points that carry.
Vec3 grip_of(const Contact& contact, std::size_t count) {
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
    const float omega = 2.0F * std::numbers::pi_v<float> * kContactRateShare / h;
    const float a1 = 2.0F * kContactDamping + h * omega;
    const float a2 = h * omega * a1;
    const float a3 = 1.0F / (1.0F + a2);
    return {omega / a1, a2 * a3, a3};
}

void ContactSolver::prepare(Bodies& bodies,
                            const ContactGraph& graph,
                            std::span<const std::uint32_t> list,
                            const JointTable& table,
                            std::span<const std::uint32_t> joints) {
    softness_ = contact_softness(h_);
    moving_.begin(parameters_.gravity, parameters_.dt, h_);
    for (const std::uint32_t index : list) {
        for (const std::uint32_t row : {graph.pair(index).a, graph.pair(index).b}) {
            if (bodies.awake[row] != 0) {
                moving_.slot_of(bodies, row);
            }
        }
    }
    joints_.prepare(bodies, table, joints, moving_, h_, 0.5F * h_);
    coloring_.build(bodies, graph, list, moving_.size());
    lay_out(graph);
    team_->run(batches_.size(), kFillGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            fill_batch(i, bodies, graph);
        }
    });
    list_watches(graph);
    list_rolls(graph);
}

/// Gives each batch its contacts, and its place in the tables.
void ContactSolver::lay_out(const ContactGraph& graph) {
    batches_.resize(coloring_.groups().size());
    std::uint32_t points = 0;
    std::uint32_t couplings = 0;
    for (std::size_t g = 0; g < batches_.size(); ++g) {
        const ContactColoring::ColorGroup group = coloring_.groups()[g];
        ContactBatch& batch = batches_[g];
        batch.contact.fill(kNoIndex);
        batch.count = 0;
        for (std::uint32_t i = group.begin; i < group.end; ++i) {
            const std::uint32_t contact = coloring_.order()[i];
            batch.contact[i - group.begin] = contact;
            batch.count =
                std::max(batch.count, static_cast<std::uint32_t>(graph.pair(contact).count));
        }
        batch.points = points;
        batch.couplings = couplings;
        points += batch.count;
        couplings += static_cast<std::uint32_t>(coupling_of(batch.count, 0));
    }
    points_.resize(points);
    couplings_.resize(couplings);
}

void ContactSolver::fill_batch(std::size_t index, const Bodies& bodies, const ContactGraph& graph) {
    ContactBatch& batch = batches_[index];
    ContactBatch fresh;
    fresh.contact = batch.contact;
    fresh.count = batch.count;
    fresh.points = batch.points;
    fresh.couplings = batch.couplings;
    batch = fresh;
    for (std::size_t k = 0; k < batch.count; ++k) {
        points_[batch.points + k] = PointLanes();
    }
    std::size_t lane = 0;
    for (; lane < kLanes && batch.contact[lane] != kNoIndex; ++lane) {
        const Pair& pair = graph.pair(batch.contact[lane]);
        const Contact& contact = graph[batch.contact[lane]];
        fill_lane(batch, lane, bodies, pair, contact);
        const float fall = std::abs(contact.normal.dot(parameters_.gravity));
        const bool watched = contact.grip.restitution > 0.0F || !pair.touching ||
                             contact.approach_speed > bounce_speed(fall);
        batch.watched |= watched ? 1U << lane : 0U;
        batch.rolls |= contact.grip.rolls_stiffly() ? 1U : 0U;
    }
    fill_masses(batch, lane, graph);
}

void ContactSolver::list_watches(const ContactGraph& graph) {
    watches_.clear();
    first_watch_.clear();
    for (std::size_t i = 0; i < batches_.size(); ++i) {
        for (std::uint32_t lane = 0; batches_[i].watched >> lane != 0; ++lane) {
            if ((batches_[i].watched >> lane & 1U) != 0) {
                watch(i, lane, graph[batches_[i].contact[lane]].grip.restitution);
            }
        }
    }
    watched_ = watches_.size();
}

void ContactSolver::watch(std::size_t batch, std::uint32_t lane, float restitution) {
    const ContactBatch& from = batches_[batch];
    SolverWatch& w = watches_.emplace_back();
    w.batch = static_cast<std::uint32_t>(batch);
    w.lane = lane;
    w.a = from.a[lane];
    w.b = from.b[lane];
    w.restitution = restitution;
    w.follow_b = from.follow_b[lane];
    w.normal = from.normal.get(lane);
    w.between = from.between.get(lane);
    w.lead = from.lead.get(lane);
    for (std::size_t k = 0; k < from.count; ++k) {
        const PointLanes& p = points_[from.points + k];
        if (p.mass[lane] != 0.0F) {
            w.points[w.count++] = {p.arm.get(lane), p.separation[lane]};
        }
    }
}

/// Gives each batch with a contact that resists turning its place in the table.
void ContactSolver::list_rolls(const ContactGraph& graph) {
    rolls_.clear();
    for (ContactBatch& batch : batches_) {
        if (batch.rolls == 0) {
            continue;
        }
        RollLanes r;
        const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
        for (std::size_t lane = 0; lane < kLanes && batch.contact[lane] != kNoIndex; ++lane) {
            const Contact& contact = graph[batch.contact[lane]];
            r.rolling[lane] = contact.grip.rolling_m;
            r.spinning[lane] = contact.grip.spinning_m;
            const float scale = contact.substep_s > 0.0F ? h_ / contact.substep_s : 0.0F;
            r.roll1[lane] = scale * contact.rolling.dot(batch.tangent.get(lane));
            r.roll2[lane] = scale * contact.rolling.dot(tangent2.get(lane));
            r.spin[lane] = scale * contact.rolling.dot(batch.normal.get(lane));
        }
        rolls_.push_back(r);
        batch.rolls = static_cast<std::uint32_t>(rolls_.size());
    }
}

void ContactSolver::fill_lane(ContactBatch& batch,
                              std::size_t lane,
                              const Bodies& bodies,
                              const Pair& pair,
                              const Contact& contact) {
    batch.a[lane] = bodies.awake[pair.a] != 0 ? bodies.solver_slot[pair.a] : 0;
    batch.b[lane] = bodies.awake[pair.b] != 0 ? bodies.solver_slot[pair.b] : 0;
    batch.normal.set(lane, contact.normal);
    const Vec3 tangent1 = any_perpendicular(contact.normal);
    const Vec3 tangent2 = contact.normal.cross(tangent1);
    batch.tangent.set(lane, tangent1);
    batch.between.set(lane, contact.points[0].arm_a - contact.points[0].arm_b);
    batch.lead.set(lane, contact.lead);
    batch.follow_b[lane] = share_of_b(bodies.shape[pair.a],
                                      bodies.shape[pair.b],
                                      moving_.moved_by_impulses(batch.a[lane]),
                                      moving_.moved_by_impulses(batch.b[lane]));
    batch.friction[lane] = contact.grip.friction;
    // Impulses are forces over a substep; the last step's may have had another length.
    const float scale = contact.substep_s > 0.0F ? h_ / contact.substep_s : 0.0F;
    batch.impulse1[lane] = scale * contact.friction.dot(tangent1);
    batch.impulse2[lane] = scale * contact.friction.dot(tangent2);
    batch.twist[lane] = scale * contact.twist;
    batch.carried[lane] = scale * contact.carried;
    const Vec3 grip = grip_of(contact, pair.points());
    batch.grip.set(lane, grip);
    for (std::size_t i = 0; i < pair.points(); ++i) {
        const ContactPoint& from = contact.points[i];
        PointLanes& p = points_[batch.points + i];
        p.arm.set(lane, from.arm_a);
        p.separation[lane] = from.separation;
        p.impulse[lane] = scale * from.impulse;
        p.lever[lane] = (from.arm_a - grip).norm();
    }
}

/// Friction acts at the middle of the points that carry, with one cone for the whole patch and a
/// moment about the normal: three unknowns instead of two per point, and isotropic.
void ContactSolver::fill_masses(ContactBatch& batch, std::size_t used, const ContactGraph& graph) {
    for (std::size_t lane = 0; lane < used; ++lane) {
        // Marks the existing points; the rest keeps mass 0.
        batch.inv11[lane] = 1.0F;
        for (std::size_t k = 0; k < graph.pair(batch.contact[lane]).points(); ++k) {
            points_[batch.points + k].mass[lane] = 1.0F;
        }
        float shortest2 = INFINITY;
        for (const std::uint32_t slot : {batch.a[lane], batch.b[lane]}) {
            if (moving_.moved_by_impulses(slot)) {
                const Vec3 arm =
                    batch.grip.get(lane) -
                    (slot == batch.b[lane] ? batch.between.get(lane) : Vec3(Vec3::Zero()));
                shortest2 = std::min(shortest2, arm.squaredNorm());
            }
            batch.turns |= moving_.turns_fast(slot);
        }
        batch.same2[lane] = kSameArm * kSameArm * shortest2;
    }
    const LaneBody a(moving_, batch.a);
    const LaneBody b(moving_, batch.b);
    const Lanes zero = lanes(0.0F);
    fit_masses(batch, a, b, {zero, zero, zero});
}

/// The masses of a contact whose bodies stand `offset` apart from where they stood at the time of
/// contact. An impulse then acts farther out than it did, and moves the point more: with the mass
/// of the old arms it would overshoot, by more with each visit, and throw the bodies apart.
void ContactSolver::fit_masses(ContactBatch& batch,
                               const LaneBody& a,
                               const LaneBody& b,
                               const Lanes3& offset) {
    const Lanes zero = lanes(0.0F);
    const Lanes one = lanes(1.0F);
    const Lanes3 shift_a = batch.follow_b * offset;
    const Lanes3 shift_b = shift_a - offset - batch.between;
    const Lanes linear = a.inv_mass + b.inv_mass;
    batch.fitted = offset;
    for (std::size_t k = 0; k < batch.count; ++k) {
        PointLanes& p = points_[batch.points + k];
        const Lanes3 response_a = a.inverse * cross(p.arm + shift_a, batch.normal);
        const Lanes3 response_b = b.inverse * cross(p.arm + shift_b, batch.normal);
        for (std::size_t j = 0; j <= k; ++j) {
            const Lanes3& arm = points_[batch.points + j].arm;
            couplings_[batch.couplings + coupling_of(j, k)] =
                linear + dot(cross(arm + shift_a, batch.normal), response_a) +
                dot(cross(arm + shift_b, batch.normal), response_b);
        }
        p.mass = p.mass > zero ? one / couplings_[batch.couplings + coupling_of(k, k)] : zero;
    }
    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 grip_a = batch.grip + shift_a;
    const Lanes3 grip_b = batch.grip + shift_b;
    const auto mass = [&](const Lanes3& along) {
        return Lanes(linear + angular_mass(a.inverse, cross(grip_a, along)) +
                     angular_mass(b.inverse, cross(grip_b, along)));
    };
    const Lanes k11 = mass(batch.tangent);
    const Lanes k22 = mass(tangent2);
    const Lanes k12 = dot(cross(grip_a, batch.tangent), a.inverse * cross(grip_a, tangent2)) +
                      dot(cross(grip_b, batch.tangent), b.inverse * cross(grip_b, tangent2));
    // The floor is the rounding error of the difference.
    const Lanes determinant = max(k11 * k22 - k12 * k12, 1.0e-6F * k11 * k22);
    const auto used = batch.inv11 > zero;
    const Lanes inv_determinant = one / determinant;
    batch.inv11 = used ? k22 * inv_determinant : zero;
    batch.inv22 = used ? k11 * inv_determinant : zero;
    batch.inv12 = used ? -k12 * inv_determinant : zero;
    batch.twist_mass =
        used ? one / (angular_mass(a.inverse, batch.normal) + angular_mass(b.inverse, batch.normal))
             : zero;
}

}  // namespace zoned::physics
