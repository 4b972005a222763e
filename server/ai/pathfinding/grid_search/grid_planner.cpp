#include "server/ai/pathfinding/grid_search/grid_planner.h"

#include "server/ai/pathfinding/grid_search/cell_search.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// Jobs within jobs stop where the outer one does, after units of their own.
constexpr std::uint64_t kIndexPart = 20'000;

}  // namespace

const char* to_string(PathOutcome outcome) {
    switch (outcome) {
        case PathOutcome::kFound:
            return "found";
        case PathOutcome::kPartial:
            return "partial";
        case PathOutcome::kUnreachable:
            return "unreachable";
        case PathOutcome::kOffMap:
            return "off_map";
        case PathOutcome::kStartBlocked:
            return "start_blocked";
        case PathOutcome::kGoalBlocked:
            return "goal_blocked";
        case PathOutcome::kCutOff:
            return "cut_off";
    }
    return "?";
}

const char* to_string(GridMethod method) {
    switch (method) {
        case GridMethod::kDefault:
            return "default";
        case GridMethod::kAStar:
            return "astar";
        case GridMethod::kWeightedAStar:
            return "weighted_astar";
        case GridMethod::kJumpPoints:
            return "jump_points";
        case GridMethod::kSubgoals:
            return "subgoals";
        case GridMethod::kHubLabels:
            return "hub_labels";
    }
    return "?";
}

GridPlanner::GridPlanner(GridMap map) : map_(std::move(map)) {
    ZONED_ASSERT(map_.passable_cells() <= kMostPassable, "a map whose paths may be too long");
    path_.reserve(map_.passable_cells());
    chain_.reserve(map_.passable_cells());
}

void GridPlanner::prepare(const IndexBounds& bounds) {
    label_components();
    begin_index(bounds);
    advance_index(~std::uint64_t{0});
}

void GridPlanner::begin_index(const IndexBounds& bounds) {
    retire_index();
    indexing_.cancel();
    if (search_.method == GridMethod::kDefault) {
        next_index_ = bounds;
    }
}

bool GridPlanner::advance_index(std::uint64_t units) {
    index_work_ = 0;
    while (index_work_ < units) {
        const bool done = indexing_.advance(units - index_work_);
        index_work_ += indexing_.taken();
        if (!done) {
            return false;
        }
        if (!next_index_) {
            return true;
        }
        indexing_ = index(*next_index_);
        next_index_.reset();
    }
    return false;
}

void GridPlanner::drop_index() {
    indexing_.cancel();
    while (!indexing_.advance(~std::uint64_t{0})) {
    }
    next_index_.reset();
    retire_index();
    old_labels_.reset();
    old_subgoals_.reset();
}

void GridPlanner::retire_index() {
    // Freeing megabytes takes up to a millisecond, so it is done in parts.
    if (subgoals_) {
        old_labels_ = std::move(labels_);
        old_subgoals_ = std::move(subgoals_);
    }
    labels_.reset();
    subgoals_.reset();
}

bool GridPlanner::worth_a_try(std::uint64_t failed_at) const {
    return failed_at == kNever || changed_cells_ - failed_at > map_.passable_cells() / kRetryShare;
}

ResumableTask GridPlanner::index(IndexBounds bounds) {
    bool cancelled = false;
    if (old_subgoals_) {
        const std::size_t labels = old_labels_ ? old_labels_->bytes() : 0;
        old_labels_.reset();
        cancelled = co_await Spent{1 + memory_units(labels) / 4};
        const std::size_t subgoals = old_subgoals_->bytes();
        old_subgoals_.reset();
        cancelled = co_await Spent{1 + memory_units(subgoals) / 4};
    }
    if (cancelled) {
        co_return;
    }
    ResumableTask part = index_subgoals(bounds);
    const auto run = [&part, &cancelled] {
        if (cancelled) {
            part.cancel();
        }
        return part.advance(kIndexPart);
    };
    while (!run()) {
        cancelled = co_await Spent{part.taken()};
    }
    cancelled = co_await Spent{part.taken()};
    if (cancelled || labels_ || landmarks_.known() || landmarks_.needless()) {
        co_return;
    }
    // The landmarks are of the map with all doors open that ever were: true however they turn.
    if (!landmark_map_) {
        landmark_map_ = map_;
    }
    label_components();
    part = landmarks_.build(*landmark_map_, components_, bounds.landmark_bytes);
    while (!run()) {
        cancelled = co_await Spent{part.taken()};
    }
    co_await Spent{part.taken()};
}

