#include "server/ai/pathfinding/grid_search/subgoal_search.h"

#include "server/ai/pathfinding/grid/grid_path.h"

#include <algorithm>
#include <optional>

namespace zoned::ai::pathfinding {

namespace {

/// The doors of a cell, or itself where it is a subgoal.
std::span<const Subgoal> doors_of(const GridMap& map,
                                  const Subgoals& graph,
                                  Cell c,
                                  Subgoal& itself) {
    const Place p = map.place(c);
    itself = graph.at(p);
    return itself != kNoSubgoal ? std::span<const Subgoal>(&itself, 1) : graph.doors(p);
}

/// Calls found(t, cost) for doors t of the start from which the goal is in free reach. It is called
/// only where the path by t costs less than `least`, which found lowers.
template <class Found>
void look_across(const GridMap& map,
                 const Subgoals& graph,
                 const GridQuery& query,
                 std::span<const Subgoal> doors,
                 const Cost& least,
                 const Found& found) {
    for (const Subgoal t : doors) {
        const Cost cost = graph.cost(query.start, t) + graph.cost(query.goal, t);
        if (cost < least && free_line(map, query.goal, graph.cell(t))) {
            found(t, cost);
        }
    }
}

/// From s to the hub, without s.
template <class Visit>
void walk_to_hub(const HubLabels& labels, Subgoal s, std::uint16_t hub, const Visit& visit) {
    for (Subgoal next = labels.look_up(s, hub)->next; next != s;) {
        s = next;
        visit(s);
        next = labels.look_up(s, hub)->next;
    }
}

}  // namespace

void SubgoalSearch::resize(const Subgoals& graph) {
    space_.resize(graph.size() + 1);  // the last is the goal
    to_goal_.assign(graph.size(), kNoCost);
}

bool SubgoalSearch::run(const GridMap& map,
                        const Subgoals& graph,
                        const Landmarks* landmarks,
                        const GridQuery& query,
                        std::vector<Subgoal>& best,
                        std::uint32_t& work) {
    const Subgoal goal = graph.size();
    Subgoal start_itself = kNoSubgoal;
    Subgoal goal_itself = kNoSubgoal;
    const auto starts = doors_of(map, graph, query.start, start_itself);
    const auto ends = doors_of(map, graph, query.goal, goal_itself);
    for (const Subgoal s : ends) {
        to_goal_[s] = graph.cost(query.goal, s);
    }
    space_.begin();
    std::optional<Landmarks::Towards> towards;
    if (landmarks != nullptr) {
        towards.emplace(*landmarks, map.place(query.goal));
    }
    const auto least_cost = [&](Subgoal s) {
        const Cost on_empty_map = graph.cost(query.goal, s);
        return towards ? std::max(on_empty_map, towards->least(map.place(graph.cell(s))))
                       : on_empty_map;
    };
    const auto reach = [&](Subgoal s, Cost cost, Subgoal from) {
        if (cost < space_.cost(s)) {
            space_.reach(s, cost, from);
            const Cost h = s == goal ? 0 : least_cost(s);
            space_.open.push(s, (std::uint64_t{cost} + h) << 32U | h);
        }
    };
    for (const Subgoal s : starts) {
        reach(s, graph.cost(query.start, s), kNoSubgoal);
    }
    Cost across = kNoCost;
    look_across(map, graph, query, starts, across, [&](Subgoal t, Cost cost) {
        across = cost;
        reach(goal, cost, t);
    });
    Subgoal nearest = kNoSubgoal;
    Subgoal at = kNoSubgoal;
    work = 0;
    while (!space_.open.empty() && work != query.max_work) {
        at = space_.open.pop();
        ++work;
        if (at == goal) {
            break;
        }
        if (nearest == kNoSubgoal || graph.cost(query.goal, at) < graph.cost(query.goal, nearest)) {
            nearest = at;
        }
        const Cost g = space_.cost(at);
        if (to_goal_[at] != kNoCost) {
            reach(goal, g + to_goal_[at], at);
        }
        for (const Subgoal n : graph.neighbours(at)) {
            reach(n, g + graph.cost(at, n), at);
        }
    }
    for (const Subgoal s : ends) {
        to_goal_[s] = kNoCost;
    }
    best.clear();
    const bool found = at == goal;
    for (Subgoal s = found ? space_.from(goal) : nearest; s != kNoSubgoal; s = space_.from(s)) {
        best.push_back(s);
    }
    std::reverse(best.begin(), best.end());
    return found;
}

void LabelLookup::resize(const Subgoals& graph) {
    from_start_.assign(graph.size(), std::uint64_t{kFirstMark} << 32U);
    mark_ = kFirstMark;
}

bool LabelLookup::run(const GridMap& map,
                      const Subgoals& graph,
                      const HubLabels& labels,
                      const GridQuery& query,
                      std::vector<Subgoal>& best,
                      std::uint32_t& looked) {
    if (--mark_ == 0) {
        resize(graph);
        --mark_;
    }
    Subgoal start_itself = kNoSubgoal;
    Subgoal goal_itself = kNoSubgoal;
    const auto starts = doors_of(map, graph, query.start, start_itself);
    const auto ends = doors_of(map, graph, query.goal, goal_itself);
    const std::uint64_t mark = std::uint64_t{mark_} << 32U;
    for (const Subgoal s : starts) {
        const std::uint64_t to = mark | graph.cost(query.start, s);
        looked += static_cast<std::uint32_t>(labels.of(s).size());
        for (const HubLabel& l : labels.of(s)) {
            from_start_[l.hub] = std::min(from_start_[l.hub], to + l.cost);
        }
    }
    // Where the two sides share no hub, sums are those of earlier queries: above the mark.
    std::uint64_t least = mark | (kNoCost - 1);
    std::uint16_t hub = 0;
    Subgoal last = kNoSubgoal;
    for (const Subgoal s : ends) {
        const Cost to = graph.cost(query.goal, s);
        looked += static_cast<std::uint32_t>(labels.of(s).size());
        for (const HubLabel& l : labels.of(s)) {
            const std::uint64_t sum = from_start_[l.hub] + to + l.cost;
            if (sum < least) {
                least = sum;
                hub = l.hub;
                last = s;
            }
        }
    }
    best.clear();
    auto across = static_cast<Cost>(least);
    look_across(map, graph, query, starts, across, [&](Subgoal t, Cost cost) {
        across = cost;
        best.assign(1, t);
    });
    if (!best.empty() || last == kNoSubgoal) {
        return !best.empty();
    }
    for (const Subgoal s : starts) {
        const HubLabel* l = labels.look_up(s, hub);
        if (l != nullptr && (mark | (graph.cost(query.start, s) + l->cost)) == from_start_[hub]) {
            best.push_back(s);
            break;
        }
    }
    walk_to_hub(labels, best.back(), hub, [&best](Subgoal s) { best.push_back(s); });
    const auto middle = static_cast<std::ptrdiff_t>(best.size());
    best.push_back(last);
    walk_to_hub(labels, last, hub, [&best](Subgoal s) { best.push_back(s); });
    best.pop_back();  // the hub itself, with which the first half ends too
    std::reverse(best.begin() + middle, best.end());
    return true;
}

}  // namespace zoned::ai::pathfinding
