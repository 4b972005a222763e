#include "client-sim/view/cosmetics.h"

#include "shared/core/utf8.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace zoned::view {

namespace {

/// Alive at a time, in all systems together: as many as a config may set, 64 systems of a million.
constexpr double kMostAlive = 64e6;

using Numbers = std::vector<float>;

bool is_vector(const Numbers& numbers) {
    return numbers.size() == 3 &&
           std::ranges::all_of(numbers, [](float n) { return std::abs(n) <= 1e6F; });
}

Vec3 vector_of(const Numbers& numbers) {
    return {numbers[0], numbers[1], numbers[2]};
}

motion::Emitter read_emitter(const wire::EmitterMessage& from) {
    motion::Emitter e;
    e.seed = from.seed;
    e.start = static_cast<Tick>(from.start_tick);
    e.rate_hz = from.rate_hz;
    e.most = from.most > 0 ? from.most : UINT64_MAX;
    e.position = vector_of(from.position);
    e.spread = from.spread;
    e.direction = vector_of(from.direction);
    e.cone_cosine = from.cone_cosine;
    e.speed_min = from.speed_min;
    e.speed_max = from.speed_max;
    e.lifetime_min_s = from.lifetime_min_s;
    e.lifetime_max_s = from.lifetime_max_s;
    return e;
}

motion::BurstKind read_burst(const wire::BurstKindMessage& from) {
    return {from.cone_cosine, from.slowest, from.spread, from.lifetime_min_s, from.lifetime_max_s};
}

}  // namespace

std::string wrong_with_cosmetics(const wire::WorldDescriptionMessage& description) {
    double alive = 0.0;
    for (const wire::CosmeticSystemMessage& system : description.cosmetics) {
        if (!is_vector(system.gravity) || !is_vector(system.wind) ||
            !(system.drag >= 0.0F && system.drag <= 1e6F)) {
            return "malformed cosmetic particle system";
        }
        if (system.burst && !motion::unfit(read_burst(*system.burst)).empty()) {
            return "malformed burst of a cosmetic particle system";
        }
        for (const wire::EmitterMessage& e : system.emitters) {
            if (!is_vector(e.position) || !is_vector(e.direction) || e.start_tick < 0 ||
                !motion::unfit(read_emitter(e)).empty()) {
                return "malformed particle emitter";
            }
            const double most = e.most > 0 ? static_cast<double>(e.most) : 1e18;
            alive += std::min(most, e.rate_hz * static_cast<double>(e.lifetime_max_s));
        }
    }
    return alive <= kMostAlive ? std::string() : "more cosmetic particles than a client can replay";
}

std::vector<CosmeticInfo> read_cosmetics(const wire::WorldDescriptionMessage& description) {
    std::vector<CosmeticInfo> out;
    for (const wire::CosmeticSystemMessage& from : description.cosmetics) {
        CosmeticInfo& system = out.emplace_back();
        system.name = core::is_clean_utf8(from.name) ? from.name : "?";
        system.air.gravity = vector_of(from.gravity);
        system.air.drag = from.drag;
        system.air.wind = vector_of(from.wind);
        for (const wire::EmitterMessage& emitter : from.emitters) {
            system.emitters.emplace_back(system.air).emitter = read_emitter(emitter);
        }
        if (from.burst) {
            system.burst = read_burst(*from.burst);
        }
    }
    return out;
}

}  // namespace zoned::view
