// GridPaths: answers path requests over cells of the ground, with doors and neighbouring zones.
#pragma once

#include "server/ai/pathfinding/grid/door_cells.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "server/ai/pathfinding/requests/portal_costs.h"
#include "server/ai/pathfinding/requests/zone_portals.h"

#include <memory>
#include <optional>
#include <vector>

namespace zoned::ai::pathfinding {

/// The ground of a zone for characters of one size, with its doors and the zones around it.
class GridPaths final : public GridPathRequests {
  public:
    /// GroundGrid::defect_of() must be empty; `shut` is by door.
    GridPaths(const motion::StaticGeometry& statics,
              const motion::CharacterLimits& limits,
              const GroundRect& area,
              float cell_m,
              std::span<const std::uint8_t> shut,
              const GridPathSettings& settings);

    void turn_doors(std::span<const std::uint8_t> shut) override;

    /// Goes by the portals of the world where they are known and lead there (doors of other zones
    /// count as open).
    std::optional<MapExit> exit_towards(Spot from, float from_y, Spot to) override;

    bool learn_exits() override;

    [[nodiscard]] const GroundMap* ground_map() const override { return ground_.get(); }

    void know_zones(std::shared_ptr<const ZonePortals> portals, std::uint32_t zone) override;

    void forget_ground() override { ground_.reset(); }

    [[nodiscard]] SavedPaths save() const override;
    std::string load(const SavedPaths& memory) override;

    [[nodiscard]] std::size_t bytes() const override;

  private:
    /// Baked: the ground with the doors as they are, and the cells that doors change.
    struct Baked {
        std::unique_ptr<GroundMap> open;  ///< with all doors open
        GroundMap ground;
        DoorMap doors;
        GridMap most_open;  ///< with all cells passable that doors take or give
    };

    static Baked bake(const motion::StaticGeometry& statics,
                      const motion::CharacterLimits& limits,
                      const GroundRect& area,
                      float cell_m,
                      std::span<const std::uint8_t> shut);

    GridPaths(Baked baked, const GridPathSettings& settings);

    std::optional<MapExit> portal_towards(Spot from, Spot to);

    std::unique_ptr<GroundMap> ground_;           // kept until portals are made from it
    std::shared_ptr<const ZonePortals> portals_;  // of the world; may be null
    std::uint32_t zone_ = 0;                      // this zone's number in the portals
    PortalCosts costs_;                           // as far as this zone's paths needed them
    ZonePortals::Scratch scratch_;
    DoorMap doors_;
    std::vector<CellChange> changes_;  // changes of the last turn of doors
};

}  // namespace zoned::ai::pathfinding
