// GridPaths: paths over the cells of a zone's ground, where doors turn.
#pragma once

#include "server/ai/pathfinding/grid/door_cells.h"
#include "server/ai/pathfinding/hierarchy/zone_portals.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "server/ai/pathfinding/requests/path_provider.h"

#include <memory>
#include <optional>
#include <vector>

namespace zoned::ai::pathfinding {

/// A GridPathRequests on the ground of a zone for characters of one size.
class GridPaths final : public PathProvider {
  public:
    /// GroundGrid::defect_of() is empty; `shut` by door.
    GridPaths(const motion::StaticGeometry& statics,
              const motion::CharacterLimits& limits,
              const GroundRect& area,
              float cell_m,
              std::span<const std::uint8_t> shut,
              const GridPathSettings& settings);

    PathRequestId ask(const PathRequest& ask) override { return service_.ask(ask); }

    void release(PathRequestId ticket) override { service_.release(ticket); }

    void turn_doors(std::span<const std::uint8_t> shut) override;

    [[nodiscard]] bool knows(PathRequestId ticket) const override { return service_.knows(ticket); }

    void serve() override { service_.serve(); }

    [[nodiscard]] PathResult answer(PathRequestId ticket) const override {
        return service_.answer(ticket);
    }

    Spot heading(PathRequestId ticket, Spot at, float near_m) override {
        return service_.heading(ticket, at, near_m);
    }

    void see(PathRequestId ticket, Spot at, float /*at_y*/) override { service_.see(ticket, at); }

    [[nodiscard]] std::span<const std::uint32_t> answered() const override {
        return service_.answered();
    }

    [[nodiscard]] std::span<const std::uint32_t> requeued() const override {
        return changes_.empty() ? std::span<const std::uint32_t>() : service_.requeued();
    }

    [[nodiscard]] bool counts_bodies() const override { return service_.counts_bodies(); }

    void count_bodies(std::span<const float> x, std::span<const float> z) override {
        service_.count_bodies(x, z);
    }

    std::span<const std::uint32_t> review_crowds() override {
        service_.review_crowds();
        return service_.doubted();
    }

    [[nodiscard]] bool straight(Spot from, float from_y, Spot to, float to_y) const override;

    [[nodiscard]] bool contains(Spot place) const override {
        return service_.grid().contains(place);
    }

    /// Of the cells that can be reached along the sides of the map that the place lies beyond, the
    /// one by which two straight lines lead there soonest.
    MapExit straight_exit(Spot from, float from_y, Spot to) override;

    /// By the portals of the world where they are known and lead there (doors of other zones count
    /// as open).
    std::optional<MapExit> exit_towards(Spot from, float from_y, Spot to) override;

    [[nodiscard]] const GroundMap* ground_map() const override { return ground_.get(); }

    void know_zones(std::shared_ptr<const ZonePortals> portals, std::uint32_t zone) override;

    void forget_ground() override { ground_.reset(); }

    [[nodiscard]] SavedPaths save() const override { return service_.save(); }

    std::string load(const SavedPaths& memory) override { return service_.load(memory); }

    [[nodiscard]] const PathCounts& counts() const override { return service_.counts(); }

    [[nodiscard]] std::size_t bytes() const override;

    [[nodiscard]] GridPathRequests& service() { return service_; }

  private:
    /// The ground as the doors are, and what they do to it.
    struct Baked {
        std::unique_ptr<GroundMap> open;  ///< with all doors open
        GroundMap ground;
        DoorMap doors;
        GridMap most_open;  ///< with all cells that doors take or give
    };

    static Baked bake(const motion::StaticGeometry& statics,
                      const motion::CharacterLimits& limits,
                      const GroundRect& area,
                      float cell_m,
                      std::span<const std::uint8_t> shut);

    GridPaths(Baked baked, const GridPathSettings& settings);

    std::optional<Spot> portal_towards(Spot from, Spot to);

    std::unique_ptr<GroundMap> ground_;           // until portals are made of it
    std::shared_ptr<const ZonePortals> portals_;  // of the world; may be null
    std::uint32_t zone_ = 0;                      // in them
    ZonePortals::Scratch scratch_;
    DoorMap doors_;
    GridPathRequests service_;
    std::vector<CellChange> changes_;  // of the last turn
};

}  // namespace zoned::ai::pathfinding
