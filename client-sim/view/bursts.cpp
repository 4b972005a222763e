#include "client-sim/view/bursts.h"

#include <algorithm>
#include <cmath>

namespace zoned::view {

namespace {

/// Far above what worlds hold, far below where floats end.
constexpr float kFarthest_m = 1e6F;
constexpr float kFastest_mps = 1e5F;

bool is_within(const std::vector<float>& numbers, float limit) {
    return numbers.size() == 3 &&
           std::ranges::all_of(numbers, [limit](float n) { return std::abs(n) <= limit; });
}

}  // namespace

Bursts::BurstOutcome Bursts::apply(const wire::EventMessage& event, Tick now) {
    wire::ParticleBurstMessage update;
    if (!wire::decode_message(wire::bytes_of(event.payload), update) ||
        update.system >= world_->cosmetics.size() || !world_->cosmetics[update.system].burst ||
        update.count == 0 || update.count > motion::kMostInCosmeticBurst || event.tick < 0 ||
        !is_within(update.position, kFarthest_m) || !is_within(update.velocity, kFastest_mps)) {
        return BurstOutcome::kMalformed;
    }
    const CosmeticInfo& system = world_->cosmetics[update.system];
    motion::Burst burst;
    burst.seed = update.seed;
    burst.start = static_cast<Tick>(event.tick);
    burst.position = {update.position[0], update.position[1], update.position[2]};
    burst.velocity = {update.velocity[0], update.velocity[1], update.velocity[2]};
    burst.count = update.count;
    const auto full = [&] {
        return live_.size() >= kMost || particles_ + burst.count > kMostAlive;
    };
    if (full()) {
        forget_over(now);
    }
    if (full()) {
        return BurstOutcome::kNoRoom;
    }
    live_.emplace_back(system.air).emitter = motion::emitter_of(*system.burst, burst);
    particles_ += burst.count;
    return BurstOutcome::kTaken;
}

void Bursts::forget_over(Tick now) {
    std::erase_if(live_, [&](const motion::CosmeticEmitter& burst) {
        const motion::Emitter& e = burst.emitter;
        // A tick more: a particle is born within the first step.
        const double age_s = static_cast<double>(now - e.start - 1) * world_->tick_s;
        const bool over = age_s > static_cast<double>(e.lifetime_max_s);
        particles_ -= over ? e.most : 0;
        return over;
    });
}

void Bursts::replay(Tick tick, std::vector<motion::CosmeticParticle>& out) const {
    for (const motion::CosmeticEmitter& burst : live_) {
        motion::replay(burst, tick, world_->tick_s, out);
    }
}

void Bursts::clear() {
    live_.clear();
    particles_ = 0;
}

}  // namespace zoned::view
