#include "server/physics/shapes/convex/hull_faces.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace zoned::physics {

namespace {

constexpr int kNoRegion = -1;

class Merger {
  public:
    Merger(std::span<const Vec3d> points, const TriangleHull& hull, double tolerance)
        : points_(points),
          triangles_(hull.triangles),
          tolerance_(tolerance),
          region_(hull.triangles.size(), kNoRegion) {}

    void grow_regions();
    /// Empty when the regions do not make up a proper polyhedron.
    [[nodiscard]] FaceLoops loops() const;

  private:
    [[nodiscard]] const Vec3d& at(int point) const {
        return points_[static_cast<std::size_t>(point)];
    }

    [[nodiscard]] const SurfaceTriangle& triangle(int t) const {
        return triangles_[static_cast<std::size_t>(t)];
    }

    /// Twice the area, outward.
    [[nodiscard]] Vec3d area_vector(int t) const {
        const auto& c = triangle(t).corner;
        return (at(c[1]) - at(c[0])).cross(at(c[2]) - at(c[0]));
    }

    void flood(int seed, int region);
    [[nodiscard]] std::vector<int> outline(int region) const;
    [[nodiscard]] bool is_convex(const std::vector<int>& loop) const;

    std::span<const Vec3d> points_;
    std::span<const SurfaceTriangle> triangles_;
    double tolerance_;
    std::vector<int> region_;
    int regions_ = 0;
};

void Merger::flood(int seed, int region) {
    const Vec3d normal = area_vector(seed).normalized();
    const double offset = normal.dot(at(triangle(seed).corner[0]));
    std::vector<int> stack{seed};
    region_[static_cast<std::size_t>(seed)] = region;
    while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (const int n : triangle(t).neighbour) {
            const auto& corners = triangle(n).corner;
            const bool flat = std::all_of(corners.begin(), corners.end(), [&](int c) {
                return std::abs(normal.dot(at(c)) - offset) <= tolerance_;
            });
            if (region_[static_cast<std::size_t>(n)] == kNoRegion && flat &&
                area_vector(n).dot(normal) >= 0.0) {
                region_[static_cast<std::size_t>(n)] = region;
                stack.push_back(n);
            }
        }
    }
}

void Merger::grow_regions() {
    std::vector<int> order(triangles_.size());
    std::iota(order.begin(), order.end(), 0);
    std::vector<double> area;
    for (const int t : order) {
        area.push_back(area_vector(t).norm());
    }
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return area[static_cast<std::size_t>(a)] > area[static_cast<std::size_t>(b)];
    });
    for (const int t : order) {
        if (region_[static_cast<std::size_t>(t)] == kNoRegion) {
            flood(t, regions_++);
        }
    }
}

/// The boundary of a region as one closed line; empty when it is more than one.
std::vector<int> Merger::outline(int region) const {
    std::map<int, int> next;
    std::size_t edges = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        for (std::size_t e = 0; region_[t] == region && e < 3; ++e) {
            const int across = triangles_[t].neighbour[e];
            if (region_[static_cast<std::size_t>(across)] != region) {
                next[triangles_[t].corner[e]] = triangles_[t].corner[(e + 1) % 3];
                ++edges;
            }
        }
    }
    std::vector<int> loop;
    if (next.size() != edges || next.empty()) {
        return loop;
    }
    const int start = next.begin()->first;
    int at = start;
    do {
        loop.push_back(at);
        at = next[at];
    } while (at != start && loop.size() <= edges);
    return loop.size() == edges ? loop : std::vector<int>();
}

bool Merger::is_convex(const std::vector<int>& loop) const {
    const std::size_t n = loop.size();
    Vec3d normal = Vec3d::Zero();
    for (std::size_t i = 1; i + 1 < n; ++i) {
        normal += (at(loop[i]) - at(loop[0])).cross(at(loop[i + 1]) - at(loop[0]));
    }
    normal.normalize();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d in = at(loop[(i + 1) % n]) - at(loop[i]);
        const Vec3d out = at(loop[(i + 2) % n]) - at(loop[(i + 1) % n]);
        const double longer = std::max(in.norm(), out.norm());
        if (!(normal.dot(in.cross(out)) >= -2.0 * tolerance_ * longer)) {
            return false;
        }
    }
    return true;
}

FaceLoops Merger::loops() const {
    std::map<int, std::set<int>> regions_at;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        for (const int c : triangles_[t].corner) {
            regions_at[c].insert(region_[t]);
        }
    }
    FaceLoops out;
    std::set<std::pair<int, int>> edges;
    std::set<int> corners;
    for (int region = 0; region < regions_; ++region) {
        std::vector<int> loop = outline(region);
        loop.erase(std::remove_if(
                       loop.begin(), loop.end(), [&](int c) { return regions_at[c].size() < 3; }),
                   loop.end());
        if (loop.size() < 3 || !is_convex(loop)) {
            return {};
        }
        for (std::size_t i = 0; i < loop.size(); ++i) {
            if (!edges.emplace(loop[i], loop[(i + 1) % loop.size()]).second) {
                return {};
            }
        }
        corners.insert(loop.begin(), loop.end());
        out.push_back(std::move(loop));
    }
    const bool paired = std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        return edges.count({edge.second, edge.first}) == 1;
    });
    // Euler's formula: a sphere, in one piece.
    return paired && corners.size() + out.size() == edges.size() / 2 + 2 ? out : FaceLoops();
}

}  // namespace

FaceLoops merge_faces(std::span<const Vec3d> points, const TriangleHull& hull, double tolerance) {
    Merger merger(points, hull, tolerance);
    merger.grow_regions();
    FaceLoops loops = merger.loops();
    if (loops.empty()) {
        for (const SurfaceTriangle& t : hull.triangles) {
            loops.emplace_back(t.corner.begin(), t.corner.end());
        }
    }
    return loops;
}

}  // namespace zoned::physics
