// Impacts: the part of the contact solver that knows how fast bodies met, and makes them bounce.
#include "server/physics/simd/lane_body.h"
#include "server/physics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Passes over the contacts that bounce.
constexpr int kRestitutionIterations = 8;
/// Contacts that one thread watches at a time.
constexpr std::size_t kWatchGrain = 64;

}  // namespace

/// One lane of a batch, as plain vectors: impacts are few and branch a lot.
struct ContactSolver::Single {
    std::uint32_t a, b;
    Vec3 normal, tangent1, tangent2, shift_a, shift_b;
    float closing;

    Single(const ContactBatch& batch, std::size_t lane, const SolverBodies& bodies)
        : a(batch.a[lane]),
          b(batch.b[lane]),
          normal(batch.normal.get(lane)),
          tangent1(batch.tangent.get(lane)),
          tangent2(normal.cross(tangent1)) {
        const Vec3 offset = batch.lead.get(lane) + SolverBodies::linear(bodies.drift[b]) -
                            SolverBodies::linear(bodies.drift[a]);
        closing = normal.dot(offset);
        shift_a = batch.follow_b[lane] * offset;
        shift_b = shift_a - offset - batch.between.get(lane);
    }

    [[nodiscard]] Vec3 slip(const SolverBodies& bodies,
                            const Vec3& arm_a,
                            const Vec3& arm_b) const {
        const Row8& ma = bodies.motion[a];
        const Row8& mb = bodies.motion[b];
        return SolverBodies::linear(mb) - SolverBodies::linear(ma) +
               SolverBodies::angular(mb).cross(arm_b) - SolverBodies::angular(ma).cross(arm_a);
    }

    /// Separation now of a point that was `separation` apart at the time of contact.
    [[nodiscard]] float gap(float separation, const Vec3& arm, const SolverBodies& bodies) const {
        const Vec3 turn_a = SolverBodies::angular(bodies.drift[a]);
        const Vec3 turn_b = SolverBodies::angular(bodies.drift[b]);
        return separation + closing + (arm + shift_b).cross(normal).dot(turn_b) -
               (arm + shift_a).cross(normal).dot(turn_a);
    }

    void apply(SolverBodies& bodies,
               const Vec3& impulse,
               const Vec3& moment_a,
               const Vec3& moment_b) const {
        bodies.apply(a, -impulse, -moment_a);
        bodies.apply(b, impulse, moment_b);
    }

    void apply_at(SolverBodies& bodies, const Vec3& arm, const Vec3& impulse) const {
        apply(bodies, impulse, (arm + shift_a).cross(impulse), (arm + shift_b).cross(impulse));
    }
};

void ContactSolver::watch_impacts() {
    team_->run(watches_.size(), kWatchGrain, [this](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            watch(watches_[i]);
        }
    });
}

/// Notes how fast the surfaces will be when they meet, for points that will within this substep.
/// The velocities hold gravity for the whole substep already, the impact comes after the gap s was
/// closed: v_impact^2 = v_start^2 - 2 a s with the relative acceleration a along the normal.
void ContactSolver::watch(SolverWatch& w) {
    const ContactBatch& batch = batches_[w.batch];
    const std::uint32_t lane = w.lane;
    const Single at(batch, w.lane, moving_);
    const float gain = at.normal.dot(moving_.gravity_gain(at.b) - moving_.gravity_gain(at.a));
    w.pull = gain / h_;
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointLanes& p = points_[batch.points + k];
        if (p.mass[lane] == 0.0F || w.speed[k] > 0.0F) {
            continue;
        }
        const Vec3 arm_a = p.arm.get(w.lane) + at.shift_a;
        const Vec3 arm_b = p.arm.get(w.lane) + at.shift_b;
        const float s = at.gap(p.separation[lane], p.arm.get(w.lane), moving_);
        const float speed = at.normal.dot(at.slip(moving_, arm_a, arm_b));
        if (speed >= 0.0F || s + h_ * speed > 0.0F) {
            continue;
        }
        const float start = speed - (leaps_ ? 0.5F : 1.0F) * gain;
        const float impact = std::sqrt(std::max(0.0F, start * start - 2.0F * w.pull * s));
        if (impact > parameters_.restitution_speed) {
            w.speed[k] = impact;
            w.impact = true;
        }
    }
}

/// The impulse that stopped an impact is no force that goes on.
void ContactSolver::forget_impacts() {
    for (SolverWatch& w : watches_) {
        if (w.impact) {
            forget_impact(w);
        }
    }
}

void ContactSolver::forget_impact(SolverWatch& w) {
    ContactBatch& batch = batches_[w.batch];
    for (std::size_t k = 0; k < batch.count; ++k) {
        points_[batch.points + k].impulse[w.lane] = 0.0F;
    }
    batch.impulse1[w.lane] = 0.0F;
    batch.impulse2[w.lane] = 0.0F;
    batch.twist[w.lane] = 0.0F;
    w.impact = false;
}

