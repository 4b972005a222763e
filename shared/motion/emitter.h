// Emitter: the position and time at which particles are born, from a seed; and the replay of
// cosmetic particles.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/math/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::motion {

/// Particle number i of an emitter is a function of the seed and i alone. The emitter determines
/// all of its particles, in any order, without a history. SI units; directions have unit length.
struct Emitter {
    std::uint64_t seed = 0;
    Tick start = 0;                   ///< the first particle is born in the step from here
    double rate_hz = 10.0;            ///< particles per second, > 0; large for a burst
    std::uint64_t most = UINT64_MAX;  ///< particles in all
    Vec3 position = Vec3::Zero();     ///< m
    float spread = 0.0F;              ///< particles begin within a ball of this radius, m
    Vec3 direction = Vec3::UnitY();   ///< the cone's axis
    float cone_cosine = 1.0F;         ///< of the angle between axis and rim: 1 a ray, -1 all round
    float speed_min = 1.0F;           ///< m/s, uniform in [min, max]
    float speed_max = 1.0F;
    float lifetime_min_s = 1.0F;  ///< > 0, uniform in [min, max]
    float lifetime_max_s = 1.0F;
};

/// Reason to refuse an emitter ("rate_hz: must be above 0 and at most 1e9"); empty: it is fit.
std::string unfit(const Emitter& emitter);

/// Particles born before `tick`, that is, in the steps from `start` up to and without it. Grows
/// with the tick by rate times `tick_s` (the length of a tick, s), rounded so that the sum is
/// right.
std::uint64_t born_before(const Emitter& emitter, Tick tick, double tick_s);

struct Birth {
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    float lifetime_s = 0.0F;
    double at_s = 0.0;  ///< after the emitter's start
};

/// Particle number `index`. Directions are uniform over the cone: a point of a disc by rejection
/// gives both angles without trigonometry (Marsaglia, "Choosing a point from the surface of a
/// sphere", Ann. Math. Stat. 43, 1972), so all computers agree.
Birth birth_of(const Emitter& emitter, std::uint64_t index);

/// A cosmetic system: smoke, sparks, rain, about which no rule ever asks. The server neither
/// simulates nor sends its particles. It sends this description once, and every client computes the
/// same particles for any tick.
struct CosmeticEmitter {
    Emitter emitter;
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);  ///< m/s2
    float drag = 0.0F;                           ///< 1/s, >= 0, relative to the wind
    Vec3 wind = Vec3::Zero();                    ///< m/s
};

/// A particle as a client draws it.
struct CosmeticParticle {
    std::uint64_t index = 0;
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    float age_share = 0.0F;  ///< 0 at birth, 1 at the end
};

/// All particles alive at `tick`, in the order of their birth, appended to `out`. The motion is the
/// exact solution of v' = g - drag (v - wind), so nothing is stepped: a client that comes late, or
/// looks away, computes the present alone. It costs time in proportion to the particles alive.
void replay(const CosmeticEmitter& cosmetic,
            Tick tick,
            double tick_s,
            std::vector<CosmeticParticle>& out);

}  // namespace zoned::motion
