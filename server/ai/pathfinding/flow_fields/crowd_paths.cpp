#include "server/ai/pathfinding/flow_fields/crowd_paths.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/grid/work_units.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace zoned::ai::pathfinding {

namespace {

/// A cell that a field settles, with the steps around it.
constexpr std::uint64_t kSettleUnits = 75;
/// The number of places whose answers are copied per unit of work.
constexpr std::uint64_t kCopiedPlaces = 4;
/// A body that is counted.
constexpr std::uint64_t kCountUnits = 10;
/// Squares in which bodies are counted are about so wide, m: many bodies fit, and a gate does not.
constexpr float kBlock_m = 2.0F;

DensitySettings density_settings(const GroundGrid& grid, const CrowdPathSettings& settings) {
    DensitySettings out;
    out.x0 = grid.min_x();
    out.z0 = grid.min_z();
    out.cell_m = grid.cell_m();
    out.jam_per_m2 = settings.jam_per_m2;
    out.least_speed = settings.least_speed;
    out.remember = settings.remember;
    out.block = std::max(1, static_cast<int>(std::lround(kBlock_m / grid.cell_m())));
    return out;
}

}  // namespace

CrowdPaths::CrowdPaths(const GridMap& map,
                       const GroundGrid& grid,
                       const CrowdPathSettings& settings)
    : settings_(settings),
      grid_(grid),
      map_(map),
      calm_(map),
      density_(map_, density_settings(grid, settings)) {
    ZONED_ASSERT(settings.look_ticks > 0 && settings.gain > 0.0F && settings.gain < 1.0F &&
                     settings.work_per_tick > 0,
                 "settings of crowding");
}

bool CrowdPaths::busy() const {
    return !changed_.empty() ||
           std::any_of(goals_.begin(), goals_.end(), [](const CrowdGoal& goal) {
               return goal.state == GoalState::kBuilding || goal.state == GoalState::kUpdating;
           });
}

void CrowdPaths::look(std::span<const float> x, std::span<const float> z) {
    ticks_ = 0;
    density_.look(x, z);
    for (const Place p : density_.changed()) {
        const Cell c = map_.cell(p);
        calm_.set_passable(c, map_.passable(p) && density_.crowding()[p] == 0);
    }
    changed_.assign(density_.changed().begin(), density_.changed().end());
}

void CrowdPaths::change(std::span<const CellChange> changes) {
    for (const CellChange& c : changes) {
        map_.set_passable(c.cell, c.passable);
        calm_.set_passable(c.cell, c.passable && density_.crowding()[map_.place(c.cell)] == 0);
    }
    // One that is half done knows nothing of it: it is made from the beginning.
    for (CrowdGoal& goal : goals_) {
        if (goal.state == GoalState::kBuilding || goal.state == GoalState::kUpdating) {
            goal.state = GoalState::kWanted;
        }
    }
    for (const CellChange& c : changes) {
        changed_.push_back(map_.place(c.cell));
    }
}

std::uint64_t CrowdPaths::work_on(CrowdGoal& goal, std::uint64_t budget) {
    const std::size_t most = std::max<std::size_t>(1, budget / kSettleUnits);
    const std::size_t before = goal.field.work();
    if (!goal.field.advance(map_, density_.crowding(), most)) {
        return budget;
    }
    const std::size_t settled = goal.field.work() - before;
    goal.costs.assign(goal.field.costs().begin(), goal.field.costs().end());
    goal.state = GoalState::kDone;
    goal.answers = true;
    ++round_;
    return kSettleUnits * settled + map_.places() / kCopiedPlaces;
}

