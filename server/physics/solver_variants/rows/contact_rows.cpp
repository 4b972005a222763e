#include "server/physics/solver_variants/rows/contact_rows.h"

#include "server/physics/contacts/contact_persistence.h"
#include "server/physics/solver_variants/rows/restitution.h"
#include "server/physics/solver_variants/rows/stabilise.h"
#include "shared/math/perpendicular.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Points that will be this much farther apart than the nearest carry nothing of a divided load, m.
constexpr double kSpread = 0.005;

/// Spread over (w h)^2 of one contact's rocking at a spread of 1 m; see ContactRows::spread_of.
constexpr double kRockingMargin = 1.5;

}  // namespace

/// A contact as it stands in this substep.
struct ContactRows::Site {
    std::uint32_t a = 0, b = 0;  // slots
    Vec3d normal = Vec3d::Zero(), tangent1 = Vec3d::Zero(), tangent2 = Vec3d::Zero();
    std::size_t count = 0;
    std::array<Vec3d, kMaxManifoldPoints> arm_a{}, arm_b{};
    std::array<double, kMaxManifoldPoints> gap{};
    std::array<double, kMaxManifoldPoints> coming{};  // speed along the normal after forces
    std::array<double, kMaxManifoldPoints> guess{};
    Vec3d velocity_a = Vec3d::Zero(), velocity_b = Vec3d::Zero();  // before forces
    Vec3d spin_a = Vec3d::Zero(), spin_b = Vec3d::Zero();
    Vec3d rub = Vec3d::Zero();  // friction of the last solve
    double twist = 0.0;
    double friction = 0.0, restitution = 0.0;
    double pull = 0.0;              // acceleration of b relative to a along the normal
    double weight = 0.0;            // of the lighter of the bodies that move, kg
    double load = 0.0;              // impulse of the last solve as it would be in this substep, N s
    Mat3d inverse = Mat3d::Zero();  // of the inertias, summed over both bodies
};

void ContactRows::place(const Bodies& bodies,
                        const Pair& pair,
                        const Contact& contact,
                        const VariantBodies& moving,
                        const RowSystem& system,
                        Site& site) {
    site.a = bodies.awake[pair.a] != 0 ? bodies.solver_slot[pair.a] : 0;
    site.b = bodies.awake[pair.b] != 0 ? bodies.solver_slot[pair.b] : 0;
    const RowBody& p = system.bodies[site.a];
    const RowBody& q = system.bodies[site.b];
    const VariantBody& from_a = moving[site.a];
    const VariantBody& from_b = moving[site.b];
    site.normal = contact.normal.cast<double>();
    site.tangent1 = any_perpendicular(site.normal);
    site.tangent2 = site.normal.cross(site.tangent1);
    site.count = pair.points();
    site.friction = static_cast<double>(contact.grip.friction);
    site.restitution = static_cast<double>(contact.grip.restitution);
    site.velocity_a = from_a.velocity;
    site.velocity_b = from_b.velocity;
    site.spin_a = from_a.spin;
    site.spin_b = from_b.spin;
    const double heaviest = std::max(p.inv_mass, q.inv_mass);
    site.weight = heaviest > 0.0 ? 1.0 / heaviest : 0.0;
    site.inverse = p.inverse + q.inverse;
    // The same point in space for both bodies, wherever they went.
    const Vec3d offset = contact.lead.cast<double>() + from_b.shift - from_a.shift;
    const double follow = static_cast<double>(
        share_of_b(bodies.shape[pair.a], bodies.shape[pair.b], p.inv_mass > 0.0, q.inv_mass > 0.0));
    const Vec3d grow_a = follow * offset;
    const Vec3d grow_b = grow_a - offset;
    for (std::size_t i = 0; i < site.count; ++i) {
        const ContactPoint& point = contact.points[i];
        const Vec3d& arm_a = site.arm_a[i] = point.arm_a.cast<double>() + grow_a;
        const Vec3d& arm_b = site.arm_b[i] = point.arm_b.cast<double>() + grow_b;
        site.gap[i] = static_cast<double>(point.separation) + site.normal.dot(offset) +
                      arm_b.cross(site.normal).dot(from_b.turn) -
                      arm_a.cross(site.normal).dot(from_a.turn);
        site.coming[i] =
            site.normal.dot(q.velocity + q.spin.cross(arm_b) - p.velocity - p.spin.cross(arm_a));
    }
}

