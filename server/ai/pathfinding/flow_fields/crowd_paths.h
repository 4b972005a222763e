// CrowdPaths: paths on a grid that lead around crowds, to goals that many or few have.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_flow_field.h"
#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/flow_fields/density.h"
#include "server/ai/pathfinding/grid/ground_grid.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// How crowded a map is, and next steps by that to the goals that were asked for last. Fields are
/// made and brought up to date in counted resumable_task; until one is, that of before answers.
/// Bodies are counted only when all fields are up to date. Deterministic: all hangs on the calls
/// alone.
class CrowdPaths {
  public:
    using Cost = CrowdFlowField::Cost;

    CrowdPaths(const GridMap& map, const GroundGrid& grid, const CrowdPathSettings& settings);

    // What it counts on is a map of its own.
    CrowdPaths(const CrowdPaths&) = delete;
    CrowdPaths& operator=(const CrowdPaths&) = delete;

    /// Whether bodies are to be counted in this tick.
    [[nodiscard]] bool looks() const { return ticks_ >= settings_.look_ticks && !busy(); }

    /// All bodies, x and z, m: where looks().
    void look(std::span<const float> x, std::span<const float> z);

    /// Cells have become passable or not. Steps into what was closed are none at once.
    void change(std::span<const CellChange> changes);

    /// Once per tick; returns the work done, at most a little more than that of the settings.
    std::uint64_t advance();

    [[nodiscard]] SavedCrowds save() const;

    /// Of one that was just made. False: it is none of this map; then this is of no use.
    bool load(const SavedCrowds& memory);

    /// How often the answers have become others.
    [[nodiscard]] std::uint64_t round() const { return round_; }

    /// Appends to `cells`, which ends with `start`, those of the best path to the goal; false where
    /// there is no field for it yet, which is then made.
    bool append_path(Cell start, Cell goal, std::vector<Cell>& cells);

    /// What that path costs; kNoPath where nobody knows.
    [[nodiscard]] Cost cost(Cell start, Cell goal) const;

    /// What a straight walk costs.
    [[nodiscard]] Cost cost_along(Spot from, Spot to) const;

    /// Where one can walk that is not crowded.
    [[nodiscard]] const GridMap& calm() const { return calm_; }

    [[nodiscard]] const CrowdPathSettings& settings() const { return settings_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// So many goals have fields at a time; goals so near to one of these, and in sight of it,
    /// share it, cells.
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
        bool answers = false;  ///< hops and costs are there
        CrowdFlowField field;
        std::vector<Cost> costs;
    };

    /// The next step down: hangs on costs and crowding alone, not on how they came about.
    [[nodiscard]] Hop next_hop(const CrowdGoal& goal, Cell at) const;
    [[nodiscard]] bool busy() const;
    [[nodiscard]] std::size_t goal_for(Cell goal) const;
    void want(Cell goal);
    std::uint64_t work_on(CrowdGoal& goal, std::uint64_t budget);

    CrowdPathSettings settings_;
    GroundGrid grid_;
    GridMap map_;
    GridMap calm_;
    Density density_;
    std::array<CrowdGoal, kGoals> goals_;
    std::vector<Place> changed_;  // that fields have yet to hear of
    std::uint64_t ticks_ = 0;     // since the last look
    std::uint64_t tick_ = 0;
    std::uint64_t round_ = 0;
};

}  // namespace zoned::ai::pathfinding
