// Wind: a uniform wind with gusts that drift along with it.
#pragma once

#include "shared/math/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::physics {

/// Gusts are smooth noise (Perlin, "An image synthesizer", SIGGRAPH 1985): a lattice of velocities
/// from a seed or given, interpolated smoothly. It repeats after eight cells along each axis. The
/// lattice moves with the uniform wind: turbulence that is frozen while it passes (Taylor, "The
/// spectrum of turbulence", 1938).
struct Wind {
    Vec3 uniform = Vec3::Zero();  ///< m/s
    float gust_speed = 0.0F;  ///< largest part of a corner's gust along each axis, m/s; 0: no gusts
    float gust_size = 8.0F;   ///< m between corners, > 0
    std::uint64_t seed = 0;
    /// Instead of the seed's: 8 x 8 x 8 velocities (m/s), x running fastest, then y. Or empty.
    std::vector<Vec3> gusts;
};

/// Why a wind is refused; empty: it is not.
std::string unfit(const Wind& wind);

/// The lattice as the kernels want it: all x, then all y, then all z. Empty where there are no
/// gusts.
std::vector<float> gust_table(const Wind& wind);

/// Where the lattice begins after `time_s`, m; kept within one period, so that it stays exact.
Vec3 gust_origin(const Wind& wind, double time_s);

}  // namespace zoned::physics
