#include "server/ai/ants/foraging.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::ants {

using navigation::Cell;

namespace {

using GridPlace = navigation::Place;

constexpr unsigned kDirections = 8;
/// How much walkers like to go on, by eighths of a turn away from ahead.
constexpr std::array<float, 5> kLiking{1.0F, 0.6F, 0.15F, 0.05F, 0.02F};
/// Weight of what has no scent, beside 1 for what smells as strong as here.
constexpr float kUnscented = 0.02F;
constexpr float kMostRatio = 1e6F;
/// A tick less on the way makes a cell at least so many times as attractive.
constexpr float kTickRatio = 1.4F;
/// Scent that is weaker is none.
constexpr float kLeastScent = 1e-4F;

constexpr int kStepX[kDirections] = {1, 1, 0, -1, -1, -1, 0, 1};
constexpr int kStepY[kDirections] = {0, 1, 1, 1, 0, -1, -1, -1};

}  // namespace

Foraging::Foraging(const navigation::GridMap& map, Cell home, const ForagingSettings& settings)
    : map_(map),
      home_(map.place(home)),
      settings_(settings),
      rng_(settings.seed, 0xF00D) {
    ZONED_ASSERT(map.passable(home), "home can be entered");
    for (auto& scent : scent_) {
        scent.assign(map.places(), 0.0F);
    }
    is_scented_.assign(map.places(), 0);
    food_.assign(map.places(), 0);
    slowness_.assign(map.places(), 1);
    float strength = 1.0F;
    while (strength > kLeastScent && strength_.size() < settings.patience) {
        strength_.push_back(strength);
        strength *= 1.0F - settings.fade;
    }
    for (float ratio = 1.0F - settings.fade; ratio > 1.0F / kTickRatio && sharpness_ < 16;
         ratio *= ratio) {
        ++sharpness_;
    }
}

void Foraging::add_walkers(std::size_t count) {
    for (std::size_t i = at_.size(), end = i + count; i < end; ++i) {
        at_.push_back(home_);
        direction_.push_back(static_cast<std::uint8_t>(rng_.below(kDirections)));
        carries_.push_back(0);
        busy_.push_back(0);
        on_way_.push_back(0);
        scouts_.push_back(0);
        set_out(i);
    }
}

void Foraging::set_food(Cell cell, bool there) {
    food_[map_.place(cell)] = there ? 1 : 0;
}

void Foraging::set_slowness(Cell cell, std::uint8_t ticks) {
    ZONED_ASSERT(ticks >= 1, "a step takes a tick");
    slowness_[map_.place(cell)] = ticks;
}

void Foraging::step() {
    evaporate();
    for (std::size_t i = 0; i < at_.size(); ++i) {
        ++on_way_[i];
        if (busy_[i] > 0) {
            --busy_[i];
        } else {
            walk(i);
        }
    }
}

/// Only cells with scent cost anything.
void Foraging::evaporate() {
    const float stays = 1.0F - settings_.evaporation;
    std::size_t kept = 0;
    for (const GridPlace p : scented_) {
        bool any = false;
        for (auto& scent : scent_) {
            scent[p] = scent[p] * stays > kLeastScent ? scent[p] * stays : 0.0F;
            any = any || scent[p] > 0.0F;
        }
        if (any) {
            scented_[kept++] = p;
        } else {
            is_scented_[p] = 0;
        }
    }
    scented_.resize(kept);
}

void Foraging::walk(std::size_t i) {
    if (on_way_[i] > settings_.patience) {
        // It has lost its way: another one leaves home in its place.
        at_[i] = home_;
        on_way_[i] = 0;
        carries_[i] = 0;
        set_out(i);
    }
    mark(i);
    const unsigned direction = choose(i);
    if (direction < kDirections) {
        direction_[i] = static_cast<std::uint8_t>(direction);
        at_[i] = beside(at_[i], direction);
        busy_[i] = static_cast<std::uint8_t>(slowness_[at_[i]] - 1);
    }
    if (carries_[i] == 0 && food_[at_[i]] != 0) {
        carries_[i] = 1;
        turn_back(i);
    } else if (at_[i] == home_ && (carries_[i] != 0 || on_way_[i] > 1)) {
        delivered_ += carries_[i];
        carries_[i] = 0;
        turn_back(i);
        set_out(i);
    }
}

void Foraging::set_out(std::size_t i) {
    scouts_[i] = rng_.unit() < settings_.explore ? 1 : 0;
}

void Foraging::turn_back(std::size_t i) {
    on_way_[i] = 0;
    direction_[i] = static_cast<std::uint8_t>((direction_[i] + kDirections / 2) % kDirections);
}

void Foraging::mark(std::size_t i) {
    if (on_way_[i] >= strength_.size()) {
        return;
    }
    const GridPlace p = at_[i];
    float& scent = scent_[carries_[i] != 0 ? kFood : kHome][p];
    scent = std::max(scent, strength_[on_way_[i]]);
    if (is_scented_[p] == 0) {
        is_scented_[p] = 1;
        scented_.push_back(p);
    }
}

GridPlace Foraging::beside(GridPlace from, unsigned direction) const {
    const auto stride = static_cast<std::int64_t>(map_.stride());
    return static_cast<GridPlace>(static_cast<std::int64_t>(from) + kStepY[direction] * stride +
                                  kStepX[direction]);
}

/// Without cutting corners.
bool Foraging::open(GridPlace from, unsigned direction) const {
    const bool diagonal = direction % 2 == 1;
    return map_.passable(beside(from, direction)) &&
           (!diagonal ||
            (map_.passable(beside(from, (direction + 1) % kDirections)) &&
             map_.passable(beside(from, (direction + kDirections - 1) % kDirections))));
}

float Foraging::weight(std::size_t i, unsigned direction, bool guided) const {
    const unsigned apart = (direction + kDirections - direction_[i]) % kDirections;
    const float liking = kLiking[apart <= 4 ? apart : kDirections - apart];
    if (!guided) {
        return liking;
    }
    const Scent wanted = carries_[i] != 0 ? kHome : kFood;
    const GridPlace here = at_[i];
    const GridPlace there = beside(here, direction);
    // Against what is smelt here, so that what counts is which way it grows, however weak it is.
    const float own = std::max(scent_[wanted][here], kLeastScent);
    float ratio = scent_[wanted][there] / own;
    for (unsigned k = 0; k < sharpness_; ++k) {
        ratio = std::min(ratio * ratio, kMostRatio);
    }
    return liking * (kUnscented + ratio);
}

/// kDirections where there is no way out.
unsigned Foraging::choose(std::size_t i) {
    const bool guided = carries_[i] != 0 || scouts_[i] == 0;
    std::array<float, kDirections> weights{};
    float sum = 0.0F;
    for (unsigned d = 0; d < kDirections; ++d) {
        weights[d] = open(at_[i], d) ? weight(i, d, guided) : 0.0F;
        sum += weights[d];
    }
    if (sum <= 0.0F) {
        return kDirections;
    }
    float left = rng_.unit() * sum;
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

}  // namespace zoned::ai::ants