std::uint64_t CrowdPaths::advance() {
    ++tick_;
    ++ticks_;
    std::uint64_t spent = 0;
    if (!changed_.empty()) {
        for (CrowdGoal& goal : goals_) {
            if (goal.state == GoalState::kDone) {
                goal.field.begin_update(changed_);
                goal.state = GoalState::kUpdating;
            }
        }
        spent += kCountUnits * changed_.size();
        changed_.clear();
    }
    for (CrowdGoal& goal : goals_) {
        if (spent >= settings_.work_per_tick) {
            break;
        }
        if (goal.state == GoalState::kWanted) {
            goal.field.begin_build(map_, goal.cell);
            goal.state = GoalState::kBuilding;
            spent += map_.places() / kCopiedPlaces;
        }
        if ((goal.state == GoalState::kBuilding || goal.state == GoalState::kUpdating) &&
            spent < settings_.work_per_tick) {
            spent += work_on(goal, settings_.work_per_tick - spent);
        }
    }
    return spent;
}

std::size_t CrowdPaths::goal_for(Cell goal) const {
    std::uint32_t looked = 0;
    for (std::size_t g = 0; g < kGoals; ++g) {
        const Cell at = goals_[g].cell;
        if (goals_[g].state != GoalState::kNone && std::abs(at.x - goal.x) <= kShare &&
            std::abs(at.y - goal.y) <= kShare && sees(map_, at, goal, looked)) {
            return g;
        }
    }
    return kGoals;
}

/// Takes the place of the goal that was used longest ago, unless all are in use. Otherwise goals
/// would replace each other in turn, and no field would ever be ready.
void CrowdPaths::want(Cell goal) {
    CrowdGoal& oldest =
        *std::min_element(goals_.begin(), goals_.end(), [](const CrowdGoal& a, const CrowdGoal& b) {
            return a.used < b.used;
        });
    const std::uint64_t in_use = std::uint64_t{20} * settings_.look_ticks;
    if (oldest.state != GoalState::kNone && oldest.used + in_use > tick_) {
        return;
    }
    oldest.state = GoalState::kWanted;
    oldest.answers = false;
    oldest.cell = goal;
    oldest.used = tick_;
}

Hop CrowdPaths::next_hop(const CrowdGoal& goal, Cell at) const {
    const Place p = map_.place(at);
    const auto open = [this, at](int dx, int dy) {
        const int x = at.x + dx;
        const int y = at.y + dy;
        return x >= 0 && y >= 0 &&
               map_.passable(Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
    };
    Hop best = kNoHop;
    Cost least = CrowdFlowField::kNoPath;
    for (Hop hop = 0; hop < kArrived; ++hop) {
        const Cell to = hopped(at, hop);
        const int dx = to.x - at.x;
        const int dy = to.y - at.y;
        // Beyond the map's first column numbers begin again at the last one.
        if (dx > 1 || dy > 1 || !open(dx, dy) || !open(dx, 0) || !open(0, dy)) {
            continue;
        }
        const Place q = map_.place(to);
        if (goal.costs[q] >= goal.costs[p]) {
            continue;
        }
        const Cost length = dx != 0 && dy != 0 ? kDiagonal : kStraight;
        const Cost cost = goal.costs[q] + length * (2U * kPerStep + density_.crowding()[p] +
                                                    density_.crowding()[q]);
        if (cost < least) {
            least = cost;
            best = hop;
        }
    }
    return best;
}

std::optional<std::size_t> CrowdPaths::field_to(Cell goal) const {
    const std::size_t number = goal_for(goal);
    return number < kGoals && goals_[number].answers ? std::optional(number) : std::nullopt;
}

Hop CrowdPaths::hop(std::size_t field, Cell at) const {
    const CrowdGoal& to = goals_[field];
    return at == to.cell ? kArrived : map_.passable(at) ? next_hop(to, at) : kNoHop;
}

bool CrowdPaths::append_path(Cell start, Cell goal, std::vector<Cell>& cells) {
    const std::size_t number = goal_for(goal);
    if (number == kGoals) {
        want(goal);
        return false;
    }
    CrowdGoal& to = goals_[number];
    to.used = tick_;
    if (!to.answers || to.costs[map_.place(start)] == CrowdFlowField::kNoPath) {
        return false;
    }
    const std::size_t before = cells.size();
    std::uint32_t looked = 0;
    Cell c = start;
    Hop last = kNoHop;
    while (c != to.cell) {
        const bool near = std::abs(c.x - goal.x) <= kShare && std::abs(c.y - goal.y) <= kShare;
        if (near && sees(map_, c, goal, looked)) {
            break;
        }
        const Hop hop = next_hop(to, c);
        if (hop == kNoHop) {
            cells.resize(before);  // a door has shut there since
            return false;
        }
        c = hopped(c, hop);
        if (hop == last && cells.size() > before) {
            cells.back() = c;
        } else {
            cells.push_back(c);
        }
        last = hop;
    }
    if (cells.empty() || cells.back() != goal) {
        cells.push_back(goal);
    }
    return true;
}

CrowdPaths::Cost CrowdPaths::cost(Cell start, Cell goal) const {
    const std::size_t number = goal_for(goal);
    return number == kGoals || !goals_[number].answers ? CrowdFlowField::kNoPath
                                                       : goals_[number].costs[map_.place(start)];
}

/// Looked at in the middle of pieces of a cell's length.
CrowdPaths::Cost CrowdPaths::cost_along(Spot from, Spot to) const {
    const float length =
        std::sqrt((to.x - from.x) * (to.x - from.x) + (to.z - from.z) * (to.z - from.z));
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / grid_.cell_m())));
    std::uint64_t sixteenths = 0;
    for (int k = 0; k < pieces; ++k) {
        const float share = (static_cast<float>(k) + 0.5F) / static_cast<float>(pieces);
        const Spot at{from.x + share * (to.x - from.x), from.z + share * (to.z - from.z)};
        sixteenths +=
            kPerStep +
            (grid_.contains(at) ? density_.crowding()[map_.place(grid_.cell(at))] : Crowding{0});
    }
    const float cells = length / grid_.cell_m();
    const double per_cell = 2.0 * static_cast<double>(kStraight);
    return static_cast<Cost>(per_cell * static_cast<double>(cells) *
                             static_cast<double>(sixteenths) / static_cast<double>(pieces));
}

