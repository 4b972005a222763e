#include "server/ai/pathfinding/waypoints/waypoint_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

// The costs of work in units of about 2 ns.
constexpr std::uint64_t kWaypointUnits = 80;     ///< a waypoint of a search
constexpr std::uint64_t kAlongUnits = 10;        ///< one of a path that is put together
constexpr std::uint64_t kGraphGroupUnits = 60;   ///< a group of a table to a goal
constexpr std::uint64_t kWaypointScanUnits = 4;  ///< one of a scan of all

/// An agent within this distance of an edge stands on it, m.
constexpr float kBesideEdge_m = 0.75F;
/// A path must be cheaper by more than rounding, as a share.
constexpr double kCheaper = 1.0 - 1e-6;

Spot waypoint_spot(const Vec3& v) {
    return {v.x(), v.z()};
}

double apart_in_space(const Vec3& a, const Vec3& b) {
    return static_cast<double>((a - b).norm());
}

}  // namespace

WaypointPaths::WaypointPaths(WaypointGraph graph,
                             std::vector<WaypointDoor> doors,
                             std::span<const std::uint8_t> shut,
                             const WaypointPathsSettings& settings)
    : PathRequestQueue(settings.queue),
      settings_(settings),
      graph_(std::move(graph)),
      shut_(doors.size(), 0) {
    first_.assign(1, 0);
    for (std::uint32_t n = 0; n < graph_.size(); ++n) {
        places_.push_back(graph_.position(n));
        open_.push_back(graph_.passable(n) ? 1 : 0);
        for (const WaypointGraph::Edge& e : graph_.edges(n)) {
            to_.push_back(e.to);
        }
        first_.push_back(static_cast<std::uint32_t>(to_.size()));
    }
    linked_.assign(to_.size(), 1);
    return_.assign(to_.size(), GraphHierarchy::kNone);
    for (std::uint32_t n = 0; n < graph_.size(); ++n) {
        for (std::uint32_t e = first_[n]; e < first_[n + 1]; ++e) {
            return_[e] = edge_between(to_[e], n);
        }
    }
    hang(doors);
    follow(shut);
    clusters_.build(this->graph());
}

void WaypointPaths::hang(const std::vector<WaypointDoor>& doors) {
    std::vector<std::uint32_t> all;
    for (const WaypointDoor& door : doors) {
        all.insert(all.end(), door.taken.begin(), door.taken.end());
        all.insert(all.end(), door.given.begin(), door.given.end());
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    for (const std::uint32_t what : all) {
        hung_.push_back({what, false, what >= graph_.size() || graph_.passable(what), 0, 0});
    }
    const auto numbers = [&](const std::vector<std::uint32_t>& from) {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t what : from) {
            out.push_back(static_cast<std::uint32_t>(
                std::lower_bound(all.begin(), all.end(), what) - all.begin()));
        }
        return out;
    };
    for (const WaypointDoor& door : doors) {
        taken_.push_back(numbers(door.taken));
        given_.push_back(numbers(door.given));
        for (const std::uint32_t h : given_.back()) {
            hung_[h].bridge = true;
        }
    }
}

NodeGraph WaypointPaths::graph() const {
    return {places_, first_, to_, open_, linked_, return_};
}

bool WaypointPaths::follow(std::span<const std::uint8_t> shut) {
    for (std::uint32_t d = 0; d < shut_.size(); ++d) {
        if (shut_[d] == shut[d]) {
            continue;
        }
        shut_[d] = shut[d];
        const int by = shut[d] != 0 ? 1 : -1;
        for (const std::uint32_t h : taken_[d]) {
            hung_[h].takers = static_cast<std::uint16_t>(hung_[h].takers + by);
        }
        for (const std::uint32_t h : given_[d]) {
            hung_[h].givers = static_cast<std::uint16_t>(hung_[h].givers + by);
        }
    }
    opened_.clear();
    touched_.clear();
    for (const Hung& h : hung_) {
        if (h.open() == is_open(h.what)) {
            continue;
        }
        if (h.what < graph_.size()) {
            touched_.push_back(h.what);
            graph_.set_passable(h.what, h.open());
            open_[h.what] = h.open() ? 1 : 0;
        } else {
            const std::uint32_t edge = h.what - graph_.size();
            touched_.insert(touched_.end(), {start_of(edge), to_[edge]});
            graph_.set_open(h.what - graph_.size(), h.open());
            linked_[h.what - graph_.size()] = h.open() ? 1 : 0;
        }
        if (h.open()) {
            const auto [from, to] = ends_of(h.what);
            opened_box_ = opened_.empty() ? Aabb{from, from} : opened_box_;
            for (const Vec3& end : {from, to}) {
                opened_box_ = {opened_box_.lower.cwiseMin(end), opened_box_.upper.cwiseMax(end)};
            }
            opened_.push_back(h.what);
        }
    }
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    return !touched_.empty();
}

bool WaypointPaths::is_open(std::uint32_t what) const {
    return what < graph_.size() ? graph_.passable(what) : graph_.edge(what - graph_.size()).open;
}

