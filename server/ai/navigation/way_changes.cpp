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

}  // namespace

void WayService::change(std::span<const CellChange> changes) {
    requeued_.clear();
    bool opened = false;
    GoalField::Window closed{
        std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), -1, -1};
    bool changed = false;
    for (const CellChange& c : changes) {
        if (planner_.map().passable(c.cell) == c.passable) {
            continue;
        }
        changed = true;
        opened = opened || c.passable;
        if (!c.passable) {
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
    }
    building_ = kNoPlace;
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[i];
        if (!slot.taken) {
            continue;
        }
        const bool broken = slot.usable && closed.right >= 0 && cut(slot, closed);
        const bool longer = !broken && opened && may_be_shorter(slot, changes);
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
        if ((broken || longer) && !slot.waiting && find_ends(i)) {
            wait(i);
        }
    }
}

/// Whether one of the legs that are left of a way leads through something blocked; `around` holds
/// all that was closed.
bool WayService::cut(const Slot& slot, const GoalField::Window& around) const {
    const std::span<const Spot> corners = pool_.of(slot.corners);
    Cell from = slot.next == 0 ? slot.start : grid_.cell(corners[slot.next - 1]);
    std::uint32_t looked = 0;
    for (std::size_t i = slot.next; i < corners.size(); ++i) {
        const Cell to = grid_.cell(corners[i]);
        const bool near = std::min(from.x, to.x) <= around.right + 1 &&
                          std::max(from.x, to.x) + 1 >= around.left &&
                          std::min(from.y, to.y) <= around.bottom + 1 &&
                          std::max(from.y, to.y) + 1 >= around.top;
        if (near && !sees(planner_.map(), from, to, looked)) {
            return true;
        }
        from = to;
    }
    return false;
}

/// Whether a way through what was opened could be shorter than what is left of this one, or lead to
/// the goal at all.
bool WayService::may_be_shorter(const Slot& slot, std::span<const CellChange> changes) const {
    if (slot.waiting || slot.outcome == Outcome::kOffMap) {
        return false;
    }
    if (!slot.usable || slot.outcome != Outcome::kFound) {
        return true;
    }
    const std::span<const Spot> corners = pool_.of(slot.corners);
    float left = 0.0F;
    Spot from = slot.at;
    for (std::size_t i = slot.next; i < corners.size(); ++i) {
        left += apart(from, corners[i]);
        from = corners[i];
    }
    return std::any_of(changes.begin(), changes.end(), [&](const CellChange& c) {
        const Spot middle = grid_.centre(c.cell);
        return c.passable && apart(slot.at, middle) + apart(middle, slot.to) + kGain_m < left;
    });
}

}  // namespace zoned::ai::navigation