/// A load F on points at levers l rights a body that leans by q with the moment
/// F mean(l^2) q / spread: a spring of w^2 = F mean(l^2) I^-1 / spread. As it is judged by the gaps
/// that forces alone would leave at the end of the substep, it has a damper of w^2 h as well.
/// Semi-implicit Euler bears the two up to (w h)^2 = 4/3 (Jury's conditions, see penalty_limit). In
/// a stack the sum over a body's contacts is at most 2 / kRockingMargin (Gershgorin). Whether so
/// soft a spring still rights a body depends on its load: a light body under a heavy one falls.
double ContactRows::spread_of(const Site& site, double h) {
    const auto count = static_cast<double>(site.count);
    Vec3d middle = Vec3d::Zero();
    for (std::size_t i = 0; i < site.count; ++i) {
        middle += site.arm_a[i] / count;
    }
    double along = 0.0;
    double across = 0.0;
    for (std::size_t i = 0; i < site.count; ++i) {
        const double x = site.tangent1.dot(site.arm_a[i] - middle);
        const double y = site.tangent2.dot(site.arm_a[i] - middle);
        along += x * x / count;
        across += y * y / count;
    }
    const double rocking = std::max(along * site.tangent2.dot(site.inverse * site.tangent2),
                                    across * site.tangent1.dot(site.inverse * site.tangent1));
    return std::max(kSpread, kRockingMargin * h * site.load * rocking);
}

/// How a load on the whole manifold presses on its points: the nearer a point will be, the more.
/// Equal parts would not resist a body that tips over.
void ContactRows::share_load(const Site& site, const RowParameters& parameters, ContactSpan& span) {
    const double spread = span.divided ? spread_of(site, parameters.h) : kSpread;
    std::array<double, kMaxManifoldPoints> reach{};
    double least = INFINITY;
    for (std::size_t i = 0; i < site.count; ++i) {
        reach[i] = site.gap[i] + parameters.h * site.coming[i];
        least = std::min(least, reach[i]);
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < site.count; ++i) {
        span.share[i] = std::max(0.0, 1.0 - (reach[i] - least) / spread);
        sum += span.share[i];
    }
    Vec3d middle = Vec3d::Zero();
    for (std::size_t i = 0; i < site.count; ++i) {
        span.share[i] = sum > 0.0 ? span.share[i] / sum : 1.0 / static_cast<double>(site.count);
        middle += span.share[i] * site.arm_a[i];
    }
    for (std::size_t i = 0; i < site.count; ++i) {
        span.lever[i] = site.arm_a[i] - middle;
    }
}

void ContactRows::write(const Bodies& bodies,
                        const ContactGraph& graph,
                        std::uint32_t index,
                        const VariantBodies& moving,
                        const RowParameters& parameters,
                        RowSystem& system) {
    const Pair& pair = graph.pair(index);
    const Contact& contact = graph[index];
    Site site;
    place(bodies, pair, contact, moving, system, site);
    const double shorter =
        contact.substep_s > 0.0F ? parameters.h / static_cast<double>(contact.substep_s) : 0.0;
    const double scale = parameters.guess ? shorter : 0.0;
    for (std::size_t i = 0; i < site.count; ++i) {
        site.guess[i] = scale * static_cast<double>(contact.points[i].impulse);
        site.load += shorter * static_cast<double>(contact.points[i].impulse);
    }
    site.rub = scale * contact.friction.cast<double>();
    site.twist = scale * static_cast<double>(contact.twist);
    const Vec3d gain_a = system.bodies[site.a].velocity - site.velocity_a;
    const Vec3d gain_b = system.bodies[site.b].velocity - site.velocity_b;
    site.pull = site.normal.dot(gain_b - gain_a) / parameters.h;
    ContactSpan span;
    span.contact = index;
    span.first = static_cast<std::uint32_t>(system.size());
    span.points = static_cast<std::uint8_t>(site.count);
    span.divided = parameters.settings->manifold == ManifoldMode::kDivided && site.count > 1;
    span.rubs = site.friction > 0.0;
    span.tangent1 = site.tangent1;
    span.tangent2 = site.tangent2;
    share_load(site, parameters, span);
    if (span.divided) {
        write_divided(site, span, parameters, system);
    } else {
        write_points(site, span, parameters, system);
    }
    spans_.push_back(span);
}

