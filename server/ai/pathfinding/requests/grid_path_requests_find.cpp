#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "server/ai/pathfinding/grid/work_units.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// A field must save this many times its cost.
constexpr std::uint64_t kFieldGain = 2;
/// Cells or corners looked at on the last segment of a path from region to region.
constexpr std::uint32_t kRegionSearch = 500;

float segment_m(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

}  // namespace

bool GridPathRequests::find(RequestSlot& slot, bool cheaply) {
    const GridMap& map = planner_.map();
    slot.outcome = PathOutcome::kFound;
    slot.best = true;
    std::uint32_t looked = 0;
    const GridMap& free = crowd_ != nullptr ? crowd_->calm() : map;
    const bool straight = sees(free, slot.start, slot.goal, looked);
    spent_ += kSightUnits * looked;
    if (straight) {
        cells_.assign({slot.start, slot.goal});
        ++counts_.straight;
        return true;
    }
    if (find_around_crowds(slot) || find_by_field(slot)) {
        return true;
    }
    if (cheaply) {
        find_by_regions(slot);
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
    return find_by_planner(slot);
}

/// Crowds move: such a path is the best as far as one knows now.
bool GridPathRequests::find_around_crowds(RequestSlot& slot) {
    if (crowd_ == nullptr) {
        return false;
    }
    cells_.assign(1, slot.start);
    if (!crowd_->append_path(slot.start, slot.goal, cells_)) {
        return false;
    }
    spent_ += kHopUnits * cells_.size();
    ++counts_.around_crowds;
    return true;
}

bool GridPathRequests::pays(const RequestSlot& slot, std::uint64_t& work) const {
    const pathfinding::CrowdPaths::Cost best = crowd_->cost(grid_.cell(slot.at), slot.goal);
    if (best == pathfinding::CrowdFlowField::kNoPath) {
        return false;
    }
    // Steps in eight directions are up to 8 % longer than straight lines: this favours the present
    // path.
    pathfinding::CrowdPaths::Cost own = 0;
    const std::span<const Spot> corners = pool_.of(slot.corners);
    Spot before = slot.at;
    for (std::size_t i = slot.next; i < corners.size(); ++i) {
        own += crowd_->cost_along(before, corners[i]);
        before = corners[i];
    }
    work += kSightUnits * static_cast<std::uint64_t>(own / (2 * pathfinding::kPerStep * kStraight));
    const auto enough = static_cast<double>(1.0F - crowd_->settings().gain);
    return static_cast<double>(best) < enough * static_cast<double>(own);
}

std::span<const std::uint32_t> GridPathRequests::review_crowds() {
    /// A share of the work on crowds.
    constexpr std::uint64_t kReviewShare = 4;
    doubted_.clear();
    if (crowd_ == nullptr) {
        return doubted_;
    }
    if (next_review_ >= slots_.size() && reviewed_round_ != crowd_->round()) {
        reviewed_round_ = crowd_->round();
        next_review_ = 0;
    }
    const std::uint64_t most = crowd_->settings().work_per_tick / kReviewShare;
    for (std::uint64_t work = 0; next_review_ < slots_.size() && work < most; ++next_review_) {
        const auto number = static_cast<std::uint32_t>(next_review_);
        RequestSlot& slot = slots_[number];
        work += 1;
        if (!slot.taken || slot.waiting || !slot.usable) {
            continue;
        }
        work += kTakeUnits;
        if (pays(slot, work)) {
            slot.doubted = true;
            doubted_.push_back(number);
            ++counts_.reviewed;
            wait(number);
        }
    }
    return doubted_;
}

bool GridPathRequests::worth_a_field(const RequestSlot& slot) const {
    const GridMap& map = planner_.map();
    const std::uint32_t* const wanted = wanted_.find(map.place(slot.goal));
    const std::uint64_t by_planner = wanted != nullptr ? *wanted * typical_work_ : 0;
    return by_planner > kFieldGain * kFieldUnits * map.passable_cells();
}

bool GridPathRequests::make_field(Cell goal) {
    const GridMap& map = planner_.map();
    if (building_ != map.place(goal)) {
        builder_.begin(map, goal);
        building_ = map.place(goal);
        spent_ += memory_units(map.places());
    }
    while (spent_ < budget_) {
        const std::uint64_t left = (budget_ - spent_) / kFieldUnits + 1;
        const auto cells =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(left, map.passable_cells()));
        spent_ += kFieldUnits * cells;
        if (builder_.advance(map, cells)) {
            CachedFlowField& oldest = *std::min_element(
                fields_.begin(),
                fields_.end(),
                [](const CachedFlowField& a, const CachedFlowField& b) { return a.used < b.used; });
            builder_.copy_hops(oldest.hops);
            spent_ += memory_units(map.places()) / 2;
            oldest.goal = building_;
            oldest.used = tick_;
            building_ = kNoPlace;
            ++counts_.fields;
            return true;
        }
    }
    return false;
}

