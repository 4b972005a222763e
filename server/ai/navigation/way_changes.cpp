#include "server/ai/navigation/line_of_sight.h"
#include "server/ai/navigation/way_service.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai::navigation {

namespace {

/// A short cut must gain more than rounding, m.
constexpr float kGain_m = 1e-3F;

float apart(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

/// Whether the line between the middles of two cells comes into the window or next to it.
bool passes(Cell from, Cell to, const GoalField::Window& w) {
    const int left = w.left - 1;
    const int right = w.right + 1;
    const int top = w.top - 1;
    const int bottom = w.bottom + 1;
    if (std::min(from.x, to.x) > right || std::max(from.x, to.x) < left ||
        std::min(from.y, to.y) > bottom || std::max(from.y, to.y) < top) {
        return false;
    }
    // Not where all corners of the window lie on one side of it.
    const int dx = to.x - from.x;
    const int dy = to.y - from.y;
    const auto side = [&](int x, int y) {
        return dx * (y - from.y) - dy * (x - from.x);
    };
    const int a = side(left, top);
    const int b = side(right, top);
    const int c = side(left, bottom);
    const int d = side(right, bottom);
    return std::min({a, b, c, d}) <= 0 && std::max({a, b, c, d}) >= 0;
}

/// How far a place lies from a box.
float off(Spot s, Spot low, Spot high) {
    return apart(s, {std::clamp(s.x, low.x, high.x), std::clamp(s.z, low.z, high.z)});
}

}  // namespace

void WayService::change(std::span<const CellChange> changes) {
    requeued_.clear();
    opened_.clear();
    GoalField::Window closed{
        std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), -1, -1};
    bool changed = false;
    for (const CellChange& c : changes) {
        if (planner_.map().passable(c.cell) == c.passable) {
            continue;
        }
        changed = true;
        if (c.passable) {
            opened_.push_back(grid_.centre(c.cell));
        } else {
            closed = {std::min<int>(closed.left, c.cell.x),
                      std::min<int>(closed.top, c.cell.y),
                      std::max<int>(closed.right, c.cell.x),
                      std::max<int>(closed.bottom, c.cell.y)};
        }
    }
    if (!changed) {
        return;
    }
    planner_.change(changes);
    planner_.begin_index(settings_.index);
    indexed_ = false;
    areas_.update(planner_.map(), changes);
    next_table_ = 0;
    for (Field& f : fields_) {
        f.goal = kNoPlace;
        f.used = 0;
    }
    building_ = kNoPlace;
    Gap gap{opened_, {}, {}};
    if (!opened_.empty()) {
        const auto [left, right] = std::minmax_element(
            opened_.begin(), opened_.end(), [](Spot a, Spot b) { return a.x < b.x; });
        const auto [top, bottom] = std::minmax_element(
            opened_.begin(), opened_.end(), [](Spot a, Spot b) { return a.z < b.z; });
        gap.low = {left->x, top->z};
        gap.high = {right->x, bottom->z};
    }
    Blocks touched{};
    if (closed.right >= 0) {
        // A line may touch what it passes by a corner.
        const auto at = [](int x, int y) {
            return Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        };
        add_blocks(touched,
                   at(std::max(closed.left - 1, 0), std::max(closed.top - 1, 0)),
                   at(std::min(closed.right + 1, grid_.width() - 1),
                      std::min(closed.bottom + 1, grid_.height() - 1)));
    }
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
        const Blocks& led = blocks_[i];
        const bool near = ((led[0] & touched[0]) | (led[1] & touched[1]) | (led[2] & touched[2]) |
                           (led[3] & touched[3])) != 0;
        Slot& slot = slots_[i];
        if ((!near && opened_.empty()) || !slot.taken) {
            continue;
        }
        const bool broken = near && slot.usable && cut(slot, closed);
        const bool longer = !broken && !opened_.empty() && may_be_shorter(slot, gap);
        if (broken) {
            slot.usable = false;
            ++counts_.broken;
        }
        if (longer) {
            ++counts_.reviewed;
        }
        if (broken || longer) {
            requeued_.push_back(i);
        }
        // Its ends are looked for anew when its turn comes.
        if ((broken || longer) && !slot.waiting &&
            (planner_.map().passable(slot.goal) || find_ends(i))) {
            wait(i);
            if (broken) {
                unled_.push_back(i);
            }
        }
    }
}

/// Whether one of the legs that are left of a way leads through something blocked; `around` holds
/// all that was closed.
bool WayService::cut(const Slot& slot, const GoalField::Window& around) const {
    const std::span<const Spot> corners = pool_.of(slot.corners);
    // Most legs lie far from it: two cells are more than what is in a cell but not in its middle.
    const auto at = [this](int x, int y) {
        return Spot{grid_.min_x() + static_cast<float>(x) * grid_.cell_m(),
                    grid_.min_z() + static_cast<float>(y) * grid_.cell_m()};
    };
    const Spot low = at(around.left - 2, around.top - 2);
    const Spot high = at(around.right + 3, around.bottom + 3);
    Spot before = slot.next == 0 ? grid_.centre(slot.start) : corners[slot.next - 1];
    std::uint32_t looked = 0;
    for (std::size_t i = slot.next; i < corners.size(); ++i) {
        const Spot after = corners[i];
        if (std::min(before.x, after.x) <= high.x && std::max(before.x, after.x) >= low.x &&
            std::min(before.z, after.z) <= high.z && std::max(before.z, after.z) >= low.z) {
            const Cell from = grid_.cell(before);
            const Cell to = grid_.cell(after);
            if (passes(from, to, around) && !sees(planner_.map(), from, to, looked)) {
                return true;
            }
        }
        before = after;
    }
    return false;
}

/// Whether a way through what was opened could be shorter than what is left of this one, or lead to
/// the goal at all.
bool WayService::may_be_shorter(const Slot& slot, const Gap& gap) const {
    if (slot.waiting || slot.outcome == Outcome::kOffMap) {
        return false;
    }
    if (!slot.usable || slot.outcome != Outcome::kFound) {
        return true;
    }
    // No cell of the gap is nearer to both ends than its box.
    const float least = off(slot.at, gap.low, gap.high) + off(slot.to, gap.low, gap.high) + kGain_m;
    const float left = apart(slot.at, slot.ahead) + slot.rest_m;
    return least < left &&
           std::any_of(gap.middles.begin(), gap.middles.end(), [&](const Spot& middle) {
               return apart(slot.at, middle) + apart(middle, slot.to) + kGain_m < left;
           });
}

}  // namespace zoned::ai::navigation
