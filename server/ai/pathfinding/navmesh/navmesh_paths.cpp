#include "server/ai/pathfinding/navmesh/navmesh_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

// The costs of work in units of about 2 ns; measured once and rounded.
constexpr std::uint64_t kPolygonUnits = 60;  ///< a polygon of a search
constexpr std::uint64_t kStepUnits = 20;     ///< a polygon walked over, or put into a corridor
constexpr std::uint64_t kGroupUnits = 60;    ///< a group of a table to a goal
constexpr std::uint64_t kScanUnits = 20;     ///< a polygon of a scan

constexpr float kAnyHeight = std::numeric_limits<float>::infinity();
/// A goal on the edge of two polygons counts as on both, m.
constexpr float kOnEdge_m = 0.01F;
/// Beyond this distance a place counts as another than the wanted one, m.
constexpr float kMoved_m = 0.01F;
/// A short cut must gain more than rounding, m.
constexpr float kGainOnMesh_m = 1e-3F;
/// A waiting agent is sent ahead through this many polygons.
constexpr std::size_t kSegmentPolygons = 8;
/// A segment ahead is longer than this, m: an agent at its end has to be in the next polygon.
constexpr float kLeastSegment_m = 0.3F;

Spot flat_spot(const Vec3& v) {
    return {v.x(), v.z()};
}

float flat_distance(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

/// True if a place that was meant for `wanted_y` (kOnGround: the lowest floor) lies on another
/// floor.
bool on_another_floor(float wanted_y, const Vec3& on) {
    return std::abs(wanted_y - on.y()) > Navmesh::kOnFloor_m;
}

/// The distance from a goal to the place that replaces it: over the ground where it is on its
/// floor.
float off_goal(const Vec3& wanted, const Vec3& on) {
    return on_another_floor(wanted.y(), on) ? (wanted - on).norm()
                                            : flat_distance(flat_spot(wanted), flat_spot(on));
}

/// The distance of a place from a box.
float off_box(Spot s, Spot low, Spot high) {
    return flat_distance(s, {std::clamp(s.x, low.x, high.x), std::clamp(s.z, low.z, high.z)});
}

/// The place of a line from `a` to `b` by which two straight lines are shortest: where the line to
/// the goal's mirror image meets it, or the end that is nearest to that (their sum is convex).
Vec3 least_detour(const Vec3& a, const Vec3& b, Spot from, Spot to) {
    const Vec2 along(b.x() - a.x(), b.z() - a.z());
    const float squared = along.squaredNorm();
    if (!(squared > 0.0F)) {
        return a;
    }
    const auto share = [&](Spot s) {
        return along.dot(Vec2(s.x - a.x(), s.z - a.z())) / squared;
    };
    const auto off = [&](Spot s) {
        return std::abs(along.x() * (s.z - a.z()) - along.y() * (s.x - a.x()));
    };
    const float sum = off(from) + off(to);
    const float at =
        sum > 0.0F ? share(from) + (share(to) - share(from)) * off(from) / sum : share(from);
    return a + std::clamp(at, 0.0F, 1.0F) * (b - a);
}

/// Length of the shortest path from a place to another by a box over the ground. It is straight
/// where the line passes through the box, else it goes by one of the box's sides.
float around_box(Spot from, Spot to, Spot low, Spot high) {
    const std::array<Vec3, 4> corners{Vec3(low.x, 0.0F, low.z),
                                      Vec3(high.x, 0.0F, low.z),
                                      Vec3(high.x, 0.0F, high.z),
                                      Vec3(low.x, 0.0F, high.z)};
    const auto inside = [&](Spot s) {
        return s.x >= low.x && s.x <= high.x && s.z >= low.z && s.z <= high.z;
    };
    float least = inside(from) || inside(to) ? flat_distance(from, to)
                                             : std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
        const Spot by = flat_spot(least_detour(corners[i], corners[(i + 1) % 4], from, to));
        least = std::min(least, flat_distance(from, by) + flat_distance(by, to));
    }
    return least;
}

}  // namespace

NavmeshPaths::NavmeshPaths(Navmesh mesh,
                           const GroundRect& area,
                           std::span<const std::uint8_t> shut,
                           const NavmeshPathsSettings& settings)
    : PathRequestQueue(settings.queue),
      settings_(settings),
      area_(area),
      mesh_(std::move(mesh)) {
    link_polygons();
    find_rims();
    for (std::uint32_t p = 0; p < mesh_.polygons().size(); ++p) {
        if (mesh_.polygons()[p].gate != 0) {
            hinged_.push_back(p);
        }
    }
    follow(shut);
    clusters_.build(graph());
}