std::function<Hop(Cell)> GridPathRequests::flow_to(Cell goal) const {
    const auto around = crowd_ != nullptr ? crowd_->field_to(goal) : std::nullopt;
    if (around) {
        return [this, field = *around](Cell at) {
            return crowd_->hop(field, at);
        };
    }
    const GridMap& map = planner_.map();
    const Place place = map.place(goal);
    const auto field = std::find_if(
        fields_.begin(), fields_.end(), [place](const auto& f) { return f.goal == place; });
    if (field == fields_.end()) {
        return {};
    }
    return [&map, &hops = field->hops](Cell at) {
        return hops[map.place(at)];
    };
}

bool GridPathRequests::find_by_field(RequestSlot& slot) {
    const GridMap& map = planner_.map();
    const Place goal = map.place(slot.goal);
    const auto field = std::find_if(fields_.begin(),
                                    fields_.end(),
                                    [goal](const CachedFlowField& f) { return f.goal == goal; });
    if (field == fields_.end() || field->hops[map.place(slot.start)] == kNoHop) {
        return false;
    }
    field->used = tick_;
    cells_.assign(1, slot.start);
    walk([&](Cell c) { return field->hops[map.place(c)]; });
    ++counts_.by_field;
    return true;
}

void GridPathRequests::append(Cell c, bool straight_on) {
    if (straight_on) {
        cells_.back() = c;
    } else {
        cells_.push_back(c);
    }
}

template <class HopAt>
void GridPathRequests::walk(const HopAt& hop_at) {
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

GridAnswer GridPathRequests::search(const GridQuery& query) {
    const GridAnswer found = planner_.plan(query);
    const std::uint64_t work = kQueryUnits + kNodeUnits * found.work + kLookedUnits * found.looked;
    spent_ += work;
    searched_work_ += index_given_ == 0 ? work : 0;
    return found;
}

/// A search that the end of the tick cuts off begins again in the next one. A search that had all
/// of a tick goes from region to region.
bool GridPathRequests::find_by_planner(RequestSlot& slot) {
    const bool first = !std::exchange(searched_, true);
    const std::uint64_t left = budget_ > spent_ ? (budget_ - spent_) / kNodeUnits : 0;
    GridQuery query;
    query.start = slot.start;
    query.goal = slot.goal;
    query.max_work =
        static_cast<std::uint32_t>(std::clamp<std::uint64_t>(left, 1, settings_.search_work));
    query.nearest = true;
    const std::uint64_t before = spent_;
    const GridAnswer found = search(query);
    typical_work_ = (7 * typical_work_ + spent_ - before) / 8;
    if (found.outcome == PathOutcome::kCutOff) {
        if (!first && query.max_work < settings_.search_work) {
            return false;
        }
        find_by_regions(slot);
        return true;
    }
    slot.outcome = found.outcome;
    const std::span<const Cell> corners = planner_.path().corners();
    cells_.assign(corners.begin(), corners.end());
    return true;
}

void GridPathRequests::settle_regions() {
    queue_again();  // a waiting request has a passable goal
    spent_ += regions_.settle(planner_.map());
}

void GridPathRequests::prepare_table(Cell goal) {
    settle_regions();
    // A request waits for as long at most, and is led by its table meanwhile.
    const std::uint64_t needed_since =
        tick_ - std::min<std::uint64_t>(tick_, settings_.longest_wait_ticks);
    if (regions_.prepare(planner_.map(), goal, {tick_, needed_since})) {
        spent_ += kRegionUnits * regions_.regions();
    }
}

Cell GridPathRequests::nearest_middle(const RequestSlot& slot) {
    const auto off = [&slot](Cell c) {
        return octile(c.x - slot.goal.x, c.y - slot.goal.y);
    };
    Cell best = slot.start;
    regions_.visit_middles([&](Cell c) {
        if (off(c) < off(best) && planner_.joined(slot.start, c)) {
            best = c;
        }
    });
    spent_ += kMiddleUnits * regions_.regions();
    return best;
}

void GridPathRequests::find_by_regions(RequestSlot& slot) {
    const GridMap& map = planner_.map();
    const bool joined = planner_.joined(slot.start, slot.goal);
    const Cell goal = joined ? slot.goal : nearest_middle(slot);
    slot.outcome = joined ? PathOutcome::kFound : PathOutcome::kPartial;
    slot.best = false;
    prepare_table(goal);
    ++counts_.by_regions;
    if (!regions_.together(map, slot.start, goal) &&
        regions_.hop(map, slot.start, goal) == kNoHop) {
        // Farther than the tables reach: as far as a short search gets.
        GridQuery query;
        query.start = slot.start;
        query.goal = goal;
        query.max_work = kRegionSearch;
        const GridAnswer found = planner_.plan(query);
        spent_ += kQueryUnits + kNodeUnits * found.work;
        const std::span<const Cell> corners = planner_.path().corners();
        cells_.assign(corners.begin(), corners.end());
        slot.outcome = found.outcome == PathOutcome::kFound ? slot.outcome : found.outcome;
        return;
    }
    cells_.assign(1, slot.start);
    Hop last = kNoHop;
    std::uint32_t steps = 0;
    regions_.lead(map, slot.start, goal, [&](Cell c, Hop hop) {
        append(c, hop == last);
        last = hop;
        ++steps;
        return true;
    });
    spent_ += kHopUnits * steps;
    walk_within_region(goal);
}

void GridPathRequests::walk_within_region(Cell goal) {
    const GridMap& map = planner_.map();
    GridQuery query;
    query.start = cells_.back();
    query.goal = goal;
    query.max_work = kRegionSearch;
    const GridAnswer found = planner_.plan(query);
    spent_ += kQueryUnits + kNodeUnits * found.work + kLookedUnits * found.looked;
    if (found.outcome == PathOutcome::kFound) {
        const std::span<const Cell> corners = planner_.path().corners();
        cells_.insert(cells_.end(), corners.begin() + 1, corners.end());
        return;
    }
    // A search that lost its path beyond the square: within it there is one.
    const FlowField::Window w = regions_.window(map, goal);
    near_goal_.build(map, goal, w);
    spent_ +=
        kFieldUnits * static_cast<std::uint64_t>((w.right - w.left + 1) * (w.bottom - w.top + 1));
    walk([&](Cell c) { return near_goal_.hop(map.place(c)); });
}

void GridPathRequests::keep(std::uint32_t number) {
    RequestSlot& slot = slots_[number];
    std::uint32_t looked = 0;
    spent_ += kCornerUnits * cells_.size();
    pull(crowd_ != nullptr ? crowd_->calm() : planner_.map(), cells_, looked);
    spent_ += kSightUnits * looked;
    Blocks& blocks = blocks_[number];
    blocks = {};
    for (std::size_t i = 1; i < cells_.size(); ++i) {
        add_blocks(blocks, cells_[i - 1], cells_[i]);
    }
    pool_.give_back(slot.corners);
    slot.corners =
        pool_.take(static_cast<std::uint32_t>(std::max<std::size_t>(cells_.size(), 2) - 1));
    const std::span<Spot> corners = pool_.of(slot.corners);
    for (std::size_t i = 1; i < cells_.size(); ++i) {
        corners[i - 1] = grid_.centre(cells_[i]);
    }
    if (slot.outcome == PathOutcome::kFound) {
        corners.back() = slot.to;  // in the cell of the goal itself
    } else if (cells_.size() < 2) {
        corners.back() = grid_.centre(slot.start);
    }
    slot.usable = true;
    slot.next = 0;
    slot.ahead = corners.front();
    slot.length_m = segment_m(slot.at, slot.ahead);
    slot.rest_m = 0.0F;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        slot.rest_m += segment_m(corners[i - 1], corners[i]);
    }
    slot.length_m += slot.rest_m;
}

