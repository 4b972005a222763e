#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace zoned::ai::pathfinding {

namespace {

/// A short cut must gain more than rounding, m.
constexpr float kGain_m = 1e-3F;
/// Up to this many closed cells, each is tested against each segment; beyond, the segment is walked
/// along.
constexpr std::size_t kFewCells = 32;
/// Corners are prefetched this many paths ahead.
constexpr std::size_t kAhead = 6;
/// Octile lengths are up to 1 / cos(pi / 8) times the straight line.
constexpr float kOctileOver = 1.0824F;
/// Cells within a reach that is counted by columns and rows are at most this many times farther.
constexpr float kReachOver = 1.4143F;

float apart(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

/// The distance of a place from a box.
float off(Spot s, Spot low, Spot high) {
    return apart(s, {std::clamp(s.x, low.x, high.x), std::clamp(s.z, low.z, high.z)});
}

}  // namespace

bool GridPathRequests::sort_changes(std::span<const CellChange> changes) {
    opened_.clear();
    closed_.clear();
    for (const CellChange& c : changes) {
        if (planner_.map().passable(c.cell) == c.passable) {
            continue;
        }
        if (c.passable) {
            opened_.push_back(grid_.centre(c.cell));
        } else {
            closed_.push_back(c.cell);
        }
    }
    return !opened_.empty() || !closed_.empty();
}

GridPathRequests::Gap GridPathRequests::gap() const {
    Gap gap{opened_, {}, {}};
    if (!opened_.empty()) {
        const auto [left, right] = std::minmax_element(
            opened_.begin(), opened_.end(), [](Spot a, Spot b) { return a.x < b.x; });
        const auto [top, bottom] = std::minmax_element(
            opened_.begin(), opened_.end(), [](Spot a, Spot b) { return a.z < b.z; });
        gap.low = {left->x, top->z};
        gap.high = {right->x, bottom->z};
    }
    return gap;
}

GridPathRequests::Closed GridPathRequests::closed() const {
    constexpr int kMost = std::numeric_limits<int>::max();
    Closed closed{closed_, {kMost, kMost, -1, -1}, {}};
    for (const Cell& c : closed_) {
        closed.around = {std::min<int>(closed.around.left, c.x),
                         std::min<int>(closed.around.top, c.y),
                         std::max<int>(closed.around.right, c.x),
                         std::max<int>(closed.around.bottom, c.y)};
        add_blocks(closed.blocks, c, c);
    }
    return closed;
}

/// Freeing the old index in parts has no saved form: where nobody asks, it goes at once.
void GridPathRequests::renew_index() {
    if (index_given_ == 0) {
        return;
    }
    renewing_ = !nobody_asks();
    if (!renewing_) {
        planner_.drop_index();
    }
    planner_.begin_index(settings_.index);
    index_given_ = 1;
    indexed_ = false;
}

void GridPathRequests::change(std::span<const CellChange> changes) {
    requeued_.clear();
    if (!sort_changes(changes)) {
        return;
    }
    planner_.change(changes);
    if (crowd_ != nullptr) {
        crowd_->change(changes);
    }
    renew_index();
    regions_.note(changes);
    for (CachedFlowField& f : fields_) {
        f.goal = kNoPlace;
        f.used = 0;
    }
    building_ = kNoPlace;
    const Gap gap = this->gap();
    const Closed closed = this->closed();
    // Few words of the blocks have bits in them.
    std::array<std::size_t, std::tuple_size_v<Blocks>> words{};
    std::size_t count = 0;
    for (std::size_t w = 0; w < closed.blocks.size(); ++w) {
        if (closed.blocks[w] != 0) {
            words[count++] = w;
        }
    }
    near_.clear();
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
        const bool near = std::any_of(words.begin(), words.begin() + count, [&](std::size_t w) {
            return (blocks_[i][w] & closed.blocks[w]) != 0;
        });
        if (near || !opened_.empty()) {
            near_.push_back(2 * i + (near ? 1 : 0));
        }
    }
    // Their corners lie all over the pool: asked for before their turn.
    for (std::size_t i = 0; i < near_.size(); ++i) {
        if (i + kAhead < near_.size() && (near_[i + kAhead] & 1U) != 0) {
            pool_.fetch(slots_[near_[i + kAhead] / 2].corners);
        }
        if (slots_[near_[i] / 2].taken) {
            review(near_[i] / 2, (near_[i] & 1U) != 0, gap, closed);
        }
    }
}

void GridPathRequests::review(std::uint32_t number,
                              bool near,
                              const Gap& gap,
                              const Closed& closed) {
    RequestSlot& slot = slots_[number];
    const bool broken = near && slot.usable && cut(slot, closed);
    const bool longer = !broken && !gap.middles.empty() && may_be_shorter(slot, gap);
    if (!broken && !longer) {
        return;
    }
    if (broken) {
        slot.usable = false;
        ++counts_.broken;
    } else {
        ++counts_.reviewed;
    }
    requeued_.push_back(number);
    if (!slot.waiting) {
        slot.waiting = true;
        ++counts_.waiting;
        to_queue_.push_back(number);
    }
}

