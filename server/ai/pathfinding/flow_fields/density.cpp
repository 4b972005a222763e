#include "server/ai/pathfinding/flow_fields/density.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// Densities below this are none, agents per m2.
constexpr float kNone = 0.01F;
constexpr int kLeastChange = 2;  ///< sixteenths

}  // namespace

Density::Density(const GridMap& map, const DensitySettings& settings)
    : settings_(settings),
      width_(map.width()),
      height_(map.height()),
      map_(map),
      blocks_across_(
          static_cast<std::uint32_t>((map.width() + settings.block - 1) / settings.block)),
      crowding_(map.places(), 0) {
    ZONED_ASSERT(settings.cell_m > 0.0F && settings.jam_per_m2 > 0.0F &&
                     settings.least_speed > 0.0F && settings.remember < 1.0F && settings.block > 0,
                 "densities and cells are positive");
    const std::size_t blocks =
        std::size_t{blocks_across_} *
        static_cast<std::size_t>((map.height() + settings.block - 1) / settings.block);
    density_.assign(blocks, 0.0F);
    count_.assign(blocks, 0);
    of_block_.assign(blocks, 0);
}

std::uint32_t Density::block_of(Place p) const {
    const Cell c = map_.cell(p);
    const auto side = static_cast<std::uint32_t>(settings_.block);
    return c.y / side * blocks_across_ + c.x / side;
}

/// At least one cell: an agent on blocked ground counts beside it.
float Density::passable_m2(std::uint32_t block) const {
    int cells = 0;
    for_each_cell(block, [&](Place p) { cells += map_.passable(p) ? 1 : 0; });
    return static_cast<float>(std::max(cells, 1)) * settings_.cell_m * settings_.cell_m;
}

void Density::set(std::uint32_t block, Crowding crowding) {
    of_block_[block] = crowding;
    for_each_cell(block, [&](Place p) {
        crowding_[p] = crowding;
        changed_.push_back(p);
    });
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

void Density::look(const steering::CrowdAgents& agents) {
    look(agents.x, agents.z);
}

void Density::look(std::span<const float> x, std::span<const float> z) {
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Place p = place_of(x[i], z[i]);
        if (p == kNoPlace) {
            continue;
        }
        const std::uint32_t block = block_of(p);
        if (density_[block] <= 0.0F && count_[block] == 0) {
            known_.push_back(block);
        }
        ++count_[block];
    }
    changed_.clear();
    std::size_t kept = 0;
    for (const std::uint32_t block : known_) {
        const float now = static_cast<float>(count_[block]) / passable_m2(block);
        const float mean = now + settings_.remember * (density_[block] - now);
        const bool gone = count_[block] == 0 && mean < kNone;
        density_[block] = gone ? 0.0F : mean;
        count_[block] = 0;
        const int wanted = crowding_of(density_[block]);
        const int off = std::abs(wanted - static_cast<int>(of_block_[block]));
        if (off > 0 && (gone || off >= std::max(kLeastChange, of_block_[block] / 8))) {
            set(block, static_cast<Crowding>(wanted));
        }
        if (!gone) {
            known_[kept++] = block;
        }
    }
    known_.resize(kept);
}

void Density::write(std::vector<SavedCrowds::SavedBlock>& blocks) const {
    for (const std::uint32_t block : known_) {
        blocks.push_back({block, density_[block], of_block_[block]});
    }
}

bool Density::load(std::span<const SavedCrowds::SavedBlock> blocks) {
    const float most = static_cast<float>(kPerStep) * (1.0F / settings_.least_speed - 1.0F) + 1.0F;
    for (const SavedCrowds::SavedBlock& b : blocks) {
        if (b.block >= density_.size() || density_[b.block] > 0.0F || !(b.density > 0.0F) ||
            !(static_cast<float>(b.crowding) <= most)) {
            return false;
        }
        known_.push_back(b.block);
        density_[b.block] = b.density;
        set(b.block, b.crowding);
    }
    changed_.clear();
    return true;
}

}  // namespace zoned::ai::pathfinding
