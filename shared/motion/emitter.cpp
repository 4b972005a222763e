#include "shared/motion/emitter.h"

#include "shared/core/elementary/elementary.h"
#include "shared/core/rng.h"
#include "shared/math/perpendicular.h"

#include <algorithm>
#include <cmath>

namespace zoned::motion {

namespace {

constexpr double kMostRate = 1e9;

bool finite(const Vec3& v) {
    return v.allFinite();
}

/// A point of the ball of radius 1.
Vec3 in_ball(core::Rng& rng) {
    for (;;) {
        const float x = rng.range(-1.0F, 1.0F);
        const float y = rng.range(-1.0F, 1.0F);
        const float z = rng.range(-1.0F, 1.0F);
        const Vec3 p(x, y, z);
        if (p.squaredNorm() <= 1.0F) {
            return p;
        }
    }
}

/// Unit length, uniform over the cap around `axis`.
Vec3 in_cone(const Vec3& axis, float cosine, core::Rng& rng) {
    for (;;) {
        const float a = rng.range(-1.0F, 1.0F);
        const float b = rng.range(-1.0F, 1.0F);
        const float s = a * a + b * b;
        if (s > 1.0F || s <= 0.0F) {
            continue;
        }
        // s is uniform in (0, 1), and so is the height of a point of a sphere (Archimedes).
        const float height = 1.0F - s * (1.0F - cosine);
        const float across = std::sqrt(std::max(0.0F, 1.0F - height * height) / s);
        const Vec3 u = any_perpendicular(axis);
        const Vec3 v = axis.cross(u);
        return height * axis + across * (a * u + b * v);
    }
}

double seconds_since_start(const Emitter& e, Tick tick, double tick_s) {
    return static_cast<double>(tick - e.start) * tick_s;
}

}  // namespace

std::string unfit(const Emitter& e) {
    if (!(e.rate_hz > 0.0 && e.rate_hz <= kMostRate)) {
        return "rate_hz: must be above 0 and at most 1e9";
    }
    if (!finite(e.position) || !(e.spread >= 0.0F) || !std::isfinite(e.spread)) {
        return "position, spread: must be finite, spread not below 0";
    }
    if (!(std::abs(e.direction.squaredNorm() - 1.0F) < 1e-3F)) {
        return "direction: must have length 1";
    }
    if (!(e.cone_cosine >= -1.0F && e.cone_cosine <= 1.0F)) {
        return "cone_cosine: must be -1..1";
    }
    if (!(e.speed_min >= 0.0F && e.speed_min <= e.speed_max && std::isfinite(e.speed_max))) {
        return "speed_min, speed_max: must be 0 <= min <= max";
    }
    if (!(e.lifetime_min_s > 0.0F && e.lifetime_min_s <= e.lifetime_max_s &&
          std::isfinite(e.lifetime_max_s))) {
        return "lifetime_min_s, lifetime_max_s: must be 0 < min <= max";
    }
    return {};
}

std::uint64_t born_before(const Emitter& e, Tick tick, double tick_s) {
    if (tick <= e.start) {
        return 0;
    }
    const double born = std::ceil(seconds_since_start(e, tick, tick_s) * e.rate_hz);
    const auto most = static_cast<double>(e.most);
    return born >= most ? e.most : static_cast<std::uint64_t>(born);
}

Birth birth_of(const Emitter& e, std::uint64_t index) {
    core::Rng rng(e.seed, index);
    Birth birth;
    birth.at_s = static_cast<double>(index) / e.rate_hz;
    birth.lifetime_s = rng.range(e.lifetime_min_s, e.lifetime_max_s);
    const float speed = rng.range(e.speed_min, e.speed_max);
    birth.velocity = speed * in_cone(e.direction, e.cone_cosine, rng);
    birth.position = e.position;
    if (e.spread > 0.0F) {
        birth.position += e.spread * in_ball(rng);
    }
    return birth;
}

void replay(const CosmeticEmitter& cosmetic,
            Tick tick,
            double tick_s,
            std::vector<CosmeticParticle>& out) {
    const Emitter& e = cosmetic.emitter;
    const double now = seconds_since_start(e, tick, tick_s);
    const std::uint64_t end = born_before(e, tick, tick_s);
    // None that is older than the longest life can be alive.
    const double oldest = (now - static_cast<double>(e.lifetime_max_s)) * e.rate_hz;
    const std::uint64_t begin =
        oldest > 0.0 ? static_cast<std::uint64_t>(std::min(oldest, static_cast<double>(end))) : 0;
    const double k = static_cast<double>(cosmetic.drag);
    const Vec3d g = cosmetic.gravity.cast<double>();
    const Vec3d wind = cosmetic.wind.cast<double>();
    for (std::uint64_t i = begin; i < end; ++i) {
        const Birth birth = birth_of(e, i);
        const double t = std::max(0.0, now - birth.at_s);
        if (t >= static_cast<double>(birth.lifetime_s)) {
            continue;
        }
        const Vec3d v0 = birth.velocity.cast<double>();
        // x = x0 + (wind + g / k) t + (v0 - wind - g / k) (1 - e^-kt) / k, in terms that stay
        // finite where k vanishes: a = (1 - e^-kt) / k, b = (t - a) / k.
        const double gone = k > 1e-6 ? -elementary::expm1(-k * t) : k * t;
        const double a = k > 1e-6 ? gone / k : t;
        const double b = k > 1e-6 ? (t - a) / k : 0.5 * t * t;
        CosmeticParticle spark;
        spark.index = i;
        spark.position = birth.position + Vec3d(wind * t + (v0 - wind) * a + g * b).cast<float>();
        spark.velocity = Vec3d(wind + (v0 - wind) * (1.0 - gone) + g * a).cast<float>();
        spark.age_share = static_cast<float>(t / static_cast<double>(birth.lifetime_s));
        out.push_back(spark);
    }
}

}  // namespace zoned::motion
