#include "server/ai/pathfinding/waypoints/waypoint_graph.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace zoned::ai::pathfinding {

namespace {

double distance_of(const Vec3& a, const Vec3& b) {
    const Vec3d d = a.cast<double>() - b.cast<double>();
    return std::sqrt(d.dot(d));
}

}  // namespace

core::Result<WaypointGraph> WaypointGraph::build(std::span<const Waypoint> waypoints,
                                                 std::span<const WaypointEdge> edges) {
    using R = core::Result<WaypointGraph>;
    if (waypoints.size() > kMostWaypoints || edges.size() > kMostEdges) {
        return R::failure("more than " + std::to_string(kMostWaypoints) + " waypoints or " +
                          std::to_string(kMostEdges) + " edges");
    }
    WaypointGraph g;
    for (const Waypoint& w : waypoints) {
        if (!w.position.allFinite()) {
            return R::failure("waypoint " + std::to_string(w.id) + " has no finite position");
        }
        g.ids_.push_back(w.id);
        g.positions_.push_back(w.position);
        g.passable_.push_back(w.passable ? 1 : 0);
    }
    g.by_id_.resize(g.size());
    std::iota(g.by_id_.begin(), g.by_id_.end(), 0U);
    g.by_x_ = g.by_id_;
    std::sort(g.by_id_.begin(), g.by_id_.end(), [&g](std::uint32_t a, std::uint32_t b) {
        return g.ids_[a] < g.ids_[b];
    });
    g.sort_by_x();
    for (std::size_t i = 1; i < g.by_id_.size(); ++i) {
        if (g.ids_[g.by_id_[i]] == g.ids_[g.by_id_[i - 1]]) {
            return R::failure("waypoint " + std::to_string(g.ids_[g.by_id_[i]]) +
                              " is given twice");
        }
    }
    g.first_edge_.assign(g.size() + std::size_t{1}, 0);
    for (const WaypointEdge& e : edges) {
        const std::uint32_t from = g.number_of(e.from);
        const std::uint32_t to = g.number_of(e.to);
        if (from == g.size() || to == g.size()) {
            return R::failure("there is no waypoint " +
                              std::to_string(from == g.size() ? e.from : e.to));
        }
        if (!(e.weight >= 0.0F) || !std::isfinite(e.weight)) {
            return R::failure("the edge from " + std::to_string(e.from) + " to " +
                              std::to_string(e.to) + " needs a weight of 0 or more");
        }
        ++g.first_edge_[from + 1];
    }
    std::partial_sum(g.first_edge_.begin(), g.first_edge_.end(), g.first_edge_.begin());
    g.edges_.resize(edges.size());
    std::vector<std::uint32_t> fill(g.first_edge_.begin(), g.first_edge_.end() - 1);
    g.least_per_m_ = std::numeric_limits<double>::infinity();
    for (const WaypointEdge& e : edges) {
        const std::uint32_t from = g.number_of(e.from);
        g.edges_[fill[from]] = {g.number_of(e.to), e.weight, true};
        g.lower_least(from, g.edges_[fill[from]++]);
    }
    g.least_per_m_ = std::isfinite(g.least_per_m_) ? g.least_per_m_ : 0.0;
    return g;
}

void WaypointGraph::sort_by_x() {
    std::sort(by_x_.begin(), by_x_.end(), [this](std::uint32_t a, std::uint32_t b) {
        const float x = positions_[a].x();
        const float y = positions_[b].x();
        return x < y || (x == y && a < b);
    });
}

WaypointGraph WaypointGraph::seen_from(const Vec3d& origin) const {
    WaypointGraph g = *this;
    for (Vec3& p : g.positions_) {
        p = (p.cast<double>() - origin).cast<float>();
    }
    g.sort_by_x();
    // Lengths may have been rounded otherwise.
    for (std::uint32_t from = 0; from < g.size(); ++from) {
        for (const Edge& e : g.edges(from)) {
            g.lower_least(from, e);
        }
    }
    return g;
}

void WaypointGraph::lower_least(std::uint32_t from, const Edge& edge) {
    // A little less: sums of doubles along a path may round below the distance.
    constexpr double kRounding = 1.0 - 1e-9;
    const double length = distance_of(positions_[from], positions_[edge.to]);
    if (length > 0.0) {
        least_per_m_ =
            std::min(least_per_m_, kRounding * static_cast<double>(edge.weight) / length);
    }
}

std::uint32_t WaypointGraph::number_of(std::uint32_t id) const {
    const auto found = std::lower_bound(
        by_id_.begin(), by_id_.end(), id, [this](std::uint32_t number, std::uint32_t wanted) {
            return ids_[number] < wanted;
        });
    return found != by_id_.end() && ids_[*found] == id ? *found : size();
}

bool WaypointGraph::set_weight(std::uint32_t from, std::uint32_t to, float weight) {
    ZONED_ASSERT(weight >= 0.0F && std::isfinite(weight), "a weight of 0 or more");
    bool found = false;
    for (std::uint32_t e = first_edge_[from]; e < first_edge_[from + 1]; ++e) {
        if (edges_[e].to == to) {
            edges_[e].weight = weight;
            lower_least(from, edges_[e]);
            found = true;
        }
    }
    return found;
}