ResumableTask GridPlanner::index_subgoals(IndexBounds bounds) {
    bool cancelled = false;
    ResumableTask part;
    const auto run = [&part, &cancelled] {
        if (cancelled) {
            part.cancel();
        }
        return part.advance(kIndexPart);
    };
    if (cancelled || !worth_a_try(no_subgoals_at_)) {
        co_return;
    }
    part = Subgoals::build(map_, bounds.doors, new_subgoals_);
    while (!run()) {
        cancelled = co_await Spent{part.taken()};
    }
    // The work of the last part; freeing it counts too.
    cancelled = co_await Spent{part.taken()};
    if (cancelled) {
        co_return;
    }
    subgoals_ = std::move(new_subgoals_);
    new_subgoals_.reset();
    no_subgoals_at_ = subgoals_ ? kNever : changed_cells_;
    if (!subgoals_) {
        co_return;
    }
    subgoal_search_.resize(*subgoals_);
    stations_.reserve(subgoals_->size() + std::size_t{1});
    if (subgoals_->edges() * bounds.trees > bounds.tree_work || !worth_a_try(no_labels_at_)) {
        co_return;
    }
    part = hub_order(*subgoals_, bounds.trees, hub_order_);
    while (!run()) {
        cancelled = co_await Spent{part.taken()};
    }
    cancelled = co_await Spent{part.taken()};
    if (cancelled) {
        co_return;
    }
    part = HubLabels::build(*subgoals_, hub_order_, bounds.labels, new_labels_);
    while (!run()) {
        cancelled = co_await Spent{part.taken()};
    }
    if (cancelled) {
        co_return;
    }
    labels_ = std::move(new_labels_);
    new_labels_.reset();
    no_labels_at_ = labels_ ? kNever : changed_cells_;
    if (labels_) {
        lookup_.resize(*subgoals_);
    }
}

void GridPlanner::change(std::span<const CellChange> changes) {
    bool changed = false;
    for (const CellChange& c : changes) {
        if (map_.passable(c.cell) != c.passable) {
            map_.set_passable(c.cell, c.passable);
            if (c.passable && landmark_map_ && !landmark_map_->passable(c.cell)) {
                landmark_map_->set_passable(c.cell, true);
                landmarks_.forget();
            }
            ++changed_cells_;
            changed = true;
        }
    }
    ZONED_ASSERT(map_.passable_cells() <= kMostPassable, "a map whose paths may be too long");
    if (changed) {
        components_followed_ = components_true_;
        if (components_true_) {
            components_.update(map_, changes);
        }
        indexing_.cancel();
        next_index_.reset();
        retire_index();
    }
}

bool GridPlanner::joined(Cell a, Cell b) {
    label_components();
    return map_.passable(a) && map_.passable(b) &&
           components_.of(map_.place(a)) == components_.of(map_.place(b));
}

void GridPlanner::label_components() {
    if (!components_true_) {
        components_.label(map_);
        components_true_ = true;
    }
}

bool GridPlanner::can(GridMethod method) const {
    switch (method) {
        case GridMethod::kSubgoals:
            return subgoals_.has_value();
        case GridMethod::kHubLabels:
            return labels_.has_value();
        default:
            return true;
    }
}

GridMethod GridPlanner::choice() const {
    if (search_.method != GridMethod::kDefault) {
        return search_.method;
    }
    return labels_     ? GridMethod::kHubLabels
           : subgoals_ ? GridMethod::kSubgoals
                       : GridMethod::kJumpPoints;
}

std::size_t GridPlanner::index_bytes() const {
    return (subgoals_ ? subgoals_->bytes() : 0) + (labels_ ? labels_->bytes() : 0) +
           landmarks_.bytes();
}

GridAnswer GridPlanner::plan(const GridQuery& query, GridMethod method) {
    ZONED_ASSERT(can(method), "a method that needs an index");
    ZONED_ASSERT(query.weight >= 1.0F && query.weight <= 16.0F && query.max_work > 0,
                 "weight 1 to 16, max_work above 0");
    if (!map_.contains(query.start) || !map_.contains(query.goal)) {
        return {PathOutcome::kOffMap};
    }
    if (!map_.passable(query.start)) {
        return {PathOutcome::kStartBlocked};
    }
    if (joined(query.start, query.goal)) {
        return route(query, method);
    }
    if (!query.nearest) {
        return {map_.passable(query.goal) ? PathOutcome::kUnreachable : PathOutcome::kGoalBlocked};
    }
    GridQuery instead = query;
    std::uint32_t looked = 0;
    instead.goal = nearest_reached(query.start, query.goal, looked);
    GridAnswer answer = route(instead, method);
    answer.looked += looked;
    if (answer.outcome == PathOutcome::kFound) {
        answer.outcome = PathOutcome::kPartial;
    }
    return answer;
}