/// Newton's restitution: points that met faster than the threshold and carried an impulse leave
/// with e times the speed of impact; friction of the second half of the impact comes with it.
void ContactSolver::restitute() {
    for (SolverWatch& w : watches_) {
        const ContactBatch& batch = batches_[w.batch];
        bool bounces = false;
        for (std::size_t k = 0; k < batch.count; ++k) {
            bounces |= w.speed[k] > 0.0F && points_[batch.points + k].total[w.lane] > 0.0F;
        }
        if (bounces && w.restitution > 0.0F) {
            aim(w);
            forget_impact(w);
            w.impact = true;
        }
    }
    const bool any = std::any_of(
        watches_.begin(), watches_.end(), [](const SolverWatch& w) { return w.impact; });
    for (int i = 0; any && i < kRestitutionIterations; ++i) {
        joints_.solve(moving_);
        for (SolverWatch& w : watches_) {
            if (w.impact) {
                bounce(w);
            }
        }
    }
    for (SolverWatch& w : watches_) {
        if (w.impact) {
            add_totals(w);
            forget_impact(w);
        }
    }
}

/// From the speed at which the surfaces met to that with which they have to part here, s from where
/// they met: v^2 = (e v_met)^2 + 2 a s with the relative acceleration a along the normal. Substeps
/// after the impact let the bodies sink a little, and that must cost no energy.
void ContactSolver::aim(SolverWatch& w) {
    const ContactBatch& batch = batches_[w.batch];
    const Single at(batch, w.lane, moving_);
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointLanes& p = points_[batch.points + k];
        if (w.speed[k] > 0.0F) {
            const float s = at.gap(p.separation[w.lane], p.arm.get(w.lane), moving_);
            const float part = w.restitution * w.speed[k];
            w.speed[k] = std::sqrt(std::max(0.0F, part * part + 2.0F * w.pull * s));
        }
    }
}

void ContactSolver::bounce(SolverWatch& w) {
    ContactBatch& batch = batches_[w.batch];
    const std::uint32_t lane = w.lane;
    const Single at(batch, w.lane, moving_);
    float push = 0.0F;
    float leverage = 0.0F;
    for (std::size_t k = 0; k < batch.count; ++k) {
        PointLanes& p = points_[batch.points + k];
        if (p.total[lane] <= 0.0F) {
            continue;
        }
        const Vec3 arm = p.arm.get(w.lane);
        const float speed = at.normal.dot(at.slip(moving_, arm + at.shift_a, arm + at.shift_b));
        const float wanted = p.impulse[lane] - p.mass[lane] * (speed - w.speed[k]);
        const float impulse = std::max(wanted, 0.0F);
        at.apply_at(moving_, arm, (impulse - p.impulse[lane]) * at.normal);
        p.impulse[lane] = impulse;
        push += impulse;
        leverage += impulse * p.lever[lane];
    }
    const float friction = batch.friction[lane];
    const float rate = at.normal.dot(SolverBodies::angular(moving_.motion[at.b]) -
                                     SolverBodies::angular(moving_.motion[at.a]));
    const float twist = std::clamp(batch.twist[lane] - batch.twist_mass[lane] * rate,
                                   -friction * leverage,
                                   friction * leverage);
    const Vec3 turn = (twist - batch.twist[lane]) * at.normal;
    batch.twist[lane] = twist;
    at.apply(moving_, Vec3::Zero(), turn, turn);
    const Vec3 grip = batch.grip.get(w.lane);
    const Vec3 slip = at.slip(moving_, grip + at.shift_a, grip + at.shift_b);
    const float v1 = at.tangent1.dot(slip);
    const float v2 = at.tangent2.dot(slip);
    float f1 = batch.impulse1[lane] - (batch.inv11[lane] * v1 + batch.inv12[lane] * v2);
    float f2 = batch.impulse2[lane] - (batch.inv12[lane] * v1 + batch.inv22[lane] * v2);
    const float limit = friction * push;
    const float size = std::sqrt(f1 * f1 + f2 * f2);
    if (size > limit) {
        f1 *= limit / size;
        f2 *= limit / size;
    }
    at.apply_at(
        moving_,
        grip,
        (f1 - batch.impulse1[lane]) * at.tangent1 + (f2 - batch.impulse2[lane]) * at.tangent2);
    batch.impulse1[lane] = f1;
    batch.impulse2[lane] = f2;
}

void ContactSolver::add_totals(const SolverWatch& w) {
    const ContactBatch& batch = batches_[w.batch];
    for (std::size_t k = 0; k < batch.count; ++k) {
        PointLanes& p = points_[batch.points + k];
        p.total[w.lane] += p.impulse[w.lane];
    }
}

}  // namespace zoned::physics
