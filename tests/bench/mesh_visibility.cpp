#include "tests/bench/mesh_visibility.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace zoned::bench {

namespace {

using ai::pathfinding::Navmesh;

/// The distance by which rounding may put a point beside an edge, m.
constexpr float kOnCorner_m = 1e-2F;

}  // namespace

MeshVisibility::MeshVisibility(const Navmesh& mesh)
    : mesh_(mesh),
      polygons_(mesh.vertices().size()),
      seen_(mesh.vertices().size()) {
    std::vector<std::uint8_t> turns(mesh.vertices().size(), 0);
    for (std::uint32_t p = 0; p < mesh.polygons().size(); ++p) {
        const Navmesh::Polygon& polygon = mesh.polygons()[p];
        for (int i = 0; i < polygon.size; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const auto next = static_cast<std::size_t>(i + 1 == polygon.size ? 0 : i + 1);
            polygons_[polygon.corners[at]].push_back(p);
            if (polygon.neighbours[at] == Navmesh::kNone) {
                turns[polygon.corners[at]] = turns[polygon.corners[next]] = 1;
            }
        }
    }
    for (std::uint32_t v = 0; v < turns.size(); ++v) {
        if (turns[v] != 0) {
            turning_.push_back(v);
        }
    }
    const std::span<const Vec3> places = mesh.vertices();
    for (const std::uint32_t a : turning_) {
        for (const std::uint32_t b : turning_) {
            const bool seen = a < b && std::any_of(
                                           polygons_[a].begin(),
                                           polygons_[a].end(),
                                           [&](auto p) { return sees(p, places[a], places[b]); });
            if (seen) {
                const auto length = static_cast<double>((places[b] - places[a]).norm());
                seen_[a].push_back({b, length});
                seen_[b].push_back({a, length});
            }
        }
    }
}

bool MeshVisibility::sees(std::uint32_t polygon, const Vec3& from, const Vec3& to) const {
    const std::uint32_t end = mesh_.walk(polygon, from, to, [](std::uint32_t) {});
    return end != Navmesh::kNone && (mesh_.nearest_on(end, to) - to).norm() <= kOnCorner_m;
}

std::vector<MeshVisibility::Seen> MeshVisibility::seen_from(std::uint32_t polygon,
                                                            const Vec3& place) const {
    std::vector<Seen> out;
    for (const std::uint32_t v : turning_) {
        const Vec3& at = mesh_.vertices()[v];
        if (sees(polygon, place, at)) {
            out.push_back({v, static_cast<double>((at - place).norm())});
        }
    }
    return out;
}

double MeshVisibility::shortest(const Vec3& from, const Vec3& to, float reach_m) {
    Vec3 start;
    Vec3 goal;
    const std::uint32_t first = mesh_.nearest(from, reach_m, start);
    const std::uint32_t last = mesh_.nearest(to, reach_m, goal);
    if (first == Navmesh::kNone || last == Navmesh::kNone) {
        return -1.0;
    }
    if (sees(first, start, goal)) {
        return static_cast<double>((goal - start).norm());
    }
    constexpr double kFar = std::numeric_limits<double>::infinity();
    using Open = std::pair<double, std::uint32_t>;
    std::vector<double> length(mesh_.vertices().size(), kFar);
    std::vector<double> rest(mesh_.vertices().size(), kFar);
    for (const Seen& s : seen_from(last, goal)) {
        rest[s.vertex] = s.length;
    }
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    const auto reach = [&](std::uint32_t v, double by) {
        if (by < length[v]) {
            length[v] = by;
            open.emplace(by, v);
        }
    };
    for (const Seen& s : seen_from(first, start)) {
        reach(s.vertex, s.length);
    }
    double best = kFar;
    while (!open.empty() && open.top().first < best) {
        const auto [by, v] = open.top();
        open.pop();
        if (by > length[v]) {
            continue;
        }
        best = std::min(best, by + rest[v]);
        for (const Seen& s : seen_[v]) {
            reach(s.vertex, by + s.length);
        }
    }
    return best < kFar ? best : -1.0;
}

}  // namespace zoned::bench