void ContactRows::write_normal(const Site& site,
                               const Vec3d& arm_a,
                               const Vec3d& arm_b,
                               double gap,
                               double lambda,
                               const RowParameters& parameters,
                               RowSystem& system) {
    NewRow row;
    row.a = site.a;
    row.b = site.b;
    row.linear = site.normal;
    row.angular_a = -arm_a.cross(site.normal);
    row.angular_b = arm_b.cross(site.normal);
    row.arm_a = arm_a;
    row.arm_b = arm_b;
    row.role = RowRole::kNormal;
    row.lambda = lambda;
    const std::uint32_t at = system.add(row);
    system.gap[at] = gap;
    stabilise_contact(*parameters.settings, parameters.h, at, system);
    const double before = row.linear.dot(site.velocity_b - site.velocity_a) +
                          row.angular_a.dot(site.spin_a) + row.angular_b.dot(site.spin_b);
    const bool meets = gap + parameters.h * system.speed(at) <= 0.0;
    system.restitution[at] = site.restitution;
    system.pull[at] = site.pull;
    if (parameters.bounces && site.restitution > 0.0 && before < -parameters.restitution_speed &&
        meets) {
        const double up = bounce_speed(before, gap, site.pull, site.restitution, parameters.h);
        system.bias[at] = std::min(system.bias[at], -up);
        system.soft[at] = 0.0;
        system.lambda[at] = 0.0;
    }
}

namespace {

/// Two tangent rows at a place; `normal` is their normal row, `load` the mass that counts where
/// friction does not depend on it.
void write_tangents(NewRow row,
                    const Vec3d& arm_a,
                    const Vec3d& arm_b,
                    const std::array<Vec3d, 2>& tangents,
                    const Vec3d& guess,
                    double limit,
                    FrictionModel model,
                    RowSystem& system) {
    row.rub = true;
    for (std::size_t k = 0; k < 2; ++k) {
        row.linear = tangents[k];
        row.angular_a = -arm_a.cross(tangents[k]);
        row.angular_b = arm_b.cross(tangents[k]);
        row.lambda = tangents[k].dot(guess);
        switch (model) {
            case FrictionModel::kCone:
                row.role = k == 0 ? RowRole::kConeFirst : RowRole::kConeSecond;
                break;
            case FrictionModel::kPyramid:
                row.role = RowRole::kFriction;
                break;
            case FrictionModel::kWeight:
                row.role = RowRole::kBounded;
                row.low = -limit;
                row.high = limit;
                row.lambda = std::clamp(row.lambda, -limit, limit);
                break;
        }
        system.add(row);
    }
}

}  // namespace

void ContactRows::write_points(const Site& site,
                               const ContactSpan& span,
                               const RowParameters& parameters,
                               RowSystem& system) {
    double load = 0.0;
    double levers = 0.0;
    for (std::size_t i = 0; i < site.count; ++i) {
        write_normal(
            site, site.arm_a[i], site.arm_b[i], site.gap[i], site.guess[i], parameters, system);
        load += site.guess[i];
        levers += span.lever[i].squaredNorm();
    }
    if (!span.rubs) {
        return;
    }
    const auto count = static_cast<double>(site.count);
    for (std::size_t i = 0; i < site.count; ++i) {
        NewRow row;
        row.a = site.a;
        row.b = site.b;
        row.normal = span.first + static_cast<std::uint32_t>(i);
        row.friction = site.friction;
        const double part = load > 0.0 ? site.guess[i] / load : 0.0;
        Vec3d guess = part * site.rub;
        if (levers > 0.0 && part > 0.0) {
            guess += (site.twist / levers) * site.normal.cross(span.lever[i]);
        }
        const double limit =
            site.friction * site.weight * parameters.gravity * parameters.h / count;
        write_tangents(row,
                       site.arm_a[i],
                       site.arm_b[i],
                       {site.tangent1, site.tangent2},
                       guess,
                       limit,
                       parameters.settings->friction,
                       system);
    }
}

