#include "shared/motion/burst.h"

#include <cmath>

namespace zoned::motion {

namespace {

/// All particles of a burst are born in the same step, whatever the tick's length.
constexpr double kBurstRate_hz = 1e9;
/// A slower velocity has no meaningful direction.
constexpr float kStill_mps = 1e-6F;

}  // namespace

std::string unfit(const BurstKind& kind) {
    if (!(kind.slowest >= 0.0F && kind.slowest <= 1.0F)) {
        return "slowest: must be 0..1";
    }
    return unfit(emitter_of(kind, Burst()));
}

Emitter emitter_of(const BurstKind& kind, const Burst& burst) {
    const float speed = burst.velocity.norm();
    Emitter emitter;
    emitter.seed = burst.seed;
    emitter.start = burst.start;
    emitter.rate_hz = kBurstRate_hz;
    emitter.most = burst.count;
    emitter.position = burst.position;
    emitter.spread = kind.spread;
    emitter.direction = speed > kStill_mps ? Vec3(burst.velocity / speed) : Vec3(Vec3::UnitY());
    emitter.cone_cosine = kind.cone_cosine;
    emitter.speed_min = kind.slowest * speed;
    emitter.speed_max = speed;
    emitter.lifetime_min_s = kind.lifetime_min_s;
    emitter.lifetime_max_s = kind.lifetime_max_s;
    return emitter;
}

}  // namespace zoned::motion
