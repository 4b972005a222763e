// AntColony: ants that find the shortest path to food by scents, for tests and pictures.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/pheromones/pheromone_trails.h"
#include "shared/core/rng.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::scenario {

struct AntColonySettings {
    float evaporation = 0.002F;  ///< share of all scent that is lost in a tick, 0 to 1
    float fade = 0.01F;          ///< by which a walker's mark gets weaker with each tick, 0 to 1
    float explore = 0.15F;       ///< share of walkers that leave home without a scent, 0 to 1
    std::uint32_t patience =
        3000;                    ///< ticks without success after which a walker starts anew at home
    float reinforcement = 0.0F;  ///< how much each passage draws others, 0 to 1
    std::uint64_t seed = 1;
};

/// Scents on a map, and walkers that follow them. A walker that comes from home marks cells with
/// the scent of home; one that carries food marks them with that of food (trails.h). All scents
/// evaporate, so a path that is no longer walked is forgotten. A path that has become longer is
/// marked anew with its present worth. Scouts go where no scent leads until they find food.
/// Deterministic by seed.
class AntColony {
  public:
    static constexpr ai::pathfinding::Scent kHome = ai::pathfinding::kHome;
    static constexpr ai::pathfinding::Scent kFood = ai::pathfinding::kFood;

    /// `map` must outlive this; it may change between steps. `home` is passable.
    AntColony(const ai::pathfinding::GridMap& map,
              ai::pathfinding::Cell home,
              const AntColonySettings& settings);

    /// Walkers start at home.
    void add_walkers(std::size_t count);

    /// Sets food that does not run out, or removes it (`there` false).
    void set_food(ai::pathfinding::Cell cell, bool there);

    /// Ticks that a step into this cell takes, >= 1 (mud, thicket). One at first.
    void set_slowness(ai::pathfinding::Cell cell, std::uint8_t ticks);

    void step();

    /// 0 to 1.
    [[nodiscard]] float scent(ai::pathfinding::Scent which, ai::pathfinding::Place p) const {
        return trails_.scent(which, p);
    }

    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

    [[nodiscard]] std::size_t walkers() const { return at_.size(); }

    [[nodiscard]] ai::pathfinding::Place walker_at(std::size_t i) const { return at_[i]; }

    [[nodiscard]] bool carries(std::size_t i) const { return carries_[i] != 0; }

  private:
    void walk(std::size_t i);
    void set_out(std::size_t i);
    void turn_back(std::size_t i);

    const ai::pathfinding::GridMap& map_;
    ai::pathfinding::Place home_;
    AntColonySettings settings_;
    core::Rng rng_;
    ai::pathfinding::PheromoneTrails trails_;
    std::vector<std::uint8_t> food_;
    std::vector<std::uint8_t> slowness_;
    // Walkers.
    std::vector<ai::pathfinding::Place> at_;
    std::vector<std::uint8_t> direction_;  // 0 to 7, by eighths of a turn
    std::vector<std::uint8_t> carries_;
    std::vector<std::uint8_t> scouts_;
    std::vector<std::uint8_t> busy_;      // ticks until the next step
    std::vector<std::uint32_t> on_path_;  // ticks since home or food
    std::uint64_t delivered_ = 0;
};

}  // namespace zoned::scenario
