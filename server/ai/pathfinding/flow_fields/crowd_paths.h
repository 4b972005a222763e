// CrowdPaths: paths on a grid that lead around crowds, to shared and to rare goals.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_flow_field.h"
#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/flow_fields/density.h"
#include "server/ai/pathfinding/grid/ground_grid.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Holds the crowding of a map, and next steps around crowds to the last requested goals. Fields
/// are made and brought up to date in parts of counted work; until one is done, the old one
/// answers. Bodies are counted only when all fields are up to date. Deterministic: all depends on
/// the calls alone.
class CrowdPaths {
  public:
    using Cost = CrowdFlowField::Cost;

    CrowdPaths(const GridMap& map, const GroundGrid& grid, const CrowdPathSettings& settings);

    // Its density refers to its own map, so it cannot be copied.
    CrowdPaths(const CrowdPaths&) = delete;
    CrowdPaths& operator=(const CrowdPaths&) = delete;

    /// True if bodies have to be counted in this tick.
    [[nodiscard]] bool looks() const { return ticks_ >= settings_.look_ticks && !busy(); }

    /// Takes all bodies, x and z, m; call where looks().
    void look(std::span<const float> x, std::span<const float> z);

    /// Reports cells that became passable or blocked. Steps into blocked cells are removed at once.
    void change(std::span<const CellChange> changes);

    /// Call once per tick; returns the work done, at most a little more than that of the settings.
    std::uint64_t advance();

    /// True while fields are made or brought up to date.
    [[nodiscard]] bool busy() const;

    [[nodiscard]] SavedCrowds save() const;

    /// Call on a new object. False: the state does not fit this map; then this object is unusable.
    bool load(const SavedCrowds& memory);

    /// The number of times that the answers have changed.
    [[nodiscard]] std::uint64_t round() const { return round_; }

    /// Appends the cells of the best path to the goal to `cells`, which ends with `start`. False
    /// where there is no field for the goal yet; the field is then made.
    bool append_path(Cell start, Cell goal, std::vector<Cell>& cells);

    /// The cost of that path; kNoPath where it is unknown.
    [[nodiscard]] Cost cost(Cell start, Cell goal) const;

    /// A field that answers for the goal: its number; nothing where there is none.
    [[nodiscard]] std::optional<std::size_t> field_to(Cell goal) const;

    /// The next step from a cell by that field; kNoHop where it knows none.
    [[nodiscard]] Hop hop(std::size_t field, Cell at) const;

    /// The cost of a straight walk.
    [[nodiscard]] Cost cost_along(Spot from, Spot to) const;

    /// The cells that are passable and not crowded.
    [[nodiscard]] const GridMap& calm() const { return calm_; }

    [[nodiscard]] const CrowdPathSettings& settings() const { return settings_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// The most goals with fields at a time. A goal within kShare cells and in sight of one of
    /// these shares its field.
    static constexpr std::size_t kGoals = 16;
    static constexpr int kShare = 8;

    enum class GoalState : std::uint8_t {
        kNone,
        kWanted,  ///< to be made
        kBuilding,
        kUpdating,
        kDone,
    };

    struct CrowdGoal {
        GoalState state = GoalState::kNone;
        Cell cell{};
        std::uint64_t used = 0;
        bool answers = false;  ///< hops and costs are ready
        CrowdFlowField field;
        std::vector<Cost> costs;
    };

    /// The next step down. It depends on the present costs and crowding alone, not on their
    /// history.
    [[nodiscard]] Hop next_hop(const CrowdGoal& goal, Cell at) const;
    [[nodiscard]] std::size_t goal_for(Cell goal) const;
    void want(Cell goal);
    std::uint64_t work_on(CrowdGoal& goal, std::uint64_t budget);

    CrowdPathSettings settings_;
    GroundGrid grid_;
    GridMap map_;
    GridMap calm_;
    Density density_;
    std::array<CrowdGoal, kGoals> goals_;
    std::vector<Place> changed_;  // changes that fields have yet to take in
    std::uint64_t ticks_ = 0;     // since the last count
    std::uint64_t tick_ = 0;
    std::uint64_t round_ = 0;
};

}  // namespace zoned::ai::pathfinding