void GridPathRequests::add_blocks(Blocks& blocks, Cell a, Cell b) const {
    // The line crosses the rows of blocks one after the other: in each it leads from where it comes
    // in, half a cell before the middles of its first row, to where it goes out, rounded outwards.
    const Cell& upper = a.y <= b.y ? a : b;
    const Cell& lower = a.y <= b.y ? b : a;
    const int rows = lower.y - upper.y;
    const int columns = lower.x - upper.x;
    const auto crossing = [&](int row) {
        return upper.x + columns * (2 * (row - upper.y) - 1) / (2 * rows);
    };
    const int top = upper.y >> block_shift_;
    const int bottom = lower.y >> block_shift_;
    for (int y = top; y <= bottom; ++y) {
        const int in = y == top ? int{upper.x} : crossing(y << block_shift_);
        const int out = y == bottom ? int{lower.x} : crossing((y + 1) << block_shift_);
        const auto [first, last] = std::minmax(in, out);
        const auto left = static_cast<unsigned>(std::max(first - 1, 0) >> block_shift_);
        const auto right =
            static_cast<unsigned>(std::min(last + 1, grid_.width() - 1) >> block_shift_);
        for (unsigned x = left; x <= right; ++x) {
            const unsigned bit = kBlocks * static_cast<unsigned>(y) + x;
            blocks[bit / 64] |= std::uint64_t{1} << bit % 64;
        }
    }
}

std::optional<float> GridPathRequests::length(Spot from, Cell to) {
    const GridMap& map = planner_.map();
    GridQuery query;
    query.start = grid_.cell(from);
    query.goal = to;
    if ((!map.passable(query.start) &&
         !nearest_passable(map, grid_, from, settings_.reach_cells, query.start)) ||
        !planner_.joined(query.start, to)) {
        return std::nullopt;
    }
    if (spent_ < settings_.work_per_tick) {
        query.max_work = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
            (settings_.work_per_tick - spent_) / kNodeUnits, 1, settings_.search_work));
        const GridAnswer found = search(query);
        if (found.outcome == PathOutcome::kFound) {
            return static_cast<float>(found.length) * grid_.cell_m();
        }
    }
    prepare_table(to);
    return static_cast<float>(regions_.cells(map, query.start, to)) * grid_.cell_m();
}

}  // namespace zoned::ai::pathfinding