void NavmeshPaths::link_polygons() {
    const std::span<const Navmesh::Polygon> polygons = mesh_.polygons();
    first_.assign(1, 0);
    for (const Navmesh::Polygon& p : polygons) {
        Vec3 sum = Vec3::Zero();
        for (int i = 0; i < p.size; ++i) {
            const auto at = static_cast<std::size_t>(i);
            sum += mesh_.vertices()[p.corners[at]];
            if (p.neighbours[at] != Navmesh::kNone) {
                to_.push_back(p.neighbours[at]);
            }
        }
        middles_.emplace_back(sum / static_cast<float>(std::max(1, p.size)));
        first_.push_back(static_cast<std::uint32_t>(to_.size()));
    }
    linked_.assign(to_.size(), 1);
    for (std::uint32_t p = 0; p < polygons.size(); ++p) {
        open_.push_back(mesh_.passable(p) ? 1 : 0);
    }
    return_.assign(to_.size(), GraphHierarchy::kNone);
    for (std::uint32_t p = 0; p < polygons.size(); ++p) {
        for (std::uint32_t i = first_[p]; i < first_[p + 1]; ++i) {
            const auto begin = to_.begin() + first_[to_[i]];
            const auto end = to_.begin() + first_[to_[i] + 1];
            const auto back = std::find(begin, end, p);
            if (back != end) {
                return_[i] = static_cast<std::uint32_t>(back - to_.begin());
            }
        }
    }
}

void NavmeshPaths::find_rims() {
    // The mesh keeps as far from the area's sides as from a wall.
    for (std::uint32_t p = 0; p < mesh_.polygons().size(); ++p) {
        const Navmesh::Polygon& polygon = mesh_.polygons()[p];
        for (int i = 0; i < polygon.size; ++i) {
            if (polygon.neighbours[static_cast<std::size_t>(i)] != Navmesh::kNone) {
                continue;
            }
            const int next = i + 1 == polygon.size ? 0 : i + 1;
            const Vec3& a = mesh_.vertices()[polygon.corners[static_cast<std::size_t>(i)]];
            const Vec3& b = mesh_.vertices()[polygon.corners[static_cast<std::size_t>(next)]];
            const auto near = [&](float of_a, float of_b, float side) {
                return std::max(std::abs(of_a - side), std::abs(of_b - side)) <= mesh_.rim_m();
            };
            const std::array<bool, 4> at{near(a.x(), b.x(), area_.min_x),
                                         near(a.x(), b.x(), area_.max_x),
                                         near(a.z(), b.z(), area_.min_z),
                                         near(a.z(), b.z(), area_.max_z)};
            for (int side = 0; side < 4; ++side) {
                if (at[static_cast<std::size_t>(side)]) {
                    rims_.push_back({p, a, b, side});
                }
            }
        }
    }
}

NodeGraph NavmeshPaths::graph() const {
    return {middles_, first_, to_, open_, linked_, return_};
}

bool NavmeshPaths::follow(std::span<const std::uint8_t> shut) {
    opened_.clear();
    turned_.clear();
    const auto any = [&](const std::vector<std::uint32_t>& doors) {
        return std::any_of(
            doors.begin(), doors.end(), [&](std::uint32_t d) { return shut[d] != 0; });
    };
    for (const std::uint32_t p : hinged_) {
        const Navmesh::Gate& gate = mesh_.gates()[mesh_.polygons()[p].gate];
        const bool open = !any(gate.takers) && (gate.open || any(gate.givers));
        if (open == mesh_.passable(p)) {
            continue;
        }
        turned_.push_back(p);
        open_[p] = open ? 1 : 0;
        mesh_.set_passable(p, open);
        if (open) {
            OpenedBox box{flat_spot(middles_[p]), flat_spot(middles_[p])};
            for (int i = 0; i < mesh_.polygons()[p].size; ++i) {
                const Vec3& v =
                    mesh_.vertices()[mesh_.polygons()[p].corners[static_cast<std::size_t>(i)]];
                box.low = {std::min(box.low.x, v.x()), std::min(box.low.z, v.z())};
                box.high = {std::max(box.high.x, v.x()), std::max(box.high.z, v.z())};
            }
            opened_.push_back(box);
        }
    }
    return !turned_.empty();
}