void ContactRows::write_divided(const Site& site,
                                const ContactSpan& span,
                                const RowParameters& parameters,
                                RowSystem& system) {
    Vec3d arm_a = Vec3d::Zero();
    Vec3d arm_b = Vec3d::Zero();
    double gap = 0.0;
    double load = 0.0;
    double lever = 0.0;
    for (std::size_t i = 0; i < site.count; ++i) {
        arm_a += span.share[i] * site.arm_a[i];
        arm_b += span.share[i] * site.arm_b[i];
        gap += span.share[i] * site.gap[i];
        lever += span.share[i] * span.lever[i].norm();
        load += site.guess[i];
    }
    write_normal(site, arm_a, arm_b, gap, load, parameters, system);
    if (!span.rubs) {
        return;
    }
    NewRow row;
    row.a = site.a;
    row.b = site.b;
    row.normal = span.first;
    row.friction = site.friction;
    const double limit = site.friction * site.weight * parameters.gravity * parameters.h;
    const FrictionModel model = parameters.settings->friction;
    write_tangents(
        row, arm_a, arm_b, {site.tangent1, site.tangent2}, site.rub, limit, model, system);
    row.linear.setZero();
    row.angular_a = -site.normal;
    row.angular_b = site.normal;
    row.friction = site.friction * lever;
    row.lambda = site.twist;
    row.rub = true;
    row.role = model == FrictionModel::kWeight ? RowRole::kBounded : RowRole::kFriction;
    if (model == FrictionModel::kWeight) {
        row.high = limit * lever;
        row.low = -row.high;
        row.lambda = std::clamp(row.lambda, row.low, row.high);
    }
    system.add(row);
}

void ContactRows::store_friction(const RowSystem& system,
                                 const ContactSpan& span,
                                 Contact& contact) {
    Vec3d rub = Vec3d::Zero();
    double twist = 0.0;
    if (span.rubs && span.divided) {
        const std::size_t at = span.first + 1U;
        rub = system.lambda[at] * span.tangent1 + system.lambda[at + 1] * span.tangent2;
        twist = system.lambda[at + 2];
    } else if (span.rubs) {
        for (std::size_t i = 0; i < span.points; ++i) {
            const std::size_t at = span.first + span.points + 2 * i;
            const Vec3d f =
                system.lambda[at] * span.tangent1 + system.lambda[at + 1] * span.tangent2;
            rub += f;
            twist += contact.normal.cast<double>().dot(span.lever[i].cross(f));
        }
    }
    contact.friction = rub.cast<float>();
    contact.twist = static_cast<float>(twist);
}

void ContactRows::store(const RowSystem& system, double h, bool add, ContactGraph& graph) const {
    for (const ContactSpan& span : spans_) {
        Contact& contact = graph[span.contact];
        store_friction(system, span, contact);
        float sum = 0.0F;
        for (std::size_t i = 0; i < span.points; ++i) {
            const double lambda = span.divided ? span.share[i] * system.lambda[span.first]
                                               : system.lambda[span.first + i];
            contact.points[i].impulse = static_cast<float>(lambda);
            sum += contact.points[i].impulse;
        }
        contact.step_impulse = (add ? contact.step_impulse : 0.0F) + sum;
        contact.substep_s = static_cast<float>(h);
        if (!std::isfinite(sum + contact.twist + contact.friction.sum())) {
            // The bodies are stopped; nobody shall inherit it.
            contact.friction.setZero();
            contact.twist = contact.step_impulse = 0.0F;
            for (ContactPoint& point : contact.points) {
                point.impulse = 0.0F;
            }
        }
    }
}

}  // namespace zoned::physics
