#include "server/ai/pathfinding/requests/grid_path_requests.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/grid/work_units.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// The assumed cost of a path from region to region before one was made.
constexpr std::uint64_t kFirstCheapWork = 4000;
/// One so-manieth of the work that is left of a tick goes into the index.
constexpr std::uint64_t kIndexShare = 4;
/// The mean is taken over about so many values.
constexpr std::uint64_t kMeanOver = 16;
/// A waiting agent is sent ahead by this many cells.
constexpr int kSegmentCells = 8;
/// An agent on a blocked cell looks for a passable one this far away, in cells.
constexpr int kBesideReach = 3;

float distance(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

}  // namespace

GridPathRequests::GridPathRequests(GroundMap map,
                                   const GridPathSettings& settings,
                                   const GridMap* most_open)
    : settings_(settings),
      grid_(map.grid),
      planner_(std::move(map.cells)),
      regions_(planner_.map(), settings.tables),
      queue_(settings.longest_wait_ticks - 1),
      cheap_work_(kFirstCheapWork),
      budget_(settings.work_per_tick) {
    ZONED_ASSERT(settings.work_per_tick > 0 && settings.longest_wait_ticks > 0 &&
                     settings.search_work > 0 && settings.reach_cells >= 0,
                 "settings of paths");
    if (most_open != nullptr) {
        planner_.know_most_open(*most_open);
    }
    planner_.use(settings.search);
    planner_.label_components();
    if (index_price() <= settings.index_at_start) {
        planner_.prepare(settings.index);
        index_given_ = kAllUnits;
    }
    while ((std::max(grid_.width(), grid_.height()) - 1) >> block_shift_ >= int{kBlocks}) {
        ++block_shift_;
    }
    while (regions_.lacks_tables()) {
        regions_.prepare_next(tick_);
    }
    if (settings.crowding) {
        crowd_ =
            std::make_unique<pathfinding::CrowdPaths>(planner_.map(), grid_, *settings.crowding);
    }
    // No path has more corners, pulled or not.
    cells_.reserve(planner_.map().passable_cells() + std::size_t{2});
}

PathRequestId GridPathRequests::ask(const PathRequest& ask) {
    queue_again();
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(slots_.size()));
        slots_.emplace_back();
        blocks_.emplace_back();
        free_.reserve(slots_.capacity());
    }
    const std::uint32_t number = free_.back();
    free_.pop_back();
    RequestSlot& slot = slots_[number];
    const std::uint32_t round = slot.round;
    slot = RequestSlot();
    slot.round = round;
    slot.asker = ask.asker == PathRequest::kAlone ? number : ask.asker;
    slot.at = ask.from;
    slot.to = ask.to;
    slot.taken = true;
    ++counts_.asked;
    if (!grid_.contains(ask.from) || !grid_.contains(ask.to)) {
        fail(number, PathOutcome::kOffMap);
    } else if (find_ends(number)) {
        wait(number);
        // Prepares the hops of waiting agents; the other half is for the paths themselves.
        if (spent_ < settings_.work_per_tick / 2) {
            prepare_table(slot.goal);
        } else {
            unled_.push_back(number);
        }
    }
    return {number, slot.round};
}

bool GridPathRequests::find_ends(std::uint32_t number) {
    RequestSlot& slot = slots_[number];
    const GridMap& map = planner_.map();
    // For a place on the line between two cells, the cell to which it counts.
    slot.start = grid_.cell(slot.at);
    slot.goal = grid_.cell(slot.to);
    if (!map.passable(slot.start) &&
        !nearest_passable(map, grid_, slot.at, settings_.reach_cells, slot.start)) {
        fail(number, PathOutcome::kStartBlocked);
        return false;
    }
    if (!map.passable(slot.goal) &&
        !nearest_passable(map, grid_, slot.to, settings_.reach_cells, slot.goal)) {
        fail(number, PathOutcome::kGoalBlocked);
        return false;
    }
    slot.moved = slot.goal != grid_.cell(slot.to);
    return true;
}

bool GridPathRequests::reaches(Spot from, Cell to) {
    Cell start = grid_.cell(from);
    return (planner_.map().passable(start) ||
            nearest_passable(planner_.map(), grid_, from, settings_.reach_cells, start)) &&
           planner_.joined(start, to);
}

void GridPathRequests::wait(std::uint32_t number) {
    RequestSlot& slot = slots_[number];
    slot.waiting = true;
    add_wanted(planner_.map().place(slot.goal));
    ++counts_.waiting;
    queue_.push(number, slot.asker);
}

