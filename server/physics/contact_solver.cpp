#include "server/physics/contact_solver.h"

#include "server/physics/inertia.h"
#include "server/physics/integrate.h"
#include "server/physics/validate.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace zoned::physics {

namespace {

/// Overlap is undone no faster than this, m/s.
constexpr float kPushSpeed = 3.0F;
/// Passes over the contacts that bounce.
constexpr int kRestitutionIterations = 8;

/// Written out: the compiler leaves Eigen's product as a call, and this is the innermost loop.
[[gnu::always_inline]] inline Vec3 times(const Mat3& m, const Vec3& v) {
    return {m(0, 0) * v.x() + m(0, 1) * v.y() + m(0, 2) * v.z(),
            m(1, 0) * v.x() + m(1, 1) * v.y() + m(1, 2) * v.z(),
            m(2, 0) * v.x() + m(2, 1) * v.y() + m(2, 2) * v.z()};
}

[[gnu::always_inline]] inline void apply(SolverBody& a,
                                         SolverBody& b,
                                         const Vec3& direction,
                                         const Vec3& moment_a,
                                         const Vec3& moment_b,
                                         float impulse) {
    a.velocity -= (impulse * a.inv_mass) * direction;
    b.velocity += (impulse * b.inv_mass) * direction;
    a.spin -= times(a.inv_inertia, impulse * moment_a);
    b.spin += times(b.inv_inertia, impulse * moment_b);
}

[[gnu::always_inline]] inline float speed_along(const SolverBody& a,
                                                const SolverBody& b,
                                                const Vec3& direction,
                                                const Vec3& moment_a,
                                                const Vec3& moment_b) {
    return direction.dot(b.velocity - a.velocity) + moment_b.dot(b.spin) - moment_a.dot(a.spin);
}

}  // namespace

void ContactSolver::reserve(std::size_t bodies, std::size_t contacts) {
    moving_.reserve(bodies + 1);
    constraints_.reserve(contacts);
}

ContactSolver::Drift ContactSolver::drift_of(const Constraint& c,
                                             const SolverBody& a,
                                             const SolverBody& b) const {
    Drift drift;
    drift.offset = c.lead + b.shift - a.shift;
    drift.closing = c.normal.dot(drift.offset);
    drift.shift_a = c.follow_b * drift.offset;
    drift.shift_b = drift.shift_a - drift.offset;
    drift.moment_a = drift.shift_a.cross(c.normal);
    drift.moment_b = drift.shift_b.cross(c.normal);
    return drift;
}

void ContactSolver::integrate_velocities() {
    const Vec3 gain = h_ * parameters_.gravity;
    for (SolverBody& body : moving_) {
        body.start_velocity = body.velocity;
        if (body.inv_mass > 0.0F) {
            body.velocity += gain;
        }
    }
}

void ContactSolver::integrate_positions(const Bodies& bodies) {
    for (SolverBody& body : moving_) {
        body.shift += h_ * body.velocity;
        if (body.spin.isZero(0.0F)) {
            continue;
        }
        if (body.inv_mass == 0.0F || bodies.round[body.row] != 0) {
            const Vec3 turn = h_ * body.spin;
            body.orientation = turned(body.orientation, turn);
            body.turn += turn;
            continue;
        }
        body.turn += rotate_freely(bodies.inertia[body.row], h_, body.orientation, body.spin);
        body.inv_inertia =
            rotated_tensor(body.orientation.toRotationMatrix(), bodies.inv_inertia[body.row]);
    }
}

/// A substep moved bodies with the velocity at its end. Where the velocity changed by forces, the
/// mean of both ends is exact to second order (x += v h + a h^2 / 2), and with it the path of a
/// thrown body. Where it changed by an impact there is no such mean: what is more than twice what
/// gravity does is left alone.
void ContactSolver::follow_mean_velocity() {
    const float limit = 2.0F * h_ * parameters_.gravity.norm();
    for (SolverBody& body : moving_) {
        const Vec3 change = body.velocity - body.start_velocity;
        if (change.squaredNorm() <= limit * limit) {
            body.shift -= 0.5F * h_ * change;
        }
    }
}

/// Notes how fast the surfaces will be when they meet, for points that will within this substep.
/// The velocities hold gravity for the whole substep already, the impact comes after the gap s was
/// closed: v_impact^2 = v_start^2 - 2 a s with the relative acceleration a along the normal.
void ContactSolver::watch_impacts(Constraint& c) const {
    const SolverBody& a = moving_[c.a];
    const SolverBody& b = moving_[c.b];
    const Drift drift = drift_of(c, a, b);
    const float pull = c.normal.dot(parameters_.gravity) *
                       ((b.inv_mass > 0.0F ? 1.0F : 0.0F) - (a.inv_mass > 0.0F ? 1.0F : 0.0F));
    for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
        Point& p = c.points[i];
        const Vec3 moment_a = p.moment_a + drift.moment_a;
        const Vec3 moment_b = p.moment_b + drift.moment_b;
        const float s = p.separation + drift.closing + moment_b.dot(b.turn) - moment_a.dot(a.turn);
        const float speed = speed_along(a, b, c.normal, moment_a, moment_b);
        if (p.impact > 0.0F || speed >= 0.0F || s + h_ * speed > 0.0F) {
            continue;
        }
        const float start = speed - h_ * pull;
        const float impact = std::sqrt(std::max(0.0F, start * start - 2.0F * pull * s));
        if (impact > parameters_.restitution_speed) {
            p.impact = impact;
            c.impact = true;
        }
    }
}

