#include "tests/bench/motion_sums.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace zoned::bench {

namespace {

MotionSums sums(const scenario::Description& d, const std::function<Motion(std::size_t)>& motion) {
    MotionSums out;
    for (std::size_t i = 0; i < d.bodies.size(); ++i) {
        const scenario::Body& body = d.bodies[i];
        if (body.mass == 0.0) {
            continue;
        }
        const Motion m = motion(i);
        if (!is_finite(m)) {
            ++out.not_finite;
            continue;
        }
        out.kinetic += kinetic_energy(body, m);
        out.potential -= body.mass * d.gravity.dot(m.pose.position);
        out.momentum += body.mass * m.velocity;
        out.momentum_size += body.mass * m.velocity.norm();
        out.fastest = std::max(out.fastest, m.velocity.norm());
    }
    return out;
}

/// The part of a joint on one body: where it now is, and its axis.
struct Side {
    Vec3d point;
    Vec3d axis;
};

Side side_of(const scenario::Description& d,
             const Simulator& simulator,
             int body,
             const scenario::LinkedPair& joint) {
    if (body == scenario::kWorld) {
        return {joint.anchor, joint.axis};
    }
    const auto i = static_cast<std::size_t>(body);
    const scenario::Pose& start = d.bodies[i].pose;
    const scenario::Pose now = simulator.motion(i).pose;
    const scenario::Quatd turn = now.orientation * start.orientation.conjugate();
    return {now.position + turn * (joint.anchor - start.position), turn * joint.axis};
}

}  // namespace

bool is_finite(const Motion& m) {
    return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() &&
           m.velocity.allFinite() && m.spin.allFinite();
}

double kinetic_energy(const scenario::Body& body, const Motion& m) {
    const Vec3d spin = m.pose.orientation.conjugate() * m.spin;
    const Vec3d inertia = body.solid.inertia_per_mass();
    return 0.5 * body.mass * (m.velocity.squaredNorm() + spin.dot(inertia.cwiseProduct(spin)));
}

MotionSums sums_at_start(const scenario::Description& d) {
    return sums(d, [&d](std::size_t i) {
        Motion m;
        m.pose = d.bodies[i].pose;
        m.velocity = d.bodies[i].velocity;
        m.spin = d.bodies[i].spin;
        return m;
    });
}

MotionSums sums_now(const scenario::Description& d, const Simulator& simulator) {
    return sums(d, [&simulator](std::size_t i) { return simulator.motion(i); });
}

JointErrors joint_errors(const scenario::Description& d, const Simulator& simulator) {
    JointErrors out;
    for (const scenario::LinkedPair& joint : d.joints) {
        const Side a = side_of(d, simulator, joint.a, joint);
        const Side b = side_of(d, simulator, joint.b, joint);
        const double gap = (a.point - b.point).norm();
        if (!std::isfinite(gap)) {
            return {INFINITY, INFINITY};
        }
        out.gap_m = std::max(out.gap_m, gap);
        if (joint.link == scenario::Link::kHinge) {
            out.axis_rad =
                std::max(out.axis_rad, std::atan2(a.axis.cross(b.axis).norm(), a.axis.dot(b.axis)));
        }
    }
    return out;
}

}  // namespace zoned::bench
