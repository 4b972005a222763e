#include "server/physics/solver_variants/projection.h"

#include "server/physics/integrator/integrate.h"
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/joint_row_writer.h"

#include <cmath>

namespace zoned::physics {

namespace {

Mat3d axes_of(const VariantBody& body) {
    return body.orientation.toRotationMatrix().cast<double>();
}

/// Inverse mass of two points along a direction.
double response_of(const RowBody& p,
                   const RowBody& q,
                   const Vec3d& arm_a,
                   const Vec3d& arm_b,
                   const Vec3d& n) {
    const Vec3d u = arm_a.cross(n);
    const Vec3d v = arm_b.cross(n);
    return p.inv_mass + q.inv_mass + u.dot(p.inverse * u) + v.dot(q.inverse * v);
}

/// An impulse that has acted since the substep began: it has changed the velocity, and by h times
/// that the pose.
void act(RowBody& body, VariantBody& pose, double h, const Vec3d& impulse, const Vec3d& moment) {
    if (body.inv_mass == 0.0) {
        return;
    }
    const Vec3d velocity = body.inv_mass * impulse;
    const Vec3d spin = body.inverse * moment;
    body.velocity += velocity;
    body.spin += spin;
    pose.shift += h * velocity;
    pose.turn += h * spin;
    pose.orientation = turned(pose.orientation, Vec3((h * spin).cast<float>()));
}

Vec3d point_velocity(const RowBody& body, const Vec3d& arm) {
    return body.velocity + body.spin.cross(arm);
}

}  // namespace

void Projection::list_points(const BodyPlace& place,
                             std::span<const ContactSpan> contacts,
                             const VariantBodies& moving,
                             const RowSystem& system) {
    axes_.clear();
    for (std::size_t slot = 0; slot < moving.size(); ++slot) {
        axes_.push_back(axes_of(moving[slot]));
    }
    points_.clear();
    for (const ContactSpan& span : contacts) {
        const Contact& contact = place.graph[span.contact];
        for (std::uint32_t i = 0; i < span.points; ++i) {
            // A divided contact has one row at its middle.
            if (span.divided && i > 0) {
                break;
            }
            ProjectionPoint point;
            point.normal_row = span.first + i;
            const RowShape& row = system.shape[point.normal_row];
            point.a = system.a[point.normal_row];
            point.b = system.b[point.normal_row];
            point.normal = row.linear;
            point.tangent1 = span.tangent1;
            point.tangent2 = span.tangent2;
            if (span.rubs) {
                point.tangent_row =
                    span.divided ? span.first + 1 : span.first + span.points + 2 * i;
            }
            // n x (r x n) is the arm less its part along the normal, which no normal impulse feels;
            // friction does, so that the arms are taken whole.
            point.local_a = axes_[point.a].transpose() * system.arm_a[point.normal_row];
            point.local_b = axes_[point.b].transpose() * system.arm_b[point.normal_row];
            point.gap = system.gap[point.normal_row];
            const VariantBody& p = moving[point.a];
            const VariantBody& q = moving[point.b];
            point.met = point.normal.dot(q.velocity + q.spin.cross(system.arm_b[point.normal_row]) -
                                         p.velocity - p.spin.cross(system.arm_a[point.normal_row]));
            point.apart = (q.shift + system.arm_b[point.normal_row]) -
                          (p.shift + system.arm_a[point.normal_row]);
            point.friction = static_cast<double>(contact.grip.friction);
            point.restitution = static_cast<double>(contact.grip.restitution);
            points_.push_back(point);
        }
    }
}

/// Normal first, then friction: the slip since the substep began is taken back as far as the cone
/// allows.
void Projection::project_point(ProjectionPoint& point,
                               VariantBodies& moving,
                               RowSystem& system) const {
    RowBody& p = system.bodies[point.a];
    RowBody& q = system.bodies[point.b];
    VariantBody& pose_a = moving[point.a];
    VariantBody& pose_b = moving[point.b];
    const Vec3d arm_a = axes_of(pose_a) * point.local_a;
    const Vec3d arm_b = axes_of(pose_b) * point.local_b;
    const Vec3d moved = (pose_b.shift + arm_b) - (pose_a.shift + arm_a) - point.apart;
    const double gap = point.gap + point.normal.dot(moved);
    const double response = response_of(p, q, arm_a, arm_b, point.normal);
    if ((gap >= 0.0 && point.push <= 0.0) || !(response > 0.0)) {
        return;
    }
    // A body pushed too far, because another contact pushed as well, is taken back.
    const double before = point.push;
    point.push = std::max(before - gap / (response * h_), 0.0);
    const double push = point.push - before;
    Vec3d impulse = push * point.normal;
    if (point.friction > 0.0) {
        const double along = response_of(p, q, arm_a, arm_b, point.tangent1);
        const double across = response_of(p, q, arm_a, arm_b, point.tangent2);
        double x = point.rub1 - point.tangent1.dot(moved) / (along * h_);
        double y = point.rub2 - point.tangent2.dot(moved) / (across * h_);
        project_on_disc(point.friction * point.push, x, y);
        impulse += (x - point.rub1) * point.tangent1 + (y - point.rub2) * point.tangent2;
        point.rub1 = x;
        point.rub2 = y;
    }
    act(p, pose_a, h_, -impulse, -arm_a.cross(impulse));
    act(q, pose_b, h_, impulse, arm_b.cross(impulse));
}

void Projection::project_joints(const BodyPlace& place,
                                VariantBodies& moving,
                                RowSystem& system) const {
    for (const std::uint32_t index : place.joint_list) {
        const JointEntry& entry = place.joints[index];
        const Vec3 origin = place.bodies.position[entry.b];
        const auto slot = [&](std::uint32_t row) {
            return row != kNoIndex && place.bodies.awake[row] != 0 ? place.bodies.solver_slot[row]
                                                                   : 0U;
        };
        const std::uint32_t a = slot(entry.a);
        const std::uint32_t b = slot(entry.b);
        JointRows rows;
        write_rows(entry.joint,
                   pose_of(place.bodies, moving, entry.a, origin),
                   pose_of(place.bodies, moving, entry.b, origin),
                   rows);
        for (std::size_t i = 0; i < rows.count; ++i) {
            const JointRow& row = rows.rows[i];
            const auto error = static_cast<double>(row.error);
            if (row.kind != RowKind::kHard && (row.kind != RowKind::kLimit || error >= 0.0)) {
                continue;
            }
            RowBody& p = system.bodies[a];
            RowBody& q = system.bodies[b];
            const Vec3d linear = row.linear.cast<double>();
            const Vec3d angular_a = row.angular_a.cast<double>();
            const Vec3d angular_b = row.angular_b.cast<double>();
            const double response = (p.inv_mass + q.inv_mass) * linear.squaredNorm() +
                                    angular_a.dot(p.inverse * angular_a) +
                                    angular_b.dot(q.inverse * angular_b);
            if (response > 0.0) {
                const double impulse = -error / (response * h_);
                act(p, moving[a], h_, -impulse * linear, impulse * angular_a);
                act(q, moving[b], h_, impulse * linear, impulse * angular_b);
            }
        }
    }
}

/// Points that press are closed when the substep ends: their speed along the normal is that of
/// restitution, or nothing. The speed left by the push out of an overlap goes so, through a whole
/// stack in several passes.
void Projection::correct_velocities(const BodyPlace& place, RowSystem& system) {
    for (const ProjectionPoint& point : points_) {
        if (point.push <= 0.0) {
            continue;
        }
        RowBody& p = system.bodies[point.a];
        RowBody& q = system.bodies[point.b];
        const Vec3d arm_a = axes_[point.a] * point.local_a;
        const Vec3d arm_b = axes_[point.b] * point.local_b;
        const double speed = point.normal.dot(point_velocity(q, arm_b) - point_velocity(p, arm_a));
        const bool fast = point.met < -static_cast<double>(place.settings.restitution_speed_mps);
        const double bounce = fast ? -point.restitution * point.met : 0.0;
        const double change = bounce - speed;
        const double response = response_of(p, q, arm_a, arm_b, point.normal);
        const Vec3d impulse = (change / response) * point.normal;
        p.velocity -= p.inv_mass * impulse;
        p.spin -= p.inverse * arm_a.cross(impulse);
        q.velocity += q.inv_mass * impulse;
        q.spin += q.inverse * arm_b.cross(impulse);
    }
}

void Projection::solve(const BodyPlace& place,
                       std::span<const ContactSpan> contacts,
                       VariantBodies& moving,
                       RowSystem& system) {
    h_ = place.h;
    list_points(place, contacts, moving, system);
    const int iterations = place.settings.methods.iterations;
    // Motors and springs act on velocities before the bodies fly.
    for (int i = 0; i < iterations && !place.joint_list.empty(); ++i) {
        for (const std::uint32_t row : system.order) {
            if (system.role[row] == RowRole::kBounded && system.undoes[row] == 0 &&
                system.rub[row] == 0 && system.low[row] < 0.0) {
                relax_row(system, row, 1.0);
            }
        }
    }
    moving.move(place.bodies, h_, false, system);
    for (int i = 0; i < iterations; ++i) {
        project_joints(place, moving, system);
        for (ProjectionPoint& point : points_) {
            project_point(point, moving, system);
        }
    }
    for (int i = 0; i < iterations; ++i) {
        correct_velocities(place, system);
    }
    for (const ProjectionPoint& point : points_) {
        system.lambda[point.normal_row] = point.push;
        if (point.tangent_row != kNoIndex) {
            system.lambda[point.tangent_row] = point.rub1;
            system.lambda[point.tangent_row + 1] = point.rub2;
        }
    }
}

}  // namespace zoned::physics