void GridPathRequests::queue_again() {
    const GridMap& map = planner_.map();
    for (const std::uint32_t number : to_queue_) {
        RequestSlot& slot = slots_[number];
        slot.waiting = false;
        --counts_.waiting;
        // Its ends are found again when its turn comes.
        if (map.passable(slot.goal) || find_ends(number)) {
            wait(number);
            if (!slot.usable) {
                unled_.push_back(number);
            }
        }
    }
    to_queue_.clear();
}

/// True if one of the remaining segments of a path leads through a closed cell.
bool GridPathRequests::cut(const RequestSlot& slot, const Closed& closed) const {
    const std::span<const Spot> corners = pool_.of(slot.corners);
    // Most segments lie far from it. Two cells cover the distance from a cell's middle to any place
    // in it.
    const auto at = [this](int x, int y) {
        return Spot{grid_.min_x() + static_cast<float>(x) * grid_.cell_m(),
                    grid_.min_z() + static_cast<float>(y) * grid_.cell_m()};
    };
    const Spot low = at(closed.around.left - 2, closed.around.top - 2);
    const Spot high = at(closed.around.right + 3, closed.around.bottom + 3);
    // By which sides of the box a place lies beyond it: a segment whose ends share one passes it
    // by.
    const auto beyond = [&](Spot spot) {
        return static_cast<unsigned>(spot.x < low.x) |
               static_cast<unsigned>(spot.x > high.x) << 1U |
               static_cast<unsigned>(spot.z < low.z) << 2U |
               static_cast<unsigned>(spot.z > high.z) << 3U;
    };
    Spot before = slot.next == 0 ? grid_.centre(slot.start) : corners[slot.next - 1];
    unsigned side = beyond(before);
    for (std::size_t i = slot.next; i < corners.size(); ++i) {
        const Spot after = corners[i];
        const unsigned next_side = beyond(after);
        if ((side & next_side) == 0 && leads_through(before, after, closed)) {
            return true;
        }
        before = after;
        side = next_side;
    }
    return false;
}

/// True if a segment that was free leads through a closed cell.
bool GridPathRequests::leads_through(Spot from, Spot to, const Closed& closed) const {
    const Cell a = grid_.cell(from);
    const Cell b = grid_.cell(to);
    if (closed.cells.size() <= kFewCells) {
        return std::any_of(
            closed.cells.begin(), closed.cells.end(), [&](Cell c) { return touches(a, b, c); });
    }
    std::uint32_t looked = 0;
    return !sees(planner_.map(), a, b, looked);
}

/// True if a path through the opened cells could be shorter than the rest of this one, or lead
/// nearer to the goal.
bool GridPathRequests::may_be_shorter(const RequestSlot& slot, const Gap& gap) const {
    if (slot.waiting || slot.outcome == PathOutcome::kOffMap) {
        return false;
    }
    if (!slot.usable) {
        // Nothing passable was near enough to one of its ends.
        const float reach =
            kReachOver * static_cast<float>(settings_.reach_cells + 1) * grid_.cell_m();
        return std::any_of(gap.middles.begin(), gap.middles.end(), [&](const Spot& middle) {
            return std::min(apart(slot.at, middle), apart(slot.to, middle)) <= reach;
        });
    }
    const bool there = slot.outcome == PathOutcome::kFound;
    const Spot end = there ? slot.to : pool_.of(slot.corners).back();
    if (!there && may_come_nearer(slot, gap, end)) {
        return true;
    }
    // No cell of the gap is nearer to both ends than its box.
    const float least = off(slot.at, gap.low, gap.high) + off(end, gap.low, gap.high) + kGain_m;
    const float left = apart(slot.at, slot.ahead) + slot.rest_m;
    return least < left &&
           std::any_of(gap.middles.begin(), gap.middles.end(), [&](const Spot& middle) {
               return apart(slot.at, middle) + apart(middle, end) + kGain_m < left;
           });
}

/// True if a request whose path ends short of its goal may get nearer to it now. New cells are
/// reachable only where components were joined, or by the opened cells themselves.
bool GridPathRequests::may_come_nearer(const RequestSlot& slot, const Gap& gap, Spot end) const {
    const Cell last = grid_.cell(end);
    if (slot.outcome != PathOutcome::kPartial || !planner_.map().passable(last) ||
        planner_.joined_anew(last)) {
        return true;
    }
    // Cells count by octile lengths from that which stands for the goal.
    const float moved = apart(slot.to, grid_.centre(slot.goal));
    const float near = kOctileOver * (apart(slot.to, end) + moved) + moved + grid_.cell_m();
    return off(slot.to, gap.low, gap.high) <= near &&
           std::any_of(gap.middles.begin(), gap.middles.end(), [&](const Spot& middle) {
               return apart(slot.to, middle) <= near;
           });
}

}  // namespace zoned::ai::pathfinding
