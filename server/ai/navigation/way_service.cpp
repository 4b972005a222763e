#include "server/ai/navigation/way_service.h"

#include "server/ai/navigation/line_of_sight.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::navigation {

namespace {

// What things cost in units; measured once and rounded, since only their ratios matter.
constexpr std::uint64_t kQueryUnits = 600;  ///< a way by looking it up, put together
constexpr std::uint64_t kNodeUnits = 80;    ///< a node of a search
constexpr std::uint64_t kHopUnits = 8;      ///< a step along a field or through an area
constexpr std::uint64_t kFieldUnits = 6;    ///< a cell of a field that is made
constexpr std::uint64_t kAreaUnits = 40;    ///< an area of a table to a goal's area
/// A field must save so many times what it costs.
constexpr std::uint64_t kFieldGain = 2;
/// Tables to all goals' areas are made beforehand where there are no more areas.
constexpr std::size_t kMostTables = 1500;
/// Cells or corners looked at on the last leg of a way from area to area.
constexpr std::uint32_t kAreaSearch = 500;
/// Who waits is sent ahead by so many cells.
constexpr int kLegCells = 8;
/// Who stands where nothing is passable looks for a cell as far away, in cells.
constexpr int kBesideReach = 3;

float distance(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

}  // namespace

WayService::WayService(GroundMap map, const WaySettings& settings)
    : settings_(settings),
      grid_(map.grid),
      planner_(std::move(map.cells)),
      areas_(planner_.map()),
      queue_(settings.longest_wait_ticks - 1),
      wanted_(planner_.map().places(), 0) {
    ZONED_ASSERT(settings.work_per_tick > 0 && settings.longest_wait_ticks > 0 &&
                     settings.search_work > 0 && settings.reach_cells >= 0,
                 "settings of ways");
    planner_.prepare(settings.index);
    for (; next_table_ < areas_.areas() && areas_.areas() <= kMostTables; ++next_table_) {
        areas_.prepare(next_table_);
    }
    // No way has more corners, pulled or not.
    cells_.reserve(planner_.map().passable_cells() + std::size_t{2});
}

WayTicket WayService::ask(const WayAsk& ask) {
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(slots_.size()));
        slots_.emplace_back();
        free_.reserve(slots_.capacity());
    }
    const std::uint32_t number = free_.back();
    free_.pop_back();
    Slot& slot = slots_[number];
    const std::uint32_t round = slot.round;
    slot = Slot();
    slot.round = round;
    slot.asker = ask.asker == WayAsk::kAlone ? number : ask.asker;
    slot.at = ask.from;
    slot.to = ask.to;
    slot.taken = true;
    ++counts_.asked;
    if (!grid_.contains(ask.from) || !grid_.contains(ask.to)) {
        fail(number, Outcome::kOffMap);
    } else if (find_ends(number)) {
        wait(number);
        if (!areas_.prepared(planner_.map(), slot.goal) && spent_ < settings_.work_per_tick) {
            areas_.prepare(planner_.map(), slot.goal);
            spent_ += kAreaUnits * areas_.areas();
        }
    }
    return {number, slot.round};
}

bool WayService::find_ends(std::uint32_t number) {
    Slot& slot = slots_[number];
    const GridMap& map = planner_.map();
    // Of a place on the line between two cells the one that it counts to.
    slot.start = grid_.cell(slot.at);
    slot.goal = grid_.cell(slot.to);
    if (!map.passable(slot.start) &&
        !nearest_passable(map, grid_, slot.at, settings_.reach_cells, slot.start)) {
        fail(number, Outcome::kStartBlocked);
        return false;
    }
    if (!map.passable(slot.goal) &&
        !nearest_passable(map, grid_, slot.to, settings_.reach_cells, slot.goal)) {
        fail(number, Outcome::kGoalBlocked);
        return false;
    }
    slot.moved = slot.goal != grid_.cell(slot.to);
    return true;
}

bool WayService::reaches(Spot from, Cell to) {
    Cell start = grid_.cell(from);
    return (planner_.map().passable(start) ||
            nearest_passable(planner_.map(), grid_, from, settings_.reach_cells, start)) &&
           planner_.joined(start, to);
}

void WayService::wait(std::uint32_t number) {
    Slot& slot = slots_[number];
    slot.waiting = true;
    ++wanted_[planner_.map().place(slot.goal)];
    ++counts_.waiting;
    queue_.push(number, slot.asker);
}