void ContactSolver::warm_start(Constraint& c) {
    SolverBody& a = moving_[c.a];
    SolverBody& b = moving_[c.b];
    const Drift drift = drift_of(c, a, b);
    Vec3 impulse = c.impulse1 * c.tangent1 + c.impulse2 * c.tangent2;
    const Vec3 shear = impulse;
    Vec3 moment_a = c.impulse1 * c.moment1_a + c.impulse2 * c.moment2_a + c.twist * c.normal;
    Vec3 moment_b = c.impulse1 * c.moment1_b + c.impulse2 * c.moment2_b + c.twist * c.normal;
    float push = 0.0F;
    for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
        const Point& p = c.points[i];
        push += p.impulse;
        moment_a += p.impulse * p.moment_a;
        moment_b += p.impulse * p.moment_b;
    }
    impulse += push * c.normal;
    moment_a += push * drift.moment_a + drift.shift_a.cross(shear);
    moment_b += push * drift.moment_b + drift.shift_b.cross(shear);
    a.velocity -= a.inv_mass * impulse;
    b.velocity += b.inv_mass * impulse;
    a.spin -= times(a.inv_inertia, moment_a);
    b.spin += times(b.inv_inertia, moment_b);
}

void ContactSolver::solve_friction(Constraint& c,
                                   SolverBody& a,
                                   SolverBody& b,
                                   const Drift& drift) const {
    float push = 0.0F;
    float leverage = 0.0F;
    for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
        push += c.points[i].impulse;
        leverage += c.points[i].impulse * c.points[i].lever;
    }
    if (leverage > 0.0F || c.twist != 0.0F) {
        const float rate = c.normal.dot(b.spin - a.spin);
        const float limit = c.friction * leverage;
        const float twist = std::clamp(c.twist - c.twist_mass * rate, -limit, limit);
        const float change = twist - c.twist;
        c.twist = twist;
        a.spin -= times(a.inv_inertia, change * c.normal);
        b.spin += times(b.inv_inertia, change * c.normal);
    }
    const Vec3 m1a = c.moment1_a + drift.shift_a.cross(c.tangent1);
    const Vec3 m1b = c.moment1_b + drift.shift_b.cross(c.tangent1);
    const Vec3 m2a = c.moment2_a + drift.shift_a.cross(c.tangent2);
    const Vec3 m2b = c.moment2_b + drift.shift_b.cross(c.tangent2);
    const float v1 = speed_along(a, b, c.tangent1, m1a, m1b);
    const float v2 = speed_along(a, b, c.tangent2, m2a, m2b);
    float f1 = c.impulse1 - (c.inv11 * v1 + c.inv12 * v2);
    float f2 = c.impulse2 - (c.inv12 * v1 + c.inv22 * v2);
    const float limit = c.friction * push;
    const float size2 = f1 * f1 + f2 * f2;
    if (size2 > limit * limit) {
        const float scale = limit / std::sqrt(size2);
        f1 *= scale;
        f2 *= scale;
    }
    apply(a, b, c.tangent1, m1a, m1b, f1 - c.impulse1);
    apply(a, b, c.tangent2, m2a, m2b, f2 - c.impulse2);
    c.impulse1 = f1;
    c.impulse2 = f2;
}

/// Normals first, then friction within the cone that they allow: after an impact the cone has to
/// shrink with the push in the same pass.
template <bool kSoft>
void ContactSolver::solve_constraint(Constraint& c) {
    SolverBody& a = moving_[c.a];
    SolverBody& b = moving_[c.b];
    const Drift drift = drift_of(c, a, b);
    const float inv_h = 1.0F / h_;
    for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
        Point& p = c.points[i];
        const Vec3 moment_a = p.moment_a + drift.moment_a;
        const Vec3 moment_b = p.moment_b + drift.moment_b;
        const float s = p.separation + drift.closing + moment_b.dot(b.turn) - moment_a.dot(a.turn);
        float bias = 0.0F;
        float mass_scale = 1.0F;
        float impulse_scale = 0.0F;
        if (s > 0.0F) {
            if (!kSoft && p.impulse == 0.0F) {
                continue;  // positions were moved already: this gap is the next substep's affair
            }
            bias = s * inv_h;  // may come as far as the surface within this substep
        } else if (kSoft) {
            bias = std::max(softness_.bias_rate * s, -kPushSpeed);
            mass_scale = softness_.mass_scale;
            impulse_scale = softness_.impulse_scale;
        }
        const float speed = speed_along(a, b, c.normal, moment_a, moment_b);
        const float wanted =
            p.impulse - p.mass * mass_scale * (speed + bias) - impulse_scale * p.impulse;
        const float impulse = std::max(wanted, 0.0F);
        apply(a, b, c.normal, moment_a, moment_b, impulse - p.impulse);
        p.impulse = impulse;
    }
    solve_friction(c, a, b, drift);
}