void GridPathRequests::add_wanted(Place goal) {
    if (std::uint32_t* const count = wanted_.find(goal)) {
        ++*count;
    } else {
        wanted_.insert(goal, 1);
    }
}

void GridPathRequests::remove_wanted(Place goal) {
    std::uint32_t* const count = wanted_.find(goal);
    ZONED_ASSERT(count != nullptr, "a goal that nobody waits for");
    if (--*count == 0) {
        wanted_.erase(goal);
    }
}

void GridPathRequests::lead_waiting() {
    std::size_t led = 0;
    for (; led < unled_.size() && spent_ < settings_.work_per_tick; ++led) {
        const RequestSlot& slot = slots_[unled_[led]];
        if (slot.taken && slot.waiting && !slot.usable) {
            prepare_table(slot.goal);
        }
    }
    unled_.erase(unled_.begin(), unled_.begin() + static_cast<std::ptrdiff_t>(led));
}

void GridPathRequests::release(PathRequestId ticket) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    queue_again();
    RequestSlot& slot = slots_[ticket.slot];
    slot.taken = false;
    ++slot.round;
    drop(ticket.slot);
    if (slot.waiting) {  // stays in its queue until its turn
        remove_wanted(planner_.map().place(slot.goal));
        --counts_.waiting;
        return;
    }
    free_.push_back(ticket.slot);
}

void GridPathRequests::keep_back(std::uint32_t due) {
    budget_ = settings_.work_per_tick - std::min(settings_.work_per_tick, due * cheap_work_);
}

void GridPathRequests::serve_waiting() {
    const std::uint32_t required = queue_.required();
    std::uint32_t served = 0;
    searched_ = false;
    while (!queue_.empty()) {
        const std::uint32_t number = queue_.front();
        RequestSlot& slot = slots_[number];
        if (!slot.taken) {
            queue_.pop();
            slot.waiting = false;
            free_.push_back(number);
            ++served;
            continue;
        }
        keep_back(required > served + 1 ? required - served - 1 : 0);
        const bool late = spent_ >= budget_;
        if (late && served >= required) {
            break;
        }
        const std::uint64_t before = spent_;
        if (!refresh(number)) {
            ++served;
            queue_.pop();
            continue;
        }
        if (std::exchange(slot.doubted, false) && slot.usable && !pays(slot, spent_)) {
            slot.waiting = false;
            --counts_.waiting;
            remove_wanted(planner_.map().place(slot.goal));
            ++served;
            queue_.pop();
            continue;
        }
        if (!find(slot, late)) {
            continue;  // the tick's work is used up: a request that is due is then served as a late
                       // one
        }
        ++served;
        counts_.longest_wait_ticks = std::max(counts_.longest_wait_ticks, queue_.waited() + 1);
        queue_.pop();
        done(number);
        if (late) {
            cheap_work_ = ((kMeanOver - 1) * cheap_work_ + spent_ - before) / kMeanOver;
        }
    }
    budget_ = settings_.work_per_tick;
    queue_.tick();
}

void GridPathRequests::serve() {
    ++tick_;
    settle_regions();
    if (crowd_ != nullptr) {
        counts_.crowd_work = crowd_->advance();
    }
    serve_waiting();
    lead_waiting();
    advance_index();
    while (spent_ < settings_.work_per_tick && regions_.lacks_tables()) {
        regions_.prepare_next(tick_);
        spent_ += kRegionUnits * regions_.regions();
    }
    counts_.work = spent_;
    spent_ = 0;
    std::swap(reported_, answered_);
    answered_.clear();
}

void GridPathRequests::advance_index() {
    counts_.index_work = 0;
    if (index_given_ == 0 && searched_work_ > index_price()) {
        planner_.begin_index(settings_.index);
        indexed_ = false;
    }
    if (indexed_) {
        return;
    }
    // A share of the left-over work goes to the index, too: the sooner it is ready, the cheaper are
    // paths.
    const std::uint64_t left = settings_.work_per_tick - std::min(settings_.work_per_tick, spent_);
    const std::uint64_t share = left / kIndexShare;
    const std::uint64_t units = settings_.index_work_per_tick + share;
    indexed_ = planner_.advance_index(units);
    index_given_ = indexed_ ? kAllUnits : index_given_ + units;
    renewing_ = renewing_ && !indexed_;
    spent_ += std::min(share, planner_.index_work());
    counts_.index_work = planner_.index_work() - std::min(share, planner_.index_work());
}

bool GridPathRequests::refresh(std::uint32_t number) {
    RequestSlot& slot = slots_[number];
    spent_ += kTakeUnits;
    const Place before = planner_.map().place(slot.goal);
    const bool found = find_ends(number);
    const Place after = planner_.map().place(slot.goal);
    if (!found) {
        slot.waiting = false;
        --counts_.waiting;
        remove_wanted(before);
    } else if (after != before) {
        remove_wanted(before);
        add_wanted(after);
    }
    return found;
}