void WayService::lead_waiting() {
    std::size_t led = 0;
    for (; led < unled_.size() && spent_ < settings_.work_per_tick; ++led) {
        const Slot& slot = slots_[unled_[led]];
        if (slot.taken && slot.waiting && !slot.usable &&
            !areas_.prepared(planner_.map(), slot.goal)) {
            areas_.prepare(planner_.map(), slot.goal);
            spent_ += kAreaUnits * areas_.areas();
        }
    }
    unled_.erase(unled_.begin(), unled_.begin() + static_cast<std::ptrdiff_t>(led));
}

void WayService::release(WayTicket ticket) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    Slot& slot = slots_[ticket.slot];
    slot.taken = false;
    ++slot.round;
    pool_.give_back(slot.corners);
    slot.corners = {};
    if (slot.waiting) {  // stays in its queue until its turn
        --wanted_[planner_.map().place(slot.goal)];
        --counts_.waiting;
        return;
    }
    free_.push_back(ticket.slot);
}

void WayService::serve() {
    ++tick_;
    const std::uint32_t required = queue_.required();
    std::uint32_t served = 0;
    while (!queue_.empty()) {
        const std::uint32_t number = queue_.front();
        Slot& slot = slots_[number];
        if (!slot.taken) {
            queue_.pop();
            slot.waiting = false;
            free_.push_back(number);
            ++served;
            continue;
        }
        const bool late = spent_ >= settings_.work_per_tick;
        if (late && served >= required) {
            break;
        }
        if (!refresh(number)) {
            ++served;
            queue_.pop();
            continue;
        }
        if (!find(slot, late)) {
            continue;  // the tick's work is done: whoever is due is served as one that is late
        }
        ++served;
        counts_.longest_wait_ticks = std::max(counts_.longest_wait_ticks, queue_.waited() + 1);
        queue_.pop();
        done(number);
    }
    queue_.tick();
    lead_waiting();
    if (!indexed_) {
        indexed_ = planner_.advance_index(settings_.index_work_per_tick);
    }
    while (spent_ < settings_.work_per_tick && next_table_ < areas_.areas() &&
           areas_.areas() <= kMostTables) {
        areas_.prepare(next_table_++);
        spent_ += kAreaUnits * areas_.areas();
    }
    counts_.work = spent_;
    spent_ = 0;
    std::swap(told_, answered_);
    answered_.clear();
}

bool WayService::refresh(std::uint32_t number) {
    Slot& slot = slots_[number];
    const Place before = planner_.map().place(slot.goal);
    const bool found = find_ends(number);
    const Place after = planner_.map().place(slot.goal);
    if (!found) {
        slot.waiting = false;
        --counts_.waiting;
        --wanted_[before];
    } else if (after != before) {
        --wanted_[before];
        ++wanted_[after];
    }
    return found;
}

void WayService::done(std::uint32_t number) {
    Slot& slot = slots_[number];
    slot.waiting = false;
    ++counts_.served;
    --counts_.waiting;
    --wanted_[planner_.map().place(slot.goal)];
    if (slot.moved && slot.outcome == Outcome::kFound) {
        slot.outcome = Outcome::kPartial;
    }
    keep(slot);
    answered_.push_back(number);
}

void WayService::fail(std::uint32_t number, Outcome outcome) {
    Slot& slot = slots_[number];
    answered_.push_back(number);
    slot.outcome = outcome;
    slot.usable = false;
    pool_.give_back(slot.corners);
    slot.corners = {};
    ++counts_.served;
}

bool WayService::find(Slot& slot, bool cheaply) {
    const GridMap& map = planner_.map();
    slot.outcome = Outcome::kFound;
    slot.best = true;
    std::uint32_t looked = 0;
    const bool straight = sees(map, slot.start, slot.goal, looked);
    spent_ += looked + 1;
    if (straight) {
        cells_.assign({slot.start, slot.goal});
        ++counts_.straight;
        return true;
    }
    if (find_by_field(slot)) {
        return true;
    }
    if (cheaply) {
        find_by_areas(slot);
        return true;
    }
    if (worth_a_field(slot)) {
        if (!make_field(slot.goal)) {
            return false;
        }
        if (find_by_field(slot)) {
            return true;
        }
    }
    find_by_planner(slot);
    return true;
}