void ContactSolver::end_substep(Constraint& c) const {
    for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
        Point& p = c.points[i];
        p.total += p.impulse;
        p.impulse = c.impact ? 0.0F : p.impulse;
    }
    if (c.impact) {
        // What stopped an impact is no force that goes on.
        c.impulse1 = 0.0F;
        c.impulse2 = 0.0F;
        c.twist = 0.0F;
        c.impact = false;
    }
}

void ContactSolver::substep(const Bodies& bodies) {
    integrate_velocities();
    for (Constraint& c : constraints_) {
        if (c.watched) {
            watch_impacts(c);
        }
    }
    for (Constraint& c : constraints_) {
        warm_start(c);
    }
    for (int i = 0; i < parameters_.iterations; ++i) {
        for (Constraint& c : constraints_) {
            solve_constraint<true>(c);
        }
    }
    integrate_positions(bodies);
    for (int i = 0; i < parameters_.relax_iterations; ++i) {
        for (Constraint& c : constraints_) {
            solve_constraint<false>(c);
        }
    }
    follow_mean_velocity();
    for (Constraint& c : constraints_) {
        end_substep(c);
    }
}

/// Newton's restitution: points that met faster than the threshold and carried an impulse leave
/// with e times the speed of impact; friction of the second half of the impact comes with it.
void ContactSolver::restitute() {
    const auto bounces = [](const Constraint& c) {
        const auto points = std::span(c.points).first(static_cast<std::size_t>(c.count));
        return c.restitution > 0.0F &&
               std::any_of(points.begin(), points.end(), [](const Point& p) {
                   return p.impact > 0.0F && p.total > 0.0F;
               });
    };
    for (Constraint& c : constraints_) {
        if (bounces(c)) {
            c.impact = true;
            end_substep(c);
            c.impact = true;
        }
    }
    for (int i = 0; i < kRestitutionIterations; ++i) {
        for (Constraint& c : constraints_) {
            if (!c.impact) {
                continue;
            }
            SolverBody& a = moving_[c.a];
            SolverBody& b = moving_[c.b];
            const Drift drift = drift_of(c, a, b);
            for (std::size_t k = 0; k < static_cast<std::size_t>(c.count); ++k) {
                Point& p = c.points[k];
                if (p.total <= 0.0F) {
                    continue;
                }
                const Vec3 moment_a = p.moment_a + drift.moment_a;
                const Vec3 moment_b = p.moment_b + drift.moment_b;
                const float speed = speed_along(a, b, c.normal, moment_a, moment_b);
                const float wanted = p.impulse - p.mass * (speed - c.restitution * p.impact);
                const float impulse = std::max(wanted, 0.0F);
                apply(a, b, c.normal, moment_a, moment_b, impulse - p.impulse);
                p.impulse = impulse;
            }
            solve_friction(c, a, b, drift);
        }
    }
    for (Constraint& c : constraints_) {
        if (c.impact) {
            end_substep(c);
        }
    }
}

void ContactSolver::store(Bodies& bodies,
                          ContactGraph& graph,
                          std::vector<std::uint32_t>& broken) const {
    for (std::size_t i = 1; i < moving_.size(); ++i) {
        const SolverBody& body = moving_[i];
        const Vec3 position = bodies.position[body.row] + body.shift;
        if (!fit_position(position) || !fit_velocity(body.velocity, body.spin) ||
            !fit_orientation(body.orientation)) {
            broken.push_back(body.row);
            bodies.set_pose(body.row, bodies.position[body.row], bodies.orientation[body.row]);
            bodies.velocity[body.row].setZero();
            bodies.angular_velocity[body.row].setZero();
            continue;
        }
        bodies.set_pose(body.row, position, body.orientation);
        bodies.velocity[body.row] = body.velocity;
        bodies.angular_velocity[body.row] = body.spin;
    }
    for (const Constraint& c : constraints_) {
        Contact& contact = graph[c.contact];
        contact.friction = c.impulse1 * c.tangent1 + c.impulse2 * c.tangent2;
        contact.twist = c.twist;
        contact.step_impulse = 0.0F;
        for (std::size_t i = 0; i < static_cast<std::size_t>(c.count); ++i) {
            contact.points[i].impulse = c.points[i].impulse;
            contact.step_impulse += c.points[i].total;
        }
    }
}

void ContactSolver::solve(Bodies& bodies,
                          ContactGraph& graph,
                          const std::vector<std::uint32_t>& list,
                          const Parameters& parameters,
                          std::vector<std::uint32_t>& broken) {
    parameters_ = parameters;
    h_ = parameters.dt / static_cast<float>(parameters.substeps);
    gather(bodies);
    prepare(bodies, graph, list);
    for (int i = 0; i < parameters.substeps; ++i) {
        substep(bodies);
    }
    restitute();
    store(bodies, graph, broken);
}

}  // namespace zoned::physics