void GridPathRequests::done(std::uint32_t number) {
    RequestSlot& slot = slots_[number];
    slot.waiting = false;
    ++counts_.served;
    --counts_.waiting;
    remove_wanted(planner_.map().place(slot.goal));
    if (slot.moved && slot.outcome == PathOutcome::kFound) {
        slot.outcome = PathOutcome::kPartial;
    }
    keep(number);
    answered_.push_back(number);
}

void GridPathRequests::drop(std::uint32_t number) {
    pool_.give_back(slots_[number].corners);
    slots_[number].corners = {};
    blocks_[number] = {};
}

void GridPathRequests::fail(std::uint32_t number, PathOutcome outcome) {
    RequestSlot& slot = slots_[number];
    answered_.push_back(number);
    slot.outcome = outcome;
    slot.usable = false;
    drop(number);
    ++counts_.served;
}

PathResult GridPathRequests::answer(PathRequestId ticket) const {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    const RequestSlot& slot = slots_[ticket.slot];
    if (slot.waiting && !slot.usable) {
        return {};
    }
    return {false, slot.outcome, slot.best, slot.length_m, pool_.of(slot.corners)};
}

Spot GridPathRequests::heading(PathRequestId ticket, Spot at, float near_m) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    RequestSlot& slot = slots_[ticket.slot];
    slot.at = at;
    if (slot.waiting && !slot.usable) {
        return first_segment(slot, at);
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

Spot GridPathRequests::first_segment(const RequestSlot& slot, Spot at) const {
    const GridMap& map = planner_.map();
    Cell from;
    if (!nearest_passable(map, grid_, at, kBesideReach, from)) {
        return at;
    }
    if (!regions_.settled()) {
        return at;
    }
    if (regions_.together(map, from, slot.goal)) {
        return slot.moved ? grid_.centre(slot.goal) : slot.to;
    }
    if (!regions_.prepared(map, slot.goal)) {
        return at;
    }
    // Goes as far along the hops as can be seen from here.
    Cell ahead = from;
    std::uint32_t looked = 0;
    int cells = 0;
    regions_.lead(map, from, slot.goal, [&](Cell c, Hop) {
        if (!sees(map, from, c, looked)) {
            return false;
        }
        ahead = c;
        return ++cells < kSegmentCells;
    });
    return ahead == from ? at : grid_.centre(ahead);
}

bool GridPathRequests::straight(Spot from, float /*from_y*/, Spot to, float /*to_y*/) const {
    const GridMap& map = planner_.map();
    if (!grid_.contains(from) || !grid_.contains(to) || !map.passable(grid_.cell(from)) ||
        !map.passable(grid_.cell(to))) {
        return false;
    }
    std::uint32_t looked = 0;
    return sees(map, grid_.cell(from), grid_.cell(to), looked);
}

MapExit GridPathRequests::straight_exit(Spot from, float /*from_y*/, Spot to) {
    const GridMap& map = planner_.map();
    const int right = grid_.width() - 1;
    const int bottom = grid_.height() - 1;
    const Spot first = grid_.centre({0, 0});
    const Spot last =
        grid_.centre({static_cast<std::uint16_t>(right), static_cast<std::uint16_t>(bottom)});
    Spot best{std::clamp(to.x, first.x, last.x), std::clamp(to.z, first.z, last.z)};
    float least = std::numeric_limits<float>::infinity();
    const auto consider = [&](int x, int y) {
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const Spot at = grid_.centre(c);
        const float sum = distance(from, at) + distance(at, to);
        if (sum < least && map.passable(c) && reaches(from, c)) {
            least = sum;
            best = at;
        }
    };
    for (int y = 0; y <= bottom && (to.x < first.x || to.x > last.x); ++y) {
        consider(to.x < first.x ? 0 : right, y);
    }
    for (int x = 0; x <= right && (to.z < first.z || to.z > last.z); ++x) {
        consider(x, to.z < first.z ? 0 : bottom);
    }
    return {best};
}

std::size_t GridPathRequests::bytes() const {
    std::size_t bytes = (crowd_ != nullptr ? crowd_->bytes() : 0) + regions_.bytes() +
                        planner_.index_bytes() + pool_.bytes() + builder_.bytes() +
                        near_goal_.bytes() +
                        slots_.capacity() * (sizeof(RequestSlot) + sizeof(Blocks));
    for (const CachedFlowField& f : fields_) {
        bytes += f.hops.capacity();
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
