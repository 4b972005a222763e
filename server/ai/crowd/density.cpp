#include "server/ai/crowd/density.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::crowd {

using navigation::Cell;
using navigation::kNoPlace;
using navigation::Place;

namespace {

/// Densities below this are none, agents per m2.
constexpr float kNone = 0.01F;
constexpr int kLeastChange = 2;  ///< sixteenths

}  // namespace

Density::Density(const navigation::GridMap& map, const DensitySettings& settings)
    : settings_(settings),
      width_(map.width()),
      height_(map.height()),
      map_(map),
      density_(map.places(), 0.0F),
      count_(map.places(), 0),
      crowding_(map.places(), 0) {
    ZONED_ASSERT(settings.cell_m > 0.0F && settings.jam_per_m2 > 0.0F &&
                     settings.least_speed > 0.0F && settings.remember < 1.0F,
                 "densities and cells are positive");
}

Place Density::place_of(float x, float z) const {
    const float cx = std::floor((x - settings_.x0) / settings_.cell_m);
    const float cz = std::floor((z - settings_.z0) / settings_.cell_m);
    if (!(cx >= 0.0F && cx < static_cast<float>(width_) && cz >= 0.0F &&
          cz < static_cast<float>(height_))) {
        return kNoPlace;
    }
    return map_.place({static_cast<std::uint16_t>(cx), static_cast<std::uint16_t>(cz)});
}

Crowding Density::crowding_of(float density) const {
    const float speed = std::max(settings_.least_speed, 1.0F - density / settings_.jam_per_m2);
    return static_cast<Crowding>(static_cast<float>(kPerStep) * (1.0F / speed - 1.0F) + 0.5F);
}

void Density::look(const CrowdAgents& agents) {
    for (std::size_t i = 0; i < agents.size(); ++i) {
        const Place p = place_of(agents.x[i], agents.z[i]);
        if (p == kNoPlace) {
            continue;
        }
        if (density_[p] <= 0.0F && count_[p] == 0) {
            known_.push_back(p);
        }
        ++count_[p];
    }
    changed_.clear();
    const float per_m2 = 1.0F / (settings_.cell_m * settings_.cell_m);
    std::size_t kept = 0;
    for (const Place p : known_) {
        const float now = static_cast<float>(count_[p]) * per_m2;
        const float mean = now + settings_.remember * (density_[p] - now);
        const bool gone = count_[p] == 0 && mean < kNone;
        density_[p] = gone ? 0.0F : mean;
        count_[p] = 0;
        const int wanted = crowding_of(density_[p]);
        const int off = std::abs(wanted - static_cast<int>(crowding_[p]));
        if (off > 0 && (gone || off >= std::max(kLeastChange, crowding_[p] / 8))) {
            crowding_[p] = static_cast<Crowding>(wanted);
            changed_.push_back(p);
        }
        if (!gone) {
            known_[kept++] = p;
        }
    }
    known_.resize(kept);
}

}  // namespace zoned::ai::crowd
