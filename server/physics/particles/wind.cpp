#include "server/physics/particles/wind.h"

#include "kernels/include/particle.h"
#include "shared/core/rng.h"

#include <cmath>

namespace zoned::physics {

std::string unfit(const Wind& wind) {
    if (!wind.uniform.allFinite()) {
        return "uniform: must be finite";
    }
    if (!(wind.gust_speed >= 0.0F) || !std::isfinite(wind.gust_speed)) {
        return "gust_speed: must be finite and not below 0";
    }
    if (!(wind.gust_size > 0.0F) || !std::isfinite(wind.gust_size)) {
        return "gust_size: must be finite and above 0";
    }
    if (!wind.gusts.empty() && wind.gusts.size() != kernels::ZK_GUST_CORNERS) {
        return "gusts: " + std::to_string(wind.gusts.size()) + " velocities instead of " +
               std::to_string(static_cast<int>(kernels::ZK_GUST_CORNERS));
    }
    for (const Vec3& gust : wind.gusts) {
        if (!gust.allFinite()) {
            return "gusts: must be finite";
        }
    }
    return {};
}

std::vector<float> gust_table(const Wind& wind) {
    if (wind.gusts.empty() && wind.gust_speed <= 0.0F) {
        return {};
    }
    constexpr std::size_t kCorners = kernels::ZK_GUST_CORNERS;
    std::vector<float> table(3 * kCorners);
    core::Rng rng(wind.seed);
    for (std::size_t i = 0; i < kCorners; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            table[axis * kCorners + i] = wind.gusts.empty()
                                             ? rng.range(-wind.gust_speed, wind.gust_speed)
                                             : wind.gusts[i][static_cast<Eigen::Index>(axis)];
        }
    }
    return table;
}

Vec3 gust_origin(const Wind& wind, double time_s) {
    const double period =
        static_cast<double>(wind.gust_size) * static_cast<double>(kernels::ZK_GUST_CELLS);
    Vec3 origin;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        origin[axis] =
            static_cast<float>(std::fmod(static_cast<double>(wind.uniform[axis]) * time_s, period));
    }
    return origin;
}

}  // namespace zoned::physics
