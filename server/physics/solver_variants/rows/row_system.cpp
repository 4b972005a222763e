#include "server/physics/solver_variants/rows/row_system.h"

#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

void RowSystem::clear() {
    bodies.assign(1, RowBody());
    clear_rows();
}

void RowSystem::clear_rows() {
    for (auto* column : {&a, &b, &normal, &order}) {
        column->clear();
    }
    for (auto* column : {&friction,
                         &low,
                         &high,
                         &bias,
                         &soft,
                         &response,
                         &split,
                         &kind_split,
                         &lambda,
                         &restitution,
                         &pull,
                         &gap}) {
        column->clear();
    }
    shape.clear();
    role.clear();
    undoes.clear();
    rub.clear();
    arm_a.clear();
    arm_b.clear();
    groups.clear();
}

std::uint32_t RowSystem::add_body(const RowBody& body) {
    bodies.push_back(body);
    return static_cast<std::uint32_t>(bodies.size() - 1);
}

std::uint32_t RowSystem::add(const NewRow& row) {
    RowShape s;
    s.linear = row.linear;
    s.angular_a = row.angular_a;
    s.angular_b = row.angular_b;
    const RowBody& p = bodies[row.a];
    const RowBody& q = bodies[row.b];
    s.turn_a = p.inverse * row.angular_a;
    s.turn_b = q.inverse * row.angular_b;
    a.push_back(row.a);
    b.push_back(row.b);
    shape.push_back(s);
    role.push_back(row.role);
    normal.push_back(row.normal);
    friction.push_back(row.friction);
    low.push_back(row.role == RowRole::kNormal ? 0.0 : row.low);
    high.push_back(row.role == RowRole::kNormal ? kUnbounded : row.high);
    bias.push_back(0.0);
    soft.push_back(0.0);
    response.push_back((p.inv_mass + q.inv_mass) * row.linear.squaredNorm() +
                       row.angular_a.dot(s.turn_a) + row.angular_b.dot(s.turn_b));
    split.push_back(0.0);
    kind_split.push_back(0.0);
    lambda.push_back(row.lambda);
    restitution.push_back(0.0);
    pull.push_back(0.0);
    gap.push_back(0.0);
    undoes.push_back(0);
    rub.push_back(row.rub ? 1 : 0);
    arm_a.push_back(row.arm_a);
    arm_b.push_back(row.arm_b);
    return static_cast<std::uint32_t>(a.size() - 1);
}

void RowSystem::finish(std::uint32_t shuffle) {
    share_masses();
    weigh_cones();
    order.clear();
    for (const std::uint8_t friction_rows : {0, 1}) {
        for (std::uint32_t i = 0; i < size(); ++i) {
            if (rub[i] == friction_rows && role[i] != RowRole::kConeSecond) {
                order.push_back(i);
            }
        }
    }
    if (shuffle != 0) {
        core::Rng rng(shuffle);
        for (std::size_t i = order.size(); i > 1; --i) {
            std::swap(order[i - 1], order[rng.below(static_cast<std::uint32_t>(i))]);
        }
    }
    if (groups.empty() && size() > 0) {
        groups.push_back({0, static_cast<std::uint32_t>(size())});
    }
}

/// A body with n rows counts as n bodies of an n-th of its mass, one for each row (R. Tonge,
/// F. Benevolenski, A. Voroshilov, "Mass splitting for jitter-free parallel rigid body simulation",
/// ACM TOG 31, 2012). With D the diagonal of these larger responses, J M^-1 J^T <= D: for any x
/// (sum over a body's n rows of J_i^T x_i)^2 <= n sum (J_i^T x_i)^2 in the metric of M^-1.
void RowSystem::share_masses() {
    for (auto* counts : {&rows_of_, &frictions_of_}) {
        counts->assign(bodies.size(), 0);
    }
    for (std::size_t i = 0; i < size(); ++i) {
        std::vector<std::uint32_t>& counts = rub[i] != 0 ? frictions_of_ : rows_of_;
        ++counts[a[i]];
        ++counts[b[i]];
    }
    for (std::size_t i = 0; i < size(); ++i) {
        const RowShape& s = shape[i];
        const double squared = s.linear.squaredNorm();
        const double of_a = bodies[a[i]].inv_mass * squared + s.angular_a.dot(s.turn_a);
        const double of_b = bodies[b[i]].inv_mass * squared + s.angular_b.dot(s.turn_b);
        const std::vector<std::uint32_t>& counts = rub[i] != 0 ? frictions_of_ : rows_of_;
        kind_split[i] = counts[a[i]] * of_a + counts[b[i]] * of_b;
        split[i] = (rows_of_[a[i]] + frictions_of_[a[i]]) * of_a +
                   (rows_of_[b[i]] + frictions_of_[b[i]]) * of_b;
    }
}

/// Both rows of a cone take steps of one length, that of the stiffest direction of the two: only
/// then does a fixed point of step and projection oppose the slip.
void RowSystem::weigh_cones() {
    for (std::size_t i = 0; i + 1 < size(); ++i) {
        if (role[i] != RowRole::kConeFirst) {
            continue;
        }
        const double mean = 0.5 * (response[i] + response[i + 1]);
        const double half = 0.5 * (response[i] - response[i + 1]);
        const double mixed = coupling(i, i + 1);
        response[i] = response[i + 1] = mean + std::sqrt(half * half + mixed * mixed);
        split[i] = split[i + 1] = std::max(split[i], split[i + 1]);
        kind_split[i] = kind_split[i + 1] = std::max(kind_split[i], kind_split[i + 1]);
    }
}

void RowSystem::apply_guess() {
    for (std::size_t i = 0; i < size(); ++i) {
        if (lambda[i] != 0.0) {
            push(i, lambda[i]);
        }
    }
}

double RowSystem::coupling(std::size_t i, std::size_t j) const {
    const RowShape& s = shape[i];
    const RowShape& t = shape[j];
    const double along = s.linear.dot(t.linear);
    double sum = 0.0;
    if (a[i] == a[j]) {
        sum += bodies[a[i]].inv_mass * along + s.angular_a.dot(t.turn_a);
    }
    if (b[i] == b[j]) {
        sum += bodies[b[i]].inv_mass * along + s.angular_b.dot(t.turn_b);
    }
    if (a[i] == b[j]) {
        sum += s.angular_a.dot(t.turn_b) - bodies[a[i]].inv_mass * along;
    }
    if (b[i] == a[j]) {
        sum += s.angular_b.dot(t.turn_a) - bodies[b[i]].inv_mass * along;
    }
    return sum;
}

}  // namespace zoned::physics