void WaypointPaths::turn_doors(std::span<const std::uint8_t> shut) {
    nothing_changed();
    if (follow(shut)) {
        clusters_.change(graph(), touched_);
        review(!opened_.empty());
    }
}

PathOutcome WaypointPaths::locate(PathRequestEntry& request) {
    for (End* end : {&request.from, &request.to}) {
        end->node = graph_.nearest(end->wanted);
        if (end->node == graph_.size()) {
            return end == &request.from ? PathOutcome::kStartBlocked : PathOutcome::kGoalBlocked;
        }
        end->on = end->wanted;
        if (std::isnan(end->on.y())) {
            end->on.y() = graph_.position(end->node).y();
        }
    }
    return PathOutcome::kFound;
}

void WaypointPaths::ready(std::uint32_t goal) {
    if (clusters_.prepare(goal)) {
        spend(kGraphGroupUnits * clusters_.size());
    }
}

void WaypointPaths::prepare_segments(const PathRequestEntry& request) {
    ready(request.to.node);
}

void WaypointPaths::find(const PathRequestEntry& request, bool late, FoundPath& found) {
    const std::uint32_t from = request.from.node;
    std::uint32_t goal = request.to.node;
    found.last = goal;
    if (from == goal) {
        found.corners.push_back(waypoint_spot(request.to.on));
        found.straight = true;
        found.best = true;
        return;
    }
    ready(goal);
    if (!clusters_.joined(from, goal)) {
        goal = nearest_reached(request);
        found.outcome = PathOutcome::kPartial;
        found.last = goal;
        found.short_m = (places_[goal] - request.to.on).norm();
        ready(goal);
    }
    const bool to_goal = found.outcome == PathOutcome::kFound;
    if (!late) {
        const WaypointSearch::WaypointAnswer answer =
            search_.plan(graph_, from, goal, settings_.search_work);
        spend(kWaypointUnits * answer.work);
        if (answer.outcome == PathOutcome::kFound) {
            path_.assign(search_.path().begin(), search_.path().end());
            found.best = true;
            found.cost = answer.cost;
            take(request, to_goal, found);
            return;
        }
    }
    found.cheap = true;
    if (!find_by_clusters(from, goal)) {
        found.outcome = PathOutcome::kUnreachable;
        return;
    }
    for (std::size_t i = 1; i < path_.size(); ++i) {
        found.cost += static_cast<double>(graph_.edge(edge_between(path_[i - 1], path_[i])).weight);
    }
    take(request, to_goal, found);
}

std::uint32_t WaypointPaths::nearest_reached(const PathRequestEntry& request) {
    clusters_.flood(request.from.node);
    std::uint32_t best = request.from.node;
    float least = std::numeric_limits<float>::infinity();
    for (std::uint32_t n = 0; n < graph_.size(); ++n) {
        if (clusters_.flooded(n)) {
            if (const float d = (places_[n] - request.to.on).squaredNorm(); d < least) {
                least = d;
                best = n;
            }
        }
    }
    spend(kWaypointScanUnits * graph_.size());
    return best;
}

bool WaypointPaths::find_by_clusters(std::uint32_t from, std::uint32_t goal) {
    std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
    path_.assign(1, from);
    while (path_.back() != goal) {
        const std::size_t count = clusters_.segment(graph(), path_.back(), goal, segment);
        if (count == 0) {
            return false;
        }
        path_.insert(
            path_.end(), segment.begin(), segment.begin() + static_cast<std::ptrdiff_t>(count));
    }
    spend(kAlongUnits * path_.size());
    return true;
}

std::uint32_t WaypointPaths::edge_between(std::uint32_t from, std::uint32_t to) const {
    std::uint32_t best = GraphHierarchy::kNone;
    const auto worse = [this](std::uint32_t e) {
        return std::pair(!graph_.edge(e).open, graph_.edge(e).weight);
    };
    for (std::uint32_t e = first_[from]; e < first_[from + 1]; ++e) {
        if (to_[e] == to && (best == GraphHierarchy::kNone || worse(e) < worse(best))) {
            best = e;
        }
    }
    return best;
}

bool WaypointPaths::on_edge(const Vec3& place, std::uint32_t from, std::uint32_t to) const {
    const Vec3 path = places_[to] - places_[from];
    const Vec3 off = place - places_[from];
    const float length2 = path.squaredNorm();
    const float along = off.dot(path);
    if (!(along > 0.0F) || along > length2) {
        return false;
    }
    return (off - path * (along / length2)).norm() <= kBesideEdge_m;
}

