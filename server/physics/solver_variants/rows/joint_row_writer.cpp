#include "server/physics/solver_variants/rows/joint_row_writer.h"

#include "server/physics/solver_variants/rows/stabilise.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// The implicit spring of stabilise.h with the joint's own constants.
void spring_row(const SpringConstants& spring, double h, std::size_t i, RowSystem& system) {
    const auto [k, c] = spring;
    const double both = h * (c + h * k);
    if (both > 0.0) {
        system.soft[i] = 1.0 / both;
        system.bias[i] = system.gap[i] * h * k / both;
    } else {
        system.low[i] = system.high[i] = 0.0;
    }
}

}  // namespace

JointPose pose_of(const Bodies& bodies,
                  const VariantBodies& moving,
                  std::uint32_t row,
                  const Vec3& origin) {
    if (row == kNoIndex) {
        return {-origin, Mat3::Identity()};
    }
    const std::uint32_t slot = bodies.awake[row] != 0 ? bodies.solver_slot[row] : 0;
    const Vec3 start = bodies.position[row] - origin;
    if (slot == 0) {
        return {start, bodies.rotation[row]};
    }
    return {start + moving[slot].shift.cast<float>(), moving[slot].orientation.toRotationMatrix()};
}

void JointRowWriter::write(const Bodies& bodies,
                           const JointTable& table,
                           std::uint32_t index,
                           const VariantBodies& moving,
                           const RowParameters& parameters,
                           RowSystem& system) {
    const JointEntry& entry = table[index];
    const Vec3 origin = bodies.position[entry.b];
    JointRows rows;
    write_rows(entry.joint,
               pose_of(bodies, moving, entry.a, origin),
               pose_of(bodies, moving, entry.b, origin),
               rows);
    const double h = parameters.h;
    const double scale =
        parameters.guess && entry.substep_s > 0.0F ? h / static_cast<double>(entry.substep_s) : 0.0;
    spans_.push_back(
        {index, static_cast<std::uint32_t>(system.size()), static_cast<std::uint32_t>(rows.count)});
    for (std::size_t i = 0; i < rows.count; ++i) {
        const JointRow& from = rows.rows[i];
        NewRow row;
        row.a = entry.a != kNoIndex && bodies.awake[entry.a] != 0 ? bodies.solver_slot[entry.a] : 0;
        row.b = bodies.awake[entry.b] != 0 ? bodies.solver_slot[entry.b] : 0;
        row.linear = from.linear.cast<double>();
        row.angular_a = from.angular_a.cast<double>();
        row.angular_b = from.angular_b.cast<double>();
        if (from.kind == RowKind::kLimit) {
            row.low = 0.0;
        } else if (from.kind == RowKind::kMotor) {
            row.high = static_cast<double>(from.most) * h;
            row.low = -row.high;
        }
        row.lambda = std::clamp(scale * static_cast<double>(entry.impulse[i]), row.low, row.high);
        const std::uint32_t at = system.add(row);
        system.gap[at] = static_cast<double>(from.error);
        if (from.kind == RowKind::kMotor) {
            system.bias[at] = -static_cast<double>(from.target);
        } else if (from.kind == RowKind::kSpring) {
            const double inv_mass = system.bodies[row.a].inv_mass + system.bodies[row.b].inv_mass;
            spring_row(spring_constants(*from.spring, inv_mass), h, at, system);
        } else {
            stabilise_joint(*parameters.settings, h, from.kind == RowKind::kLimit, at, system);
        }
    }
}

void JointRowWriter::store(const RowSystem& system, double h, int count, JointTable& table) const {
    for (const RowSpan& span : spans_) {
        JointEntry& entry = table[span.joint];
        Vec3d force = Vec3d::Zero();
        double sum = 0.0;
        for (std::size_t i = 0; i < span.count; ++i) {
            const double lambda = system.lambda[span.first + i];
            entry.impulse[i] = static_cast<float>(lambda);
            force += (lambda / h) * system.shape[span.first + i].linear;
            sum += lambda;
        }
        if (!std::isfinite(sum)) {
            entry.impulse.fill(0.0F);  // the bodies are stopped; nobody shall inherit it
        }
        entry.substep_s = static_cast<float>(h);
        const auto size = static_cast<float>(force.norm());
        entry.force_n =
            count == 1 ? size : entry.force_n + (size - entry.force_n) / static_cast<float>(count);
    }
}

}  // namespace zoned::physics