void NavmeshPaths::turn_doors(std::span<const std::uint8_t> shut) {
    nothing_changed();
    if (follow(shut)) {
        clusters_.change(graph(), turned_);
        review(!opened_.empty());
    }
}

PathOutcome NavmeshPaths::locate(PathRequestEntry& request) {
    End& from = request.from;
    from.node = mesh_.nearest(from.wanted, settings_.reach_m, kAnyHeight, from.on);
    if (from.node == Navmesh::kNone) {
        return PathOutcome::kStartBlocked;
    }
    End& to = request.to;
    to.node = mesh_.nearest(to.wanted, settings_.reach_m, kAnyHeight, to.on);
    return to.node == Navmesh::kNone ? PathOutcome::kGoalBlocked : PathOutcome::kFound;
}

void NavmeshPaths::ready(std::uint32_t goal) {
    if (clusters_.prepare(goal)) {
        spend(kGroupUnits * clusters_.size());
    }
}

void NavmeshPaths::prepare_segments(const PathRequestEntry& request) {
    ready(request.to.node);
}

void NavmeshPaths::find(const PathRequestEntry& request, bool late, FoundPath& found) {
    const float off = off_goal(request.to.wanted, request.to.on);
    End goal = request.to;
    found.outcome = off > kMoved_m ? PathOutcome::kPartial : PathOutcome::kFound;
    found.short_m = off;
    found.last = goal.node;
    if (find_straight(request, goal, found)) {
        return;
    }
    ready(goal.node);
    if (!clusters_.joined(request.from.node, goal.node)) {
        goal = nearest_reached(request);
        found.outcome = PathOutcome::kPartial;
        found.last = goal.node;
        found.short_m = off_goal(request.to.wanted, goal.on);
        if (find_straight(request, goal, found)) {
            return;
        }
        ready(goal.node);
    }
    if (!late) {
        const NavmeshSearch::NavmeshAnswer answer = search_.plan(
            mesh_, request.from.node, goal.node, request.from.on, goal.on, settings_.search_work);
        spend(kPolygonUnits * answer.work);
        if (answer.outcome == PathOutcome::kFound) {
            take(found);
            return;
        }
    }
    found.cheap = true;
    if (find_by_clusters(request, goal)) {
        take(found);
    } else {
        found.outcome = PathOutcome::kUnreachable;
    }
}

bool NavmeshPaths::find_straight(const PathRequestEntry& request,
                                 const End& goal,
                                 FoundPath& found) {
    found.hinges.clear();
    std::uint64_t steps = 0;
    const std::uint32_t end =
        mesh_.walk(request.from.node, request.from.on, goal.on, [&](std::uint32_t p) {
            ++steps;
            if (mesh_.polygons()[p].gate != 0) {
                found.hinges.push_back({p, 0});
            }
        });
    spend(kStepUnits * steps);
    found.straight =
        end != Navmesh::kNone && (mesh_.nearest_on(end, goal.on) - goal.on).norm() <= kOnEdge_m;
    if (!found.straight) {
        found.hinges.clear();
        return false;
    }
    found.best = true;
    found.corners.push_back(flat_spot(goal.on));
    return true;
}

PathRequestQueue::End NavmeshPaths::nearest_reached(const PathRequestEntry& request) {
    clusters_.flood(request.from.node);
    End best = request.from;
    // Where the goal's height is not given, its place on the ground is used.
    const Vec3 goal(request.to.wanted.x(), request.to.on.y(), request.to.wanted.z());
    float least = std::numeric_limits<float>::infinity();
    for (std::uint32_t p = 0; p < mesh_.polygons().size(); ++p) {
        if (!clusters_.flooded(p)) {
            continue;
        }
        const Vec3 near = mesh_.nearest_on(p, goal);
        if (const float off = (near - goal).squaredNorm(); off < least) {
            least = off;
            best.on = near;
            best.node = p;
        }
    }
    spend(kScanUnits * mesh_.polygons().size());
    return best;
}

bool NavmeshPaths::find_by_clusters(const PathRequestEntry& request, const End& goal) {
    std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
    corridor_.assign(1, request.from.node);
    while (corridor_.back() != goal.node) {
        const std::size_t count = clusters_.segment(graph(), corridor_.back(), goal.node, segment);
        if (count == 0) {
            return false;
        }
        corridor_.insert(
            corridor_.end(), segment.begin(), segment.begin() + static_cast<std::ptrdiff_t>(count));
    }
    spend(kStepUnits * corridor_.size());
    search_.follow(mesh_, corridor_, request.from.on, goal.on);
    return true;
}

