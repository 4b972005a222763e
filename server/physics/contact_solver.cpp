#include "server/physics/contact_solver.h"

#include "server/physics/lane_body.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// Overlap is undone no faster than this, m/s.
constexpr float kPushSpeed = 3.0F;

/// Speed of b's point relative to a's along a direction.
[[gnu::always_inline]] inline Lanes speed_along(const LaneBody& a,
                                                const LaneBody& b,
                                                const Lanes3& direction,
                                                const Lanes3& moment_a,
                                                const Lanes3& moment_b) {
    return dot(direction, b.velocity - a.velocity) + dot(moment_b, b.spin) - dot(moment_a, a.spin);
}

}  // namespace

/// How far the bodies have drifted apart from where they stand at the contact. Arms that started at
/// one point end at one point again: a's grows by `shift_a`, b's by `shift_b`.
struct ContactSolver::Arms {
    Lanes closing;  ///< of b relative to a, along the normal
    Lanes3 shift_a, shift_b;

    [[gnu::always_inline]] Arms(const ContactBatch& batch, const LaneBody& a, const LaneBody& b) {
        const Lanes3 offset = batch.lead + (b.shift - a.shift);
        closing = dot(batch.normal, offset);
        shift_a = batch.follow_b * offset;
        shift_b = shift_a - offset - batch.between;
    }
};

void ContactSolver::reserve(std::size_t bodies, std::size_t contacts) {
    moving_.reserve(bodies);
    coloring_.reserve(bodies, contacts);
    batches_.reserve(contacts);
    points_.reserve(contacts);
    watches_.reserve(contacts);
}

void ContactSolver::warm_start() {
    for (ContactBatch& batch : batches_) {
        LaneBody a(moving_, batch.a);
        LaneBody b(moving_, batch.b);
        const Arms arms(batch, a, b);
        const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
        const Lanes3 shear = batch.impulse1 * batch.tangent + batch.impulse2 * tangent2;
        // The points' impulses are parallel: one force at their centre of pressure.
        Lanes push = lanes(0.0F);
        Lanes3 lever{push, push, push};
        for (std::size_t k = 0; k < batch.count; ++k) {
            const PointLanes& p = points_[batch.points + k];
            push += p.impulse;
            lever = lever + p.impulse * p.arm;
        }
        const Lanes3 thrust = push * batch.normal;
        const Lanes3 impulse = thrust + shear;
        const Lanes3 moment =
            cross(lever, batch.normal) + cross(batch.grip, shear) + batch.twist * batch.normal;
        a.pull(impulse, moment + cross(arms.shift_a, impulse));
        b.push(impulse, moment + cross(arms.shift_b, impulse));
        a.store(moving_, batch.a);
        b.store(moving_, batch.b);
    }
}

[[gnu::always_inline]] inline void ContactSolver::solve_friction(ContactBatch& batch,
                                                                 LaneBody& a,
                                                                 LaneBody& b,
                                                                 const Arms& arms,
                                                                 const Lanes& push,
                                                                 const Lanes& leverage) const {
    const Lanes twist_limit = batch.friction * leverage;
    const Lanes rate = dot(batch.normal, b.spin - a.spin);
    const Lanes twist = max(min(batch.twist - batch.twist_mass * rate, twist_limit), -twist_limit);
    const Lanes3 turn = (twist - batch.twist) * batch.normal;
    batch.twist = twist;
    a.spin = a.spin - a.inverse * turn;
    b.spin = b.spin + b.inverse * turn;

    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 arm_a = batch.grip + arms.shift_a;
    const Lanes3 arm_b = batch.grip + arms.shift_b;
    const Lanes3 slip = (b.velocity - a.velocity) + (cross(b.spin, arm_b) - cross(a.spin, arm_a));
    const Lanes v1 = dot(batch.tangent, slip);
    const Lanes v2 = dot(tangent2, slip);
    Lanes f1 = batch.impulse1 - (batch.inv11 * v1 + batch.inv12 * v2);
    Lanes f2 = batch.impulse2 - (batch.inv12 * v1 + batch.inv22 * v2);
    // Scaled back onto the cone: limit / max(size, limit) is 1 inside of it. The smallest size
    // keeps 0 / 0 out.
    const Lanes limit = batch.friction * push;
    const Lanes size = sqrt(f1 * f1 + f2 * f2);
    const Lanes scale = limit / max(max(size, limit), lanes(1.0e-30F));
    f1 *= scale;
    f2 *= scale;
    const Lanes3 impulse = (f1 - batch.impulse1) * batch.tangent + (f2 - batch.impulse2) * tangent2;
    batch.impulse1 = f1;
    batch.impulse2 = f2;
    a.pull(impulse, cross(arm_a, impulse));
    b.push(impulse, cross(arm_b, impulse));
}

