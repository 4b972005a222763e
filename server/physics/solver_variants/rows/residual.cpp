#include "server/physics/solver_variants/rows/residual.h"

#include <cmath>

namespace zoned::physics {

namespace {

double squared_residual(const RowSystem& s, std::size_t i) {
    const double d = s.response[i] + s.soft[i];
    if (!(d > 0.0)) {
        return 0.0;
    }
    const double x = s.lambda[i] - s.excess(i) / d;
    if (s.role[i] == RowRole::kConeFirst) {
        const double limit = s.friction_limit(i);
        double u = x;
        double v = s.lambda[i + 1] - s.excess(i + 1) / d;
        project_on_disc(limit, u, v);
        u -= s.lambda[i];
        v -= s.lambda[i + 1];
        return d * d * (u * u + v * v);
    }
    double low = s.low[i];
    double high = s.high[i];
    if (s.role[i] == RowRole::kFriction) {
        high = s.friction_limit(i);
        low = -high;
    }
    const double off = d * (s.lambda[i] - std::min(std::max(x, low), high));
    return off * off;
}

}  // namespace

double residual(const RowSystem& system, const RowGroup& group) {
    double sum = 0.0;
    for (std::size_t i = group.first; i < group.end; ++i) {
        sum += system.role[i] == RowRole::kConeSecond ? 0.0 : squared_residual(system, i);
    }
    return group.end > group.first ? std::sqrt(sum / static_cast<double>(group.end - group.first))
                                   : 0.0;
}

double residual(const RowSystem& system) {
    return residual(system, {0, static_cast<std::uint32_t>(system.size())});
}

}  // namespace zoned::physics