GridAnswer GridPlanner::route(const GridQuery& query, GridMethod method) {
    if (free_line(map_, query.start, query.goal)) {
        path_.begin(query.start);
        path_.go(query.goal);
        return finished(PathOutcome::kFound, 0);
    }
    if (method == GridMethod::kDefault) {
        GridQuery weighted = query;
        weighted.weight = search_.weight;
        return search_by(weighted, choice());
    }
    return search_by(query, method);
}

GridAnswer GridPlanner::search_by(const GridQuery& query, GridMethod method) {
    switch (method) {
        case GridMethod::kSubgoals:
            return by_subgoals(query, false);
        case GridMethod::kHubLabels:
            return by_subgoals(query, true);
        default:
            return by_cells(query, method);
    }
}

GridAnswer GridPlanner::by_cells(const GridQuery& query, GridMethod method) {
    if (cells_.size() == 0) {
        cells_.resize(map_.places());
    }
    GridQuery exact = query;
    exact.weight = method == GridMethod::kWeightedAStar ? query.weight : 1.0F;
    const Reached reached = method == GridMethod::kJumpPoints
                                ? search_jump_points(map_, exact, cells_, landmarks())
                                : search_cells(map_, exact, cells_);
    path_.begin(query.start);
    append_chain(reached.last);
    return finished(reached.goal ? PathOutcome::kFound : PathOutcome::kCutOff, reached.work);
}

void GridPlanner::append_chain(Place last) {
    chain_.clear();
    for (Place p = last; p != cells_.from(p); p = cells_.from(p)) {
        chain_.push_back(p);
    }
    for (auto p = chain_.rbegin(); p != chain_.rend(); ++p) {
        path_.go(map_.cell(*p));
    }
}

GridAnswer GridPlanner::by_subgoals(const GridQuery& query, bool labels) {
    std::uint32_t work = 0;
    std::uint32_t looked = 0;
    const bool found =
        labels ? lookup_.run(map_, *subgoals_, *labels_, query, stations_, looked)
               : subgoal_search_.run(map_, *subgoals_, landmarks(), query, stations_, work);
    ZONED_ASSERT(found || work == query.max_work, "cells of one component reach each other");
    path_.begin(query.start);
    for (const Subgoal s : stations_) {
        path_.go(subgoals_->cell(s));
    }
    if (found) {
        path_.arrive(query.goal);  // doors are in free reach of the goal, as seen from the goal
    }
    GridAnswer answer = finished(found ? PathOutcome::kFound : PathOutcome::kCutOff, work);
    answer.looked = looked;
    return answer;
}

GridAnswer GridPlanner::finished(PathOutcome outcome, std::uint32_t work) const {
    return {outcome, path_.cost(), path_.length(), work, 0};
}

Cell GridPlanner::nearest_reached(Cell from, Cell to, std::uint32_t& looked) const {
    const std::uint32_t component = components_.of(map_.place(from));
    Cell best = from;
    Cost least = octile(from.x - to.x, from.y - to.y);
    const auto consider = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= map_.width() || y >= map_.height()) {
            return;
        }
        ++looked;
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const Cost cost = octile(x - to.x, y - to.y);
        if (cost < least && components_.of(map_.place(c)) == component) {
            least = cost;
            best = c;
        }
    };
    // Squares around the goal, as long as one of their cells may be nearer.
    for (int r = 1; kStraight * static_cast<Cost>(r) < least; ++r) {
        const int first = std::max(-r, -std::max<int>(to.x, to.y));
        const int last = std::min(r, std::max(map_.width() - to.x, map_.height() - to.y));
        for (int i = first; i <= last; ++i) {
            consider(to.x + i, to.y - r);
            consider(to.x + i, to.y + r);
            consider(to.x - r, to.y + i);
            consider(to.x + r, to.y + i);
        }
    }
    return best;
}

}  // namespace zoned::ai::pathfinding
