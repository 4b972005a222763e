#include "server/ai/pathfinding/pheromones/pheromone_trails.h"

#include <algorithm>
#include <bit>

namespace zoned::ai::pathfinding {

namespace {

/// The preference of walkers for a direction, by eighths of a turn away from ahead.
constexpr std::array<float, 5> kLiking{1.0F, 0.6F, 0.15F, 0.05F, 0.02F};
/// The weight of a cell without scent; a cell that smells as strong as here has 1.
constexpr float kUnscented = 0.02F;
constexpr float kMostRatio = 1e6F;
/// A cell whose mark is one step younger is at least this many times as attractive.
constexpr float kStepRatio = 1.4F;
/// Scent that is weaker is none.
constexpr float kLeastScent = 1e-4F;
/// More passages than these do not count, fewer are none.
constexpr float kMostPassages = 1e4F;
constexpr float kLeastPassages = 0.01F;

/// The term of a cell in the hash; a sum of terms does not depend on their order.
std::uint64_t term(const ScentCell& cell) {
    const std::uint64_t scents = static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(cell.home))
                                     << 32U |
                                 std::bit_cast<std::uint32_t>(cell.food);
    const std::uint64_t both =
        core::mix(core::mix(static_cast<std::uint64_t>(cell.place) + 1) ^ scents);
    return cell.passages == 0.0F ? both
                                 : core::mix(both ^ std::bit_cast<std::uint32_t>(cell.passages));
}

float what_stays(float amount, float share, float least) {
    return amount * share > least ? amount * share : 0.0F;
}

constexpr int kScentStepX[kDirections] = {1, 1, 0, -1, -1, -1, 0, 1};
constexpr int kScentStepY[kDirections] = {0, 1, 1, 1, 0, -1, -1, -1};

}  // namespace

PheromoneTrails::PheromoneTrails(const pathfinding::GridMap& map, const TrailSettings& settings)
    : map_(map),
      settings_(settings) {
    for (auto& scent : scent_) {
        scent.assign(map.places(), 0.0F);
    }
    passages_.assign(settings.reinforcement > 0.0F ? map.places() : 0, 0.0F);
    is_scented_.assign(map.places(), 0);
    float strength = 1.0F;
    while (strength > kLeastScent && strength_.size() < settings.patience) {
        strength_.push_back(strength);
        strength *= 1.0F - settings.fade;
    }
    for (float ratio = 1.0F - settings.fade; ratio > 1.0F / kStepRatio && sharpness_ < 16;
         ratio *= ratio) {
        ++sharpness_;
    }
}

void PheromoneTrails::evaporate() {
    const float stays = 1.0F - settings_.evaporation;
    std::size_t kept = 0;
    sum_ = 0;
    for (const pathfinding::Place p : scented_) {
        bool any = false;
        for (auto& scent : scent_) {
            scent[p] = what_stays(scent[p], stays, kLeastScent);
            any = any || scent[p] > 0.0F;
        }
        if (!passages_.empty()) {
            passages_[p] = what_stays(passages_[p], stays, kLeastPassages);
            any = any || passages_[p] > 0.0F;
        }
        if (any) {
            scented_[kept++] = p;
            sum_ += term(cell(p));
        } else {
            is_scented_[p] = 0;
        }
    }
    scented_.resize(kept);
}

void PheromoneTrails::note(pathfinding::Place p) {
    if (is_scented_[p] == 0) {
        is_scented_[p] = 1;
        scented_.push_back(p);
    }
}

void PheromoneTrails::mark(Scent which, pathfinding::Place at, std::uint32_t steps) {
    if (steps >= strength_.size()) {
        return;
    }
    ScentCell marked = cell(at);
    float& scent = which == kHome ? marked.home : marked.food;
    scent = std::max(scent, strength_[steps]);
    marked.passages = std::min(marked.passages + 1.0F, kMostPassages);
    set(marked);
}

void PheromoneTrails::set(const ScentCell& to) {
    const pathfinding::Place at = to.place;
    if (is_scented_[at] != 0) {
        sum_ -= term(cell(at));
    }
    scent_[kHome][at] = to.home;
    scent_[kFood][at] = to.food;
    if (!passages_.empty()) {
        passages_[at] = to.passages;
    }
    note(at);
    sum_ += term(cell(at));
}

void PheromoneTrails::hash(core::StateHash& hash) const {
    hash.add(static_cast<std::uint64_t>(scented_.size()));
    hash.add(sum_);
}

bool is_scent_cell(const ScentCell& cell) {
    const auto known = [](float scent) {
        return scent >= 0.0F && scent <= 1.0F;
    };
    return known(cell.home) && known(cell.food) && cell.passages >= 0.0F &&
           cell.passages <= kMostPassages;
}

bool PheromoneTrails::put_scent(const ScentCell& cell) {
    if (cell.place >= map_.places() || !is_scent_cell(cell)) {
        return false;
    }
    set(cell);
    return true;
}

pathfinding::Place PheromoneTrails::beside(pathfinding::Place from, unsigned direction) const {
    const auto stride = static_cast<std::int64_t>(map_.stride());
    return static_cast<pathfinding::Place>(
        static_cast<std::int64_t>(from) + kScentStepY[direction] * stride + kScentStepX[direction]);
}

/// Without cutting corners.
bool PheromoneTrails::open(pathfinding::Place from, unsigned direction) const {
    const bool diagonal = direction % 2 == 1;
    return map_.passable(beside(from, direction)) &&
           (!diagonal ||
            (map_.passable(beside(from, (direction + 1) % kDirections)) &&
             map_.passable(beside(from, (direction + kDirections - 1) % kDirections))));
}

float PheromoneTrails::weight(pathfinding::Place at,
                              unsigned direction,
                              unsigned came,
                              Scent wanted,
                              bool guided) const {
    const unsigned apart = (direction + kDirections - came) % kDirections;
    const float liking = kLiking[apart <= 4 ? apart : kDirections - apart];
    if (!guided) {
        return liking;
    }
    const pathfinding::Place there = beside(at, direction);
    // Scents are compared with the scent here, so that the direction of growth counts, however weak
    // it is.
    const float own = std::max(scent_[wanted][at], kLeastScent);
    float ratio = scent_[wanted][there] / own;
    for (unsigned k = 0; k < sharpness_; ++k) {
        ratio = std::min(ratio * ratio, kMostRatio);
    }
    const float recruits = 1.0F + settings_.reinforcement * passages(there);
    return liking * (kUnscented + ratio) * recruits * recruits;
}

unsigned PheromoneTrails::choose(pathfinding::Place at,
                                 unsigned direction,
                                 Scent wanted,
                                 bool guided,
                                 core::Rng& rng) const {
    std::array<float, kDirections> weights{};
    float sum = 0.0F;
    for (unsigned d = 0; d < kDirections; ++d) {
        weights[d] = open(at, d) ? weight(at, d, direction, wanted, guided) : 0.0F;
        sum += weights[d];
    }
    if (sum <= 0.0F) {
        return kDirections;
    }
    float left = rng.unit() * sum;
    unsigned last = kDirections;
    for (unsigned d = 0; d < kDirections; ++d) {
        if (weights[d] > 0.0F) {
            last = d;
            left -= weights[d];
            if (left < 0.0F) {
                break;
            }
        }
    }
    return last;
}

}  // namespace zoned::ai::pathfinding