std::uint32_t WaypointGraph::nearest(const Vec3& place) const {
    const auto middle = std::lower_bound(
        by_x_.begin(), by_x_.end(), place.x(), [this](std::uint32_t number, float x) {
            return positions_[number].x() < x;
        });
    std::uint32_t best = size();
    double least = std::numeric_limits<double>::infinity();
    // Away from the middle until the difference in x alone is more.
    const bool any_height = std::isnan(place.y());
    const auto look = [&](std::uint32_t number) {
        const Vec3& at = positions_[number];
        const double d = distance_of(at, any_height ? Vec3(place.x(), at.y(), place.z()) : place);
        if (passable(number) && (d < least || (d == least && number < best))) {
            least = d;
            best = number;
        }
        return std::abs(static_cast<double>(positions_[number].x()) -
                        static_cast<double>(place.x())) <= least;
    };
    for (auto up = middle; up != by_x_.end() && look(*up); ++up) {
    }
    for (auto down = middle; down != by_x_.begin() && look(*std::prev(down)); --down) {
    }
    return best;
}

void WaypointSearch::begin(const WaypointGraph& graph) {
    path_.clear();
    open_.clear();
    if (known_.size() != graph.size() || ++search_ == 0) {
        known_.assign(graph.size(), KnownWaypoint{});
        search_ = 1;
    }
}

void WaypointSearch::reach(std::uint32_t number, double cost, std::uint32_t from, double ahead) {
    KnownWaypoint& k = known_[number];
    if (k.search == search_ && k.cost <= cost) {
        return;
    }
    k = {cost, from, search_};
    open_.push({cost + ahead, number, cost});
}

void WaypointSearch::trace(std::uint32_t last) {
    std::uint32_t n = last;
    for (; known_[n].from != n; n = known_[n].from) {
        path_.push_back(n);
    }
    path_.push_back(n);
    std::reverse(path_.begin(), path_.end());
}

WaypointSearch::WaypointAnswer WaypointSearch::plan(const WaypointGraph& graph,
                                                    std::uint32_t start,
                                                    std::uint32_t goal,
                                                    std::uint32_t max_work) {
    path_.clear();
    if (start >= graph.size() || goal >= graph.size()) {
        return {PathOutcome::kOffMap};
    }
    if (!graph.passable(start) || !graph.passable(goal)) {
        return {graph.passable(start) ? PathOutcome::kGoalBlocked : PathOutcome::kStartBlocked};
    }
    begin(graph);
    const auto ahead = [&graph, goal](std::uint32_t number) {
        return graph.least_weight_per_m() *
               distance_of(graph.position(number), graph.position(goal));
    };
    WaypointAnswer answer;
    reach(start, 0.0, start, ahead(start));
    while (!open_.empty()) {
        const OpenWaypoint at = open_.pop();
        if (at.cost > known_[at.node].cost) {
            continue;
        }
        if (answer.work++ == max_work) {
            answer.outcome = PathOutcome::kCutOff;
            return answer;
        }
        if (at.node == goal) {
            answer.outcome = PathOutcome::kFound;
            answer.cost = at.cost;
            trace(goal);
            return answer;
        }
        for (const WaypointGraph::Edge& e : graph.edges(at.node)) {
            if (e.open && graph.passable(e.to)) {
                reach(e.to, at.cost + static_cast<double>(e.weight), at.node, ahead(e.to));
            }
        }
    }
    return answer;
}

WaypointSearch::WaypointAnswer WaypointSearch::plan(const WaypointGraph& graph,
                                                    std::span<const WaypointEnd> starts,
                                                    std::span<const WaypointEnd> ends) {
    begin(graph);
    for (const WaypointEnd& s : starts) {
        reach(s.number, s.cost, s.number, 0.0);
    }
    WaypointAnswer answer;
    std::uint32_t last = 0;
    while (!open_.empty()) {
        const OpenWaypoint at = open_.pop();
        if (at.cost > known_[at.node].cost) {
            continue;
        }
        if (answer.outcome == PathOutcome::kFound && at.cost >= answer.cost) {
            break;
        }
        ++answer.work;
        for (const WaypointEnd& e : ends) {
            if (e.number == at.node &&
                (answer.outcome != PathOutcome::kFound || at.cost + e.cost < answer.cost)) {
                answer.outcome = PathOutcome::kFound;
                answer.cost = at.cost + e.cost;
                last = at.node;
            }
        }
        for (const WaypointGraph::Edge& e : graph.edges(at.node)) {
            if (e.open && graph.passable(e.to)) {
                reach(e.to, at.cost + static_cast<double>(e.weight), at.node, 0.0);
            }
        }
    }
    if (answer.outcome == PathOutcome::kFound) {
        trace(last);
    }
    return answer;
}

}  // namespace zoned::ai::pathfinding