/// Normals first, then friction within the cone that they allow: after an impact the cone has to
/// shrink with the push in the same pass.
///
/// With springs, a gap s may close as far as the surface within the substep (bias s / h), an
/// overlap is pushed apart softly. Without them, overlap is left alone, and so is a gap that no
/// impulse holds open: positions were moved already, it is the next substep's affair.
template <bool kSoft>
[[gnu::always_inline]] inline void ContactSolver::solve_batch(ContactBatch& batch) {
    LaneBody a(moving_, batch.a);
    LaneBody b(moving_, batch.b);
    const Arms arms(batch, a, b);
    const Lanes zero = lanes(0.0F);
    const Lanes inv_h = lanes(1.0F / h_);
    Lanes push = zero;
    Lanes leverage = zero;
    for (std::size_t k = 0; k < batch.count; ++k) {
        PointLanes& p = points_[batch.points + k];
        const Lanes3 moment_a = cross(p.arm + arms.shift_a, batch.normal);
        const Lanes3 moment_b = cross(p.arm + arms.shift_b, batch.normal);
        const Lanes s = p.separation + arms.closing + dot(moment_b, b.turn) - dot(moment_a, a.turn);
        const Lanes speed = speed_along(a, b, batch.normal, moment_a, moment_b);
        const Lanes gap = max(s, zero) * inv_h;
        Lanes impulse;
        if constexpr (kSoft) {
            const Lanes bias = gap + max(softness_.bias_rate * min(s, zero), lanes(-kPushSpeed));
            const Lanes stiff = p.mass * (speed + bias);
            const Lanes give =
                softness_.impulse_scale * p.impulse - (1.0F - softness_.mass_scale) * stiff;
            impulse = max(p.impulse - stiff - where_not_positive(s, give), zero);
        } else {
            const Lanes held = (p.impulse + max(-s, zero)) * lanes(1.0e30F);
            impulse = min(max(p.impulse - p.mass * (speed + gap), zero), held);
        }
        const Lanes change = impulse - p.impulse;
        p.impulse = impulse;
        a.pull(change * batch.normal, change * moment_a);
        b.push(change * batch.normal, change * moment_b);
        push += impulse;
        leverage += impulse * p.lever;
    }
    solve_friction(batch, a, b, arms, push, leverage);
    a.store(moving_, batch.a);
    b.store(moving_, batch.b);
}

template <bool kSoft>
void ContactSolver::solve_all() {
    for (ContactBatch& batch : batches_) {
        solve_batch<kSoft>(batch);
    }
}

void ContactSolver::substep(const Bodies& bodies) {
    moving_.integrate_velocities();
    watch_impacts();
    warm_start();
    for (int i = 0; i < parameters_.iterations; ++i) {
        solve_all<true>();
    }
    moving_.integrate_positions(bodies);
    for (int i = 0; i < parameters_.relax_iterations; ++i) {
        solve_all<false>();
    }
    for (PointLanes& p : points_) {
        p.total += p.impulse;
    }
    moving_.follow_mean_velocity();
    forget_impacts();
}

void ContactSolver::store(Bodies& bodies,
                          ContactGraph& graph,
                          std::vector<std::uint32_t>& broken) const {
    moving_.store(bodies, broken);
    for (const ContactBatch& batch : batches_) {
        const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
        const Lanes3 shear = batch.impulse1 * batch.tangent + batch.impulse2 * tangent2;
        for (std::size_t lane = 0; lane < kLanes && batch.contact[lane] != kNoIndex; ++lane) {
            Contact& contact = graph[batch.contact[lane]];
            contact.friction = shear.get(lane);
            contact.twist = batch.twist[lane];
            contact.step_impulse = 0.0F;
            for (std::size_t k = 0; k < static_cast<std::size_t>(contact.count); ++k) {
                const PointLanes& p = points_[batch.points + k];
                contact.points[k].impulse = p.impulse[lane];
                contact.step_impulse += p.total[lane];
            }
        }
    }
}

void ContactSolver::solve(Bodies& bodies,
                          ContactGraph& graph,
                          std::span<const std::uint32_t> list,
                          const Parameters& parameters,
                          std::vector<std::uint32_t>& broken) {
    parameters_ = parameters;
    h_ = parameters.dt / static_cast<float>(parameters.substeps);
    prepare(bodies, graph, list);
    for (int i = 0; i < parameters.substeps; ++i) {
        substep(bodies);
    }
    restitute();
    store(bodies, graph, broken);
}

}  // namespace zoned::physics
