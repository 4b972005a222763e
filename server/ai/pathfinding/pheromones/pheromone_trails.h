// PheromoneTrails: scents on a grid map, and the choice of direction of a walker that follows them.
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
    float fade = 0.01F;             ///< loss of a mark's strength with each step, 0 to 1
    std::uint32_t patience = 3000;  ///< a walker stops marking after this many steps under way
};

/// A mark replaces a weaker one. A mark is weaker the longer its walker is under way, so a scent
/// grows towards its source. Marks of one time may be made in any order. Steps are chosen by chance
/// among the cells ahead. The weights follow Deneubourg, Aron, Goss and Pasteels, "The
/// self-organizing exploratory pattern of the Argentine ant", Journal of Insect Behavior 3, 1990.
class PheromoneTrails {
  public:
    /// `map` must outlive this; it may change.
    PheromoneTrails(const pathfinding::GridMap& map, const TrailSettings& settings);

    /// Weakens all scent; only cells with scent cost anything.
    void evaporate();

    /// Marks a place for a walker that has made so many steps.
    void mark(Scent which, pathfinding::Place at, std::uint32_t steps);

    /// The direction in which a walker that came in `direction` goes on to find the source of the
    /// scent `wanted`. Without being `guided` the walker goes by no scent ahead. kDirections where
    /// there is no path out.
    [[nodiscard]] unsigned choose(pathfinding::Place at,
                                  unsigned direction,
                                  Scent wanted,
                                  bool guided,
                                  core::Rng& rng) const;

    [[nodiscard]] pathfinding::Place beside(pathfinding::Place from, unsigned direction) const;

    /// The strength of a scent, 0 to 1.
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

    /// Restores a cell from for_each_scent(). False: the map has no such place, or scents are not
    /// within 0 to 1.
    bool put_scent(pathfinding::Place at, float home, float food);

    /// The cost does not depend on the number of scents: a sum over the cells is kept as they
    /// change.
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
    std::uint64_t sum_ = 0;                    // sum of their terms in the hash
    std::vector<std::uint8_t> is_scented_;
    std::vector<float> strength_;  // strength of a mark, by steps under way
    unsigned sharpness_ = 0;       // number of times that ratios of scent are squared
};

}  // namespace zoned::ai::pathfinding