void NavmeshPaths::take(FoundPath& found) const {
    const std::span<const Vec3> corners = search_.corners();
    for (const Vec3& c : corners.subspan(1)) {
        found.corners.push_back(flat_spot(c));
    }
    std::uint32_t corner = 1;
    for (std::uint32_t i = 0; i < search_.corridor().size(); ++i) {
        while (corner + 1 < corners.size() && search_.passed()[corner] <= i) {
            ++corner;
        }
        const std::uint32_t p = search_.corridor()[i];
        if (mesh_.polygons()[p].gate != 0) {
            found.hinges.push_back({p, corner - 1});
        }
    }
}

Vec3 NavmeshPaths::gate_between(std::uint32_t polygon, std::uint32_t next) const {
    const Navmesh::Polygon& p = mesh_.polygons()[polygon];
    for (int i = 0; i < p.size; ++i) {
        if (p.neighbours[static_cast<std::size_t>(i)] == next) {
            const int after = i + 1 == p.size ? 0 : i + 1;
            return 0.5F * (mesh_.vertices()[p.corners[static_cast<std::size_t>(i)]] +
                           mesh_.vertices()[p.corners[static_cast<std::size_t>(after)]]);
        }
    }
    return middles_[next];
}

Spot NavmeshPaths::first_segment(PathRequestEntry& request, Spot at) const {
    Vec3 on;
    const Vec3 here(at.x, request.from.wanted.y(), at.z);
    const std::uint32_t node = mesh_.nearest(here, settings_.reach_m, kAnyHeight, on);
    request.from.wanted = Vec3(at.x, node == Navmesh::kNone ? here.y() : on.y(), at.z);
    if (node == Navmesh::kNone || !clusters_.prepared(request.to.node)) {
        return at;
    }
    const auto nothing = [](std::uint32_t) {
    };
    const Vec3& goal = request.to.on;
    const std::uint32_t end = mesh_.walk(node, on, goal, nothing);
    if (end != Navmesh::kNone && (mesh_.nearest_on(end, goal) - goal).norm() <= kOnEdge_m) {
        return flat_spot(goal);
    }
    // Goes as far through the polygons ahead as the view is free.
    Spot ahead = at;
    std::array<std::uint32_t, GraphHierarchy::kMost + 1> segment{};
    std::uint32_t last = node;
    for (std::size_t gates = 0; gates < kSegmentPolygons && last != request.to.node;) {
        const std::size_t count = clusters_.segment(graph(), last, request.to.node, segment);
        if (count == 0) {
            return ahead;
        }
        for (std::size_t i = 0; i < count && gates < kSegmentPolygons; ++i, ++gates) {
            const Vec3 gate = gate_between(last, segment[i]);
            const bool seen = mesh_.walk(node, on, gate, nothing) != Navmesh::kNone;
            if (!seen && flat_distance(at, ahead) > kLeastSegment_m) {
                return ahead;
            }
            ahead = flat_spot(gate);
            last = segment[i];
        }
    }
    return ahead;
}

MapNumbers NavmeshPaths::numbers() const {
    return {mesh_.polygons().size(), mesh_.polygons().size()};
}

bool NavmeshPaths::passable(const Hinge& hinge) const {
    return mesh_.passable(hinge.what);
}

bool NavmeshPaths::may_be_shorter(const PathRequestEntry& request) const {
    const Spot at = flat_spot(request.from.wanted);
    const Spot to = end_of(request);
    const float left = left_m(request);
    return std::any_of(opened_.begin(), opened_.end(), [&](const OpenedBox& box) {
        // Two places of the box first, then the best one.
        return off_box(at, box.low, box.high) + off_box(to, box.low, box.high) + kGainOnMesh_m <
                   left &&
               around_box(at, to, box.low, box.high) + kGainOnMesh_m < left;
    });
}

