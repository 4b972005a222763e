// Density: how crowded the cells of a map are, as what it costs to walk there.
#pragma once

#include "server/ai/crowd/agents.h"
#include "server/ai/navigation/grid_map.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::crowd {

/// What a step costs more in a cell, in sixteenths: 0 in an empty one.
using Crowding = std::uint16_t;

inline constexpr Crowding kPerStep = 16;

struct DensitySettings {
    float x0 = 0.0F;  ///< m, corner of the map's first cell
    float z0 = 0.0F;
    float cell_m = 1.0F;        ///< > 0
    float jam_per_m2 = 4.5F;    ///< agents: nobody moves
    float least_speed = 0.05F;  ///< share of the free speed that is left in a jam, 0 to 1
    float remember = 0.9F;      ///< share of what was known that stays with each look, 0 to 1
};

/// Agents by cells, averaged over looks, and what follows: speed falls evenly with density, down to
/// the least (Greenshields, "A study of traffic capacity", Highway Research Board 14, 1935; people:
/// Fruin, "Pedestrian planning and design", 1971), and a step costs the time that it takes
/// (Treuille, Cooper and Popovic, "Continuum crowds", SIGGRAPH 2006, section 3, for speeds that
/// depend on the density alone). A cell's crowding changes only where it is off by an eighth (or
/// two sixteenths), so that fields which depend on it change seldom. Costs nothing where nobody is
/// or was.
class Density {
  public:
    Density(const navigation::GridMap& map, const DensitySettings& settings);

    /// Counts agents; cells whose crowding has changed are in changed() until the next look. No
    /// allocation once as many cells were crowded.
    void look(const CrowdAgents& agents);

    [[nodiscard]] std::span<const navigation::Place> changed() const { return changed_; }

    /// By place.
    [[nodiscard]] std::span<const Crowding> crowding() const { return crowding_; }

    /// Agents per m2.
    [[nodiscard]] float of(navigation::Place p) const { return density_[p]; }

    /// The cell of a point, or nothing off the map.
    [[nodiscard]] navigation::Place place_of(float x, float z) const;

    [[nodiscard]] const DensitySettings& settings() const { return settings_; }

  private:
    [[nodiscard]] Crowding crowding_of(float density) const;

    DensitySettings settings_;
    int width_;
    int height_;
    const navigation::GridMap& map_;
    std::vector<float> density_;
    std::vector<std::uint16_t> count_;
    std::vector<Crowding> crowding_;
    std::vector<navigation::Place> known_;  // cells with a density
    std::vector<navigation::Place> changed_;
};

}  // namespace zoned::ai::crowd