SavedCrowds CrowdPaths::save() const {
    SavedCrowds memory;
    density_.write(memory.blocks);
    for (const CrowdGoal& goal : goals_) {
        const bool there = goal.state != GoalState::kNone;
        memory.goals.push_back({there ? map_.place(goal.cell) : ~0U, goal.used, goal.answers});
    }
    memory.ticks = ticks_;
    memory.tick = tick_;
    memory.round = round_;
    return memory;
}

bool CrowdPaths::load(const SavedCrowds& memory) {
    if (memory.goals.size() != kGoals || !density_.load(memory.blocks)) {
        return false;
    }
    ticks_ = memory.ticks;
    tick_ = memory.tick;
    round_ = memory.round;
    for (const SavedCrowds::SavedBlock& block : memory.blocks) {
        density_.for_each_cell(block.block, [&](Place p) {
            calm_.set_passable(map_.cell(p), map_.passable(p) && density_.crowding()[p] == 0);
        });
    }
    for (std::size_t g = 0; g < kGoals; ++g) {
        const SavedCrowds::SavedGoal& from = memory.goals[g];
        if (from.place == ~0U) {
            continue;
        }
        if (from.place >= map_.places() || !map_.contains(map_.cell(from.place))) {
            return false;
        }
        CrowdGoal& goal = goals_[g];
        goal.cell = map_.cell(from.place);
        goal.used = from.used;
        goal.answers = from.answers;
        goal.state = from.answers ? GoalState::kDone : GoalState::kWanted;
        if (from.answers) {
            goal.field.build(map_, density_.crowding(), goal.cell);
            goal.costs.assign(goal.field.costs().begin(), goal.field.costs().end());
        }
    }
    return true;
}

std::size_t CrowdPaths::bytes() const {
    std::size_t bytes = map_.places() * (sizeof(float) + 3 * sizeof(Crowding));
    for (const CrowdGoal& goal : goals_) {
        bytes += goal.field.bytes() + goal.costs.capacity() * sizeof(Cost);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
