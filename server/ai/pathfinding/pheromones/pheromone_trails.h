// PheromoneTrails: scents on a grid map, and which way somebody who follows them takes.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

enum Scent : std::uint8_t {
    kHome,
    kFood,
    kScents
};

/// Directions to neighbouring cells, by eighths of a turn from +x to +y of the map.
inline constexpr unsigned kDirections = 8;

struct TrailSettings {
    float evaporation = 0.002F;     ///< share of all scent that is lost at a time, 0 to 1
    float fade = 0.01F;             ///< by which a mark gets weaker with each step, 0 to 1
    std::uint32_t patience = 3000;  ///< steps on the way after which nobody marks any more
};

/// A mark replaces a weaker one, and is the weaker, the longer its walker is on its way: so a scent
/// grows towards where it comes from. Marks of one time may be made in any order. Steps are chosen
/// by chance, with weights after Deneubourg, Aron, Goss and Pasteels, "The self-organizing
/// exploratory pattern of the Argentine ant", Journal of Insect Behavior 3, 1990, among the cells
/// ahead.
class PheromoneTrails {
  public:
    /// `map` must outlive this; it may change.
    PheromoneTrails(const pathfinding::GridMap& map, const TrailSettings& settings);

    /// Only cells with scent cost anything.
    void evaporate();

    /// By a walker that has made so many steps.
    void mark(Scent which, pathfinding::Place at, std::uint32_t steps);

    /// Where one who came in `direction` goes on to find what has the scent `wanted`; without being
    /// `guided` by it anywhere ahead. kDirections where there is no path out.
    [[nodiscard]] unsigned choose(pathfinding::Place at,
                                  unsigned direction,
                                  Scent wanted,
                                  bool guided,
                                  core::Rng& rng) const;

    [[nodiscard]] pathfinding::Place beside(pathfinding::Place from, unsigned direction) const;

    /// 0 to 1.
    [[nodiscard]] float scent(Scent which, pathfinding::Place p) const { return scent_[which][p]; }

    /// Calls visit(place, home, food) for the cells with any scent, by ascending place.
    template <class Visit>
    void for_each_scent(Visit&& visit) const {
        for (pathfinding::Place p = 0; p < map_.places(); ++p) {
            if (is_scented_[p] != 0) {
                visit(p, scent_[kHome][p], scent_[kFood][p]);
            }
        }
    }

    /// As for_each_scent() said; false: the map has no such place, or scents are not within 0 to 1.
    bool put_scent(pathfinding::Place at, float home, float food);

    /// Costs the same whatever there is: a sum over the cells is kept as they change.
    void hash(core::StateHash& hash) const;

  private:
    void set(pathfinding::Place at, float home, float food);
    [[nodiscard]] bool open(pathfinding::Place from, unsigned direction) const;
    [[nodiscard]] float weight(pathfinding::Place at,
                               unsigned direction,
                               unsigned came,
                               Scent wanted,
                               bool guided) const;
    void note(pathfinding::Place p);

    const pathfinding::GridMap& map_;
    TrailSettings settings_;
    std::array<std::vector<float>, kScents> scent_;
    std::vector<pathfinding::Place> scented_;  // cells with any scent
    std::uint64_t sum_ = 0;                    // of what these add to the hash
    std::vector<std::uint8_t> is_scented_;
    std::vector<float> strength_;  // of a mark, by steps on the way
    unsigned sharpness_ = 0;       // how often ratios of scent are squared
};

}  // namespace zoned::ai::pathfinding