void WaypointPaths::take(const PathRequestEntry& request, bool to_goal, FoundPath& found) const {
    std::size_t first = 0;
    std::size_t end = path_.size();
    if (path_.size() > 1 && on_edge(request.from.on, path_[0], path_[1])) {
        first = 1;
    }
    if (to_goal && end - first > 1 && on_edge(request.to.on, path_[end - 1], path_[end - 2])) {
        --end;
    }
    const auto hinge = [&](std::uint32_t what) {
        const auto at = std::lower_bound(
            hung_.begin(), hung_.end(), what, [](const Hung& h, std::uint32_t wanted) {
                return h.what < wanted;
            });
        if (at != hung_.end() && at->what == what) {
            found.hinges.push_back({what, static_cast<std::uint32_t>(found.corners.size())});
        }
    };
    for (std::size_t i = 0; i < path_.size(); ++i) {
        if (i > 0) {
            hinge(graph_.size() + edge_between(path_[i - 1], path_[i]));
        }
        hinge(path_[i]);
        if (i >= first && i < end) {
            found.corners.push_back(waypoint_spot(places_[path_[i]]));
        }
    }
    if (to_goal) {
        found.corners.push_back(waypoint_spot(request.to.on));
    }
}

Spot WaypointPaths::first_segment(PathRequestEntry& request, Spot at) const {
    const Vec3 here(at.x, request.from.wanted.y(), at.z);
    const std::uint32_t node = graph_.nearest(here);
    if (node == graph_.size() || !clusters_.prepared(request.to.node)) {
        return at;
    }
    request.from.wanted = Vec3(at.x, graph_.position(node).y(), at.z);
    if (node == request.to.node) {
        return waypoint_spot(request.to.on);
    }
    std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
    const std::size_t count = clusters_.segment(graph(), node, request.to.node, segment);
    if (count == 0) {
        return at;
    }
    // An agent at the waypoint, or already beyond it on the next edge, goes on to the next one.
    const Vec3 on = request.from.wanted;
    const bool past = (on - places_[node]).norm() <= kBesideEdge_m || on_edge(on, node, segment[0]);
    return waypoint_spot(places_[past ? segment[0] : node]);
}

MapNumbers WaypointPaths::numbers() const {
    return {places_.size(), places_.size() + to_.size()};
}

bool WaypointPaths::passable(const Hinge& hinge) const {
    return is_open(hinge.what);
}

bool WaypointPaths::may_be_shorter(const PathRequestEntry& request) const {
    // The test covers the whole path: a gain for an agent part-way along it is also a gain on the
    // whole.
    const Vec3& from = places_[request.from.node];
    const Vec3& to = places_[request.last];
    const auto worth = [&](double around) {
        return graph_.least_weight_per_m() * around < kCheaper * request.cost;
    };
    const auto off = [this](const Vec3& p) {
        return apart_in_space(p, p.cwiseMax(opened_box_.lower).cwiseMin(opened_box_.upper));
    };
    return worth(off(from) + off(to)) &&
           std::any_of(opened_.begin(), opened_.end(), [&](std::uint32_t what) {
               const auto [begin, end] = ends_of(what);
               return worth(apart_in_space(from, begin) + apart_in_space(begin, end) +
                            apart_in_space(end, to));
           });
}

bool WaypointPaths::may_come_nearer(const PathRequestEntry& request) const {
    return !request.usable || request.outcome != PathOutcome::kPartial ||
           clusters_.joined_anew(request.last) ||
           std::any_of(opened_.begin(), opened_.end(), [&](std::uint32_t what) {
               const auto [begin, end] = ends_of(what);
               return std::min((begin - request.to.on).norm(), (end - request.to.on).norm()) <=
                      request.short_m;
           });
}

std::pair<Vec3, Vec3> WaypointPaths::ends_of(std::uint32_t what) const {
    if (what < graph_.size()) {
        return {places_[what], places_[what]};
    }
    const std::uint32_t edge = what - graph_.size();
    return {places_[start_of(edge)], places_[to_[edge]]};
}

std::uint32_t WaypointPaths::start_of(std::uint32_t edge) const {
    const auto next = std::upper_bound(first_.begin(), first_.end(), edge);
    return static_cast<std::uint32_t>(next - first_.begin()) - 1;
}

bool WaypointPaths::straight(Spot from, float from_y, Spot to, float to_y) const {
    const std::uint32_t first = graph_.nearest(Vec3(from.x, from_y, from.z));
    return first != graph_.size() && first == graph_.nearest(Vec3(to.x, to_y, to.z));
}

bool WaypointPaths::contains(Spot place) const {
    return std::isfinite(place.x) && std::isfinite(place.z);
}

std::size_t WaypointPaths::bytes() const {
    std::size_t bytes = queue_bytes() + graph_.bytes() + search_.bytes() + clusters_.bytes() +
                        places_.capacity() * sizeof(Vec3) + open_.capacity() + linked_.capacity() +
                        hung_.capacity() * sizeof(Hung) +
                        (first_.capacity() + to_.capacity() + return_.capacity() +
                         path_.capacity() + opened_.capacity() + touched_.capacity()) *
                            sizeof(std::uint32_t);
    for (const auto* doors : {&taken_, &given_}) {
        for (const std::vector<std::uint32_t>& door : *doors) {
            bytes += door.capacity() * sizeof(std::uint32_t);
        }
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