bool WayService::worth_a_field(const Slot& slot) const {
    const GridMap& map = planner_.map();
    const std::uint64_t by_planner = wanted_[map.place(slot.goal)] * typical_work_;
    return by_planner > kFieldGain * kFieldUnits * map.passable_cells();
}

bool WayService::make_field(Cell goal) {
    const GridMap& map = planner_.map();
    if (building_ != map.place(goal)) {
        builder_.begin(map, goal);
        building_ = map.place(goal);
    }
    while (spent_ < settings_.work_per_tick) {
        const std::uint64_t left = (settings_.work_per_tick - spent_) / kFieldUnits + 1;
        const auto cells =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(left, map.passable_cells()));
        spent_ += kFieldUnits * cells;
        if (builder_.advance(map, cells)) {
            Field& oldest = *std::min_element(
                fields_.begin(), fields_.end(), [](const Field& a, const Field& b) {
                    return a.used < b.used;
                });
            builder_.copy_hops(oldest.hops);
            oldest.goal = building_;
            oldest.used = tick_;
            building_ = kNoPlace;
            ++counts_.fields;
            return true;
        }
    }
    return false;
}

bool WayService::find_by_field(Slot& slot) {
    const GridMap& map = planner_.map();
    const Place goal = map.place(slot.goal);
    const auto field = std::find_if(
        fields_.begin(), fields_.end(), [goal](const Field& f) { return f.goal == goal; });
    if (field == fields_.end() || field->hops[map.place(slot.start)] == kNoHop) {
        return false;
    }
    field->used = tick_;
    cells_.assign(1, slot.start);
    walk([&](Cell c) { return field->hops[map.place(c)]; });
    ++counts_.by_field;
    return true;
}

void WayService::append(Cell c, bool straight_on) {
    if (straight_on) {
        cells_.back() = c;
    } else {
        cells_.push_back(c);
    }
}

template <class HopAt>
void WayService::walk(const HopAt& hop_at) {
    std::uint32_t steps = 0;
    Hop last = kNoHop;
    Cell c = cells_.back();
    for (Hop hop = hop_at(c); hop < kArrived; hop = hop_at(c)) {
        c = hopped(c, hop);
        append(c, hop == last);
        last = hop;
        ++steps;
        ZONED_ASSERT(steps <= planner_.map().passable_cells(), "hops lead nowhere twice");
    }
    spent_ += kHopUnits * steps;
}

void WayService::find_by_planner(Slot& slot) {
    Query query;
    query.start = slot.start;
    query.goal = slot.goal;
    query.max_work = settings_.search_work;
    query.nearest = true;
    const Answer found = planner_.plan(query);
    const std::uint64_t work = kQueryUnits + kNodeUnits * found.work;
    spent_ += work;
    typical_work_ = (7 * typical_work_ + work) / 8;
    slot.outcome = found.outcome;
    if (found.outcome == Outcome::kCutOff) {
        find_by_areas(slot);
        return;
    }
    const std::span<const Cell> corners = planner_.way().corners();
    cells_.assign(corners.begin(), corners.end());
}

void WayService::find_by_areas(Slot& slot) {
    const GridMap& map = planner_.map();
    if (!areas_.prepared(map, slot.goal)) {
        areas_.prepare(map, slot.goal);
        spent_ += kAreaUnits * areas_.areas();
    }
    if (!areas_.together(map, slot.start, slot.goal) &&
        areas_.hop(map, slot.start, slot.goal) == kNoHop) {
        // No way, or one that a search found too long to finish: as far as that came.
        if (slot.outcome != Outcome::kCutOff) {
            find_by_planner(slot);
            return;
        }
        const std::span<const Cell> corners = planner_.way().corners();
        cells_.assign(corners.begin(), corners.end());
        slot.best = false;
        return;
    }
    cells_.assign(1, slot.start);
    Hop last = kNoHop;
    std::uint32_t steps = 0;
    areas_.lead(map, slot.start, slot.goal, [&](Cell c, Hop hop) {
        append(c, hop == last);
        last = hop;
        ++steps;
        return true;
    });
    spent_ += kHopUnits * steps;
    walk_within_area(slot.goal);
    slot.outcome = Outcome::kFound;
    slot.best = false;
    ++counts_.by_areas;
}

