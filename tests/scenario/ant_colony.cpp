#include "tests/scenario/ant_colony.h"

#include "shared/core/assert.h"

namespace zoned::scenario {

using ai::pathfinding::Cell;

AntColony::AntColony(const ai::pathfinding::GridMap& map,
                     Cell home,
                     const AntColonySettings& settings)
    : map_(map),
      home_(map.place(home)),
      settings_(settings),
      rng_(settings.seed, 0xF00D),
      trails_(map,
              {settings.evaporation, settings.fade, settings.patience, settings.reinforcement}) {
    ZONED_ASSERT(map.passable(home), "home can be entered");
    food_.assign(map.places(), 0);
    slowness_.assign(map.places(), 1);
}

void AntColony::add_walkers(std::size_t count) {
    for (std::size_t i = at_.size(), end = i + count; i < end; ++i) {
        at_.push_back(home_);
        direction_.push_back(static_cast<std::uint8_t>(rng_.below(ai::pathfinding::kDirections)));
        carries_.push_back(0);
        busy_.push_back(0);
        on_path_.push_back(0);
        scouts_.push_back(0);
        set_out(i);
    }
}

void AntColony::set_food(Cell cell, bool there) {
    food_[map_.place(cell)] = there ? 1 : 0;
}

void AntColony::set_slowness(Cell cell, std::uint8_t ticks) {
    ZONED_ASSERT(ticks >= 1, "a step takes a tick");
    slowness_[map_.place(cell)] = ticks;
}

void AntColony::step() {
    trails_.evaporate();
    for (std::size_t i = 0; i < at_.size(); ++i) {
        ++on_path_[i];
        if (busy_[i] > 0) {
            --busy_[i];
        } else {
            walk(i);
        }
    }
}

void AntColony::walk(std::size_t i) {
    if (on_path_[i] > settings_.patience) {
        // It has lost its path: another one leaves home in its place.
        at_[i] = home_;
        on_path_[i] = 0;
        carries_[i] = 0;
        set_out(i);
    }
    trails_.mark(carries_[i] != 0 ? kFood : kHome, at_[i], on_path_[i]);
    const bool guided = carries_[i] != 0 || scouts_[i] == 0;
    const unsigned direction =
        trails_.choose(at_[i], direction_[i], carries_[i] != 0 ? kHome : kFood, guided, rng_);
    if (direction < ai::pathfinding::kDirections) {
        direction_[i] = static_cast<std::uint8_t>(direction);
        at_[i] = trails_.beside(at_[i], direction);
        busy_[i] = static_cast<std::uint8_t>(slowness_[at_[i]] - 1);
    }
    if (carries_[i] == 0 && food_[at_[i]] != 0) {
        carries_[i] = 1;
        turn_back(i);
    } else if (at_[i] == home_ && (carries_[i] != 0 || on_path_[i] > 1)) {
        delivered_ += carries_[i];
        carries_[i] = 0;
        turn_back(i);
        set_out(i);
    }
}

void AntColony::set_out(std::size_t i) {
    scouts_[i] = rng_.unit() < settings_.explore ? 1 : 0;
}

void AntColony::turn_back(std::size_t i) {
    on_path_[i] = 0;
    direction_[i] = static_cast<std::uint8_t>((direction_[i] + ai::pathfinding::kDirections / 2) %
                                              ai::pathfinding::kDirections);
}

}  // namespace zoned::scenario
