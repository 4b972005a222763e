// Burst: particles emitted at once, from the settings of a system and those of one burst.
#pragma once

#include "shared/motion/emitter.h"

#include <cstdint>
#include <string>

namespace zoned::motion {

/// Most particles of one burst; a client refuses to replay more.
inline constexpr std::uint32_t kMostInCosmeticBurst = 1000;

/// Settings common to all bursts of a particle system. SI units.
struct BurstKind {
    float cone_cosine = 0.5F;  ///< of the angle between the velocity and the rim of the cone, -1..1
    float slowest = 0.5F;      ///< speeds are uniform in [slowest, 1] times the speed, 0..1
    float spread = 0.0F;       ///< particles begin within a ball of this radius, m
    float lifetime_min_s = 1.0F;  ///< > 0, uniform in [min, max]
    float lifetime_max_s = 1.0F;
};

/// One burst: a few dozen bytes from which all sides compute the same particles.
struct Burst {
    std::uint64_t seed = 0;
    Tick start = 0;                ///< all particles are born in the step from here
    Vec3 position = Vec3::Zero();  ///< m
    Vec3 velocity = Vec3::Zero();  ///< m/s: the cone's axis and the highest speed; zero: upwards
    std::uint32_t count = 0;
};

/// Why a kind is refused ("slowest: must be 0..1"); empty: it is not.
std::string unfit(const BurstKind& kind);

/// The emitter of a burst; fit (see unfit(Emitter)) where the kind is fit and position and velocity
/// are finite. Server and clients call this one function, so that they agree bit for bit.
Emitter emitter_of(const BurstKind& kind, const Burst& burst);

}  // namespace zoned::motion
