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
    /// How much each passage over a cell draws other walkers, 0 to 1: the inverse of the passages
    /// that double its weight's root. 0: it does not count how many have passed.
    float reinforcement = 0.0F;
};

/// ScentCell: what is on a cell.
struct ScentCell {
    Place place = 0;
    float home = 0.0F;      ///< 0 to 1
    float food = 0.0F;      ///< 0 to 1
    float passages = 0.0F;  ///< marks made here, less what has evaporated of them; >= 0
};

/// A mark replaces a weaker one. A mark is weaker the longer its walker is under way, so a scent
/// grows towards its source. Marks of one time may be made in any order. Steps are chosen by chance
/// among the cells ahead. The weights follow Deneubourg, Aron, Goss and Pasteels, "The
/// self-organizing exploratory pattern of the Argentine ant", Journal of Insect Behavior 3, 1990.
/// With `reinforcement` r the weight of a cell that n have passed grows by (1 + r n)^2, as the
/// paper has it (there r = 1/20): where many go, more go.
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

    /// Passages over a cell, less what has evaporated of them; 0 without reinforcement.
    [[nodiscard]] float passages(pathfinding::Place p) const {
        return passages_.empty() ? 0.0F : passages_[p];
    }

    /// Calls visit(ScentCell) for the cells with any scent, by ascending place.
    template <class Visit>
    void for_each_scent(Visit&& visit) const {
        for (pathfinding::Place p = 0; p < map_.places(); ++p) {
            if (is_scented_[p] != 0) {
                visit(cell(p));
            }
        }
    }

    /// Restores a cell from for_each_scent(). False: the map has no such place, or the cell is none
    /// (see is_scent_cell()).
    bool put_scent(const ScentCell& cell);

    /// The cost does not depend on the number of scents: a sum over the cells is kept as they
    /// change.
    void hash(core::StateHash& hash) const;

  private:
    [[nodiscard]] ScentCell cell(pathfinding::Place at) const {
        return {at, scent_[kHome][at], scent_[kFood][at], passages(at)};
    }

    void set(const ScentCell& cell);
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
    std::vector<float> passages_;              // empty without reinforcement
    std::vector<pathfinding::Place> scented_;  // cells with any scent
    std::uint64_t sum_ = 0;                    // sum of their terms in the hash
    std::vector<std::uint8_t> is_scented_;
    std::vector<float> strength_;  // strength of a mark, by steps under way
    unsigned sharpness_ = 0;       // number of times that ratios of scent are squared
};

/// Whether scents are within 0 to 1, and passages within what marks can make.
[[nodiscard]] bool is_scent_cell(const ScentCell& cell);

}  // namespace zoned::ai::pathfinding
