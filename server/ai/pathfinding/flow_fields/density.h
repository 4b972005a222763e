// Density: the crowding of a map's cells, as the extra cost of walking there.
#pragma once

#include "server/ai/crowd/crowd_agents.h"
#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/grid/grid_map.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The extra cost of a step in a cell, in sixteenths: 0 in an empty one.
using Crowding = std::uint16_t;

inline constexpr Crowding kPerStep = 16;

struct DensitySettings {
    float x0 = 0.0F;  ///< m, corner of the map's first cell
    float z0 = 0.0F;
    float cell_m = 1.0F;        ///< > 0
    float jam_per_m2 = 4.5F;    ///< agents per m2 at which nobody moves
    float least_speed = 0.05F;  ///< share of the free speed that is left in a jam, 0 to 1
    float remember = 0.9F;      ///< share of the known density that stays at each count, 0 to 1
    int block = 1;              ///< squares of so many cells a side are counted together, > 0
};

/// The average density of agents by cells, or by blocks of cells that count their passable part.
/// Speed falls evenly with density, down to the least. Sources: Greenshields, "A study of traffic
/// capacity", Highway Research Board 14, 1935; for people Fruin, "Pedestrian planning and design",
/// 1971. A step costs the time that it takes. Source: Treuille, Cooper and Popovic, "Continuum
/// crowds", SIGGRAPH 2006, section 3, for speeds that depend on the density alone.
/// A cell's crowding changes only where it is off by an eighth (or two sixteenths), so fields that
/// depend on it change seldom. Empty ground costs nothing once its density has faded. Blocks are
/// squares of the map itself: nobody is looked up in them, so no grid of server/spatial serves.
class Density {
  public:
    Density(const GridMap& map, const DensitySettings& settings);

    /// Counts agents. Cells whose crowding has changed are in changed() until the next count. Does
    /// not allocate once as many cells were crowded.
    void look(const steering::CrowdAgents& agents);

    /// The same of bodies at these places.
    void look(std::span<const float> x, std::span<const float> z);

    [[nodiscard]] std::span<const Place> changed() const { return changed_; }

    /// By place.
    [[nodiscard]] std::span<const Crowding> crowding() const { return crowding_; }

    /// Agents per m2.
    [[nodiscard]] float of(Place p) const { return density_[block_of(p)]; }

    /// The cell of a point, or nothing off the map.
    [[nodiscard]] Place place_of(float x, float z) const;

    [[nodiscard]] const DensitySettings& settings() const { return settings_; }

    /// Appends the known density.
    void write(std::vector<SavedCrowds::SavedBlock>& blocks) const;

    /// Call on a new object. False: some blocks are not of this map, occur twice, or have no valid
    /// density; then this object is unusable.
    bool load(std::span<const SavedCrowds::SavedBlock> blocks);

    /// Calls visit(place) for the cells of a block.
    template <class Visit>
    void for_each_cell(std::uint32_t block, Visit&& visit) const {
        const int left = static_cast<int>(block % blocks_across_) * settings_.block;
        const int top = static_cast<int>(block / blocks_across_) * settings_.block;
        for (int y = top; y < std::min(top + settings_.block, height_); ++y) {
            for (int x = left; x < std::min(left + settings_.block, width_); ++x) {
                visit(map_.place({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)}));
            }
        }
    }

  private:
    [[nodiscard]] Crowding crowding_of(float density) const;
    [[nodiscard]] std::uint32_t block_of(Place p) const;
    [[nodiscard]] float passable_m2(std::uint32_t block) const;
    void set(std::uint32_t block, Crowding crowding);

    DensitySettings settings_;
    int width_;
    int height_;
    const GridMap& map_;
    std::uint32_t blocks_across_;
    std::vector<float> density_;        // by block
    std::vector<std::uint16_t> count_;  // likewise
    std::vector<Crowding> of_block_;    // likewise
    std::vector<Crowding> crowding_;    // by place
    std::vector<std::uint32_t> known_;  // blocks with a density
    std::vector<Place> changed_;
};

}  // namespace zoned::ai::pathfinding