void WayService::walk_within_area(Cell goal) {
    const GridMap& map = planner_.map();
    Query query;
    query.start = cells_.back();
    query.goal = goal;
    query.max_work = kAreaSearch;
    const Answer found = planner_.plan(query);
    spent_ += kQueryUnits + kNodeUnits * found.work;
    if (found.outcome == Outcome::kFound) {
        const std::span<const Cell> corners = planner_.way().corners();
        cells_.insert(cells_.end(), corners.begin() + 1, corners.end());
        return;
    }
    // A search that lost its way beyond the square: within it there is one.
    const GoalField::Window w = areas_.window(map, goal);
    near_goal_.build(map, goal, w);
    spent_ +=
        kFieldUnits * static_cast<std::uint64_t>((w.right - w.left + 1) * (w.bottom - w.top + 1));
    walk([&](Cell c) { return near_goal_.hop(map.place(c)); });
}

void WayService::keep(Slot& slot) {
    std::uint32_t looked = 0;
    pull(planner_.map(), cells_, looked);
    spent_ += looked;
    slot.corners =
        pool_.take(static_cast<std::uint32_t>(std::max<std::size_t>(cells_.size(), 2) - 1));
    const std::span<Spot> corners = pool_.of(slot.corners);
    for (std::size_t i = 1; i < cells_.size(); ++i) {
        corners[i - 1] = grid_.centre(cells_[i]);
    }
    if (slot.outcome == Outcome::kFound) {
        corners.back() = slot.to;  // in the cell of the goal itself
    } else if (cells_.size() < 2) {
        corners.back() = grid_.centre(slot.start);
    }
    slot.usable = true;
    slot.next = 0;
    slot.ahead = corners.front();
    slot.length_m = distance(slot.at, slot.ahead);
    slot.rest_m = 0.0F;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        slot.rest_m += distance(corners[i - 1], corners[i]);
    }
    slot.length_m += slot.rest_m;
    slot.low = slot.high = grid_.centre(slot.start);
    for (const Spot& c : corners) {
        slot.low = {std::min(slot.low.x, c.x), std::min(slot.low.z, c.z)};
        slot.high = {std::max(slot.high.x, c.x), std::max(slot.high.z, c.z)};
    }
}

WayAnswer WayService::answer(WayTicket ticket) const {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    const Slot& slot = slots_[ticket.slot];
    if (slot.waiting && !slot.usable) {
        return {};
    }
    return {false, slot.outcome, slot.best, slot.length_m, pool_.of(slot.corners)};
}

Spot WayService::heading(WayTicket ticket, Spot at, float near_m) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    Slot& slot = slots_[ticket.slot];
    slot.at = at;
    if (slot.waiting && !slot.usable) {
        return first_leg(slot, at);
    }
    const std::span<const Spot> corners = std::as_const(pool_).of(slot.corners);
    if (corners.empty()) {
        return at;
    }
    while (slot.next + 1 < corners.size() && distance(at, corners[slot.next]) <= near_m) {
        slot.rest_m -= distance(corners[slot.next], corners[slot.next + 1]);
        ++slot.next;
        slot.ahead = corners[slot.next];
    }
    return corners[slot.next];
}

Spot WayService::first_leg(const Slot& slot, Spot at) const {
    const GridMap& map = planner_.map();
    Cell from;
    if (!nearest_passable(map, grid_, at, kBesideReach, from)) {
        return at;
    }
    if (areas_.together(map, from, slot.goal)) {
        return slot.moved ? grid_.centre(slot.goal) : slot.to;
    }
    if (!areas_.prepared(map, slot.goal)) {
        return at;
    }
    // As far along the hops as can be seen from here.
    Cell ahead = from;
    std::uint32_t looked = 0;
    int cells = 0;
    areas_.lead(map, from, slot.goal, [&](Cell c, Hop) {
        if (!sees(map, from, c, looked)) {
            return false;
        }
        ahead = c;
        return ++cells < kLegCells;
    });
    return ahead == from ? at : grid_.centre(ahead);
}

std::size_t WayService::bytes() const {
    std::size_t bytes = areas_.bytes() + planner_.index_bytes() + pool_.bytes() + builder_.bytes() +
                        near_goal_.bytes() + slots_.capacity() * sizeof(Slot) +
                        wanted_.capacity() * sizeof(std::uint32_t);
    for (const Field& f : fields_) {
        bytes += f.hops.capacity();
    }
    return bytes;
}

}  // namespace zoned::ai::navigation