bool NavmeshPaths::may_come_nearer(const PathRequestEntry& request) const {
    const Spot at = flat_spot(request.from.wanted);
    const Spot wanted = flat_spot(request.to.wanted);
    const auto opened_within = [&](Spot spot, float reach_m) {
        return std::any_of(opened_.begin(), opened_.end(), [&](const OpenedBox& box) {
            return off_box(spot, box.low, box.high) <= reach_m;
        });
    };
    if (!request.usable) {  // one of its ends was beside all floors
        return opened_within(at, settings_.reach_m) || opened_within(wanted, settings_.reach_m);
    }
    return request.outcome != PathOutcome::kPartial || clusters_.joined_anew(request.last) ||
           opened_within(wanted, request.short_m + kMoved_m);
}

bool NavmeshPaths::straight(Spot from, float from_y, Spot to, float to_y) const {
    Vec3 start;
    Vec3 goal;
    if (!contains(from) || !contains(to)) {
        return false;
    }
    const std::uint32_t first =
        mesh_.nearest(Vec3(from.x, from_y, from.z), kMoved_m, kAnyHeight, start);
    const std::uint32_t last = mesh_.nearest(Vec3(to.x, to_y, to.z), kMoved_m, kAnyHeight, goal);
    if (first == Navmesh::kNone || last == Navmesh::kNone || on_another_floor(from_y, start) ||
        on_another_floor(to_y, goal)) {
        return false;
    }
    const std::uint32_t end = mesh_.walk(first, start, goal, [](std::uint32_t) {});
    return end != Navmesh::kNone && (mesh_.nearest_on(end, goal) - goal).norm() <= kOnEdge_m;
}

bool NavmeshPaths::contains(Spot place) const {
    return place.x >= area_.min_x && place.x < area_.max_x && place.z >= area_.min_z &&
           place.z < area_.max_z;
}

MapExit NavmeshPaths::straight_exit(Spot from, float from_y, Spot to) {
    const std::array<bool, 4> beyond{
        to.x < area_.min_x, to.x >= area_.max_x, to.z < area_.min_z, to.z >= area_.max_z};
    MapExit best{{std::clamp(to.x, area_.min_x, std::nextafter(area_.max_x, area_.min_x)),
                  std::clamp(to.z, area_.min_z, std::nextafter(area_.max_z, area_.min_z))}};
    Vec3 on;
    const std::uint32_t node =
        mesh_.nearest(Vec3(from.x, from_y, from.z), settings_.reach_m, kAnyHeight, on);
    if (node == Navmesh::kNone) {
        return best;
    }
    clusters_.flood(node);
    float least = std::numeric_limits<float>::infinity();
    for (const Rim& rim : rims_) {
        if (!beyond[static_cast<std::size_t>(rim.side)] || !clusters_.flooded(rim.polygon)) {
            continue;
        }
        const Vec3 out = least_detour(rim.a, rim.b, from, to);
        const Spot at = flat_spot(out);
        if (const float sum = flat_distance(from, at) + flat_distance(at, to); sum < least) {
            least = sum;
            best = {at, out.y()};
        }
    }
    spend(kStepUnits * rims_.size());
    return best;
}

float NavmeshPaths::ground(Spot place) const {
    Vec3 on;
    const std::uint32_t p =
        mesh_.nearest(Vec3(place.x, kOnGround, place.z), settings_.reach_m, kAnyHeight, on);
    return p == Navmesh::kNone ? kOnGround : on.y();
}

float NavmeshPaths::floor_along(Spot from, float from_y, Spot to) const {
    Vec3 on;
    const std::uint32_t first =
        mesh_.nearest(Vec3(from.x, from_y, from.z), settings_.reach_m, kAnyHeight, on);
    if (first == Navmesh::kNone) {
        return kOnGround;
    }
    const Vec3 goal(to.x, on.y(), to.z);
    std::uint32_t last = first;
    mesh_.walk(first, on, goal, [&last](std::uint32_t p) { last = p; });
    // Beside the last one where a corner of the path lies on the edge of the mesh.
    return mesh_.nearest_on(last, goal).y();
}

std::size_t NavmeshPaths::bytes() const {
    return queue_bytes() + mesh_.bytes() + search_.bytes() + clusters_.bytes() +
           middles_.capacity() * sizeof(Vec3) +
           (first_.capacity() + to_.capacity() + return_.capacity() + hinged_.capacity() +
            corridor_.capacity()) *
               sizeof(std::uint32_t) +
           linked_.capacity() + open_.capacity() + turned_.capacity() * sizeof(std::uint32_t) +
           rims_.capacity() * sizeof(Rim);
}

}  // namespace zoned::ai::pathfinding
