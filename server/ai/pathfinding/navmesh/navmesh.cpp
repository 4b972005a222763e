#include "server/ai/pathfinding/navmesh/navmesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kIndexCell_m = 4.0F;
constexpr int kMostIndexCells = 1000;  ///< to a side

/// Twice the area of a triangle over x and z; its sign is the sense of its corners.
float turn(const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.x() - a.x()) * (c.z() - a.z()) - (c.x() - a.x()) * (b.z() - a.z());
}

/// OverTriangle: a place relative to a triangle of either sense, over x and z.
struct OverTriangle {
    float depth = 0.0F;   ///< >= 0: the place is above or below it; else how far outside
    float height = 0.0F;  ///< of its plane at the place
};

OverTriangle over_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& place) {
    const float whole = turn(a, b, c);
    if (whole == 0.0F) {
        return {-std::numeric_limits<float>::infinity(), a.y()};
    }
    const float u = turn(a, place, c) / whole;
    const float v = turn(a, b, place) / whole;
    const float w = turn(place, b, c) / whole;
    return {std::min({u, v, w}), w * a.y() + u * b.y() + v * c.y()};
}

Vec3 middle_of(const Navmesh& mesh, const Navmesh::Polygon& polygon) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < polygon.size; ++i) {
        sum += mesh.vertices()[polygon.corners[static_cast<std::size_t>(i)]];
    }
    return sum / static_cast<float>(polygon.size);
}

/// The ends of a polygon's edge `i`.
std::array<Vec3, 2> edge_of(const Navmesh& mesh, const Navmesh::Polygon& polygon, int i) {
    const int next = i + 1 == polygon.size ? 0 : i + 1;
    return {mesh.vertices()[polygon.corners[static_cast<std::size_t>(i)]],
            mesh.vertices()[polygon.corners[static_cast<std::size_t>(next)]]};
}

}  // namespace

Navmesh Navmesh::of(std::vector<Vec3> vertices, std::vector<Polygon> polygons) {
    Navmesh mesh;
    mesh.vertices_ = std::move(vertices);
    mesh.polygons_ = std::move(polygons);
    mesh.finish();
    return mesh;
}

void Navmesh::finish() {
    for (Polygon& p : polygons_) {
        float area = 0.0F;
        for (int i = 2; i < p.size; ++i) {
            area += turn(vertices_[p.corners[0]],
                         vertices_[p.corners[static_cast<std::size_t>(i) - 1]],
                         vertices_[p.corners[static_cast<std::size_t>(i)]]);
        }
        if (area < 0.0F) {
            // The edge after the last corner stays the last one.
            std::reverse(p.corners.begin(), p.corners.begin() + p.size);
            std::reverse(p.neighbours.begin(), p.neighbours.begin() + p.size - 1);
        }
    }
    passable_.assign(polygons_.size(), 0);
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        passable_[p] = gates_[polygons_[p].gate].open ? 1 : 0;
    }
    index_polygons();
}

int Navmesh::exit_edge(std::uint32_t number,
                       std::uint32_t before,
                       const Vec3& from,
                       const Vec3& to) const {
    // The part of the line within the polygon ends at the first of the edges that it leads out
    // through (Cyrus and Beck, Computers and Graphics 3, 1978). Of edges that it meets at their
    // common corner the one beyond which it goes on.
    constexpr float kSame = 1e-5F;
    const Polygon& p = polygons_[number];
    int best = -1;
    float least = 1.0F;
    bool on = false;
    for (int e = 0; e < p.size; ++e) {
        const std::array<Vec3, 2> edge = edge_of(*this, p, e);
        const float end = turn(edge[0], edge[1], to);
        const float begin = turn(edge[0], edge[1], from);
        if (end >= 0.0F || begin - end <= 0.0F) {
            continue;  // the end lies within, or the line leads in or along
        }
        const std::uint32_t next = p.neighbours[static_cast<std::size_t>(e)];
        if (next != kNone && next == before) {
            continue;  // rounding: it has come in there
        }
        const float at = begin / (begin - end);
        const bool goes_on = next != kNone && passable(next);
        if (at < least - kSame || (at <= least + kSame && (best < 0 || (goes_on && !on)))) {
            best = e;
            least = at;
            on = goes_on;
        }
    }
    return best;
}

Vec3 Navmesh::nearest_on(std::uint32_t number, const Vec3& place) const {
    const Polygon& p = polygons_[number];
    float height = 0.0F;
    if (over(number, place, height)) {
        return {place.x(), height, place.z()};
    }
    Vec3 best = Vec3::Zero();
    float least = std::numeric_limits<float>::infinity();
    for (int e = 0; e < p.size; ++e) {
        const Vec3 near = nearest_on_edge(number, e, place);
        if (const float d = (near - place).squaredNorm(); d < least) {
            least = d;
            best = near;
        }
    }
    return best;
}

void Navmesh::index_polygons() {
    if (vertices_.empty()) {
        listed_.build(1, 0, [](std::uint32_t, const auto&) {});
        return;
    }
    float max_x = vertices_.front().x();
    float max_z = vertices_.front().z();
    min_x_ = max_x;
    min_z_ = max_z;
    for (const Vec3& v : vertices_) {
        min_x_ = std::min(min_x_, v.x());
        min_z_ = std::min(min_z_, v.z());
        max_x = std::max(max_x, v.x());
        max_z = std::max(max_z, v.z());
    }
    const auto cells = [](float length) {
        return std::min(static_cast<int>(length / kIndexCell_m) + 1, kMostIndexCells);
    };
    across_ = cells(max_x - min_x_);
    down_ = cells(max_z - min_z_);
    const auto cells_of = [this](std::uint32_t p, const auto& take) {
        int left = across_;
        int right = 0;
        int top = down_;
        int bottom = 0;
        for (int i = 0; i < polygons_[p].size; ++i) {
            const Vec3& v = vertices_[polygons_[p].corners[static_cast<std::size_t>(i)]];
            const int x = std::min(static_cast<int>((v.x() - min_x_) / kIndexCell_m), across_ - 1);
            const int z = std::min(static_cast<int>((v.z() - min_z_) / kIndexCell_m), down_ - 1);
            left = std::min(left, x);
            right = std::max(right, x);
            top = std::min(top, z);
            bottom = std::max(bottom, z);
        }
        for (int z = top; z <= bottom; ++z) {
            for (int x = left; x <= right; ++x) {
                take(static_cast<std::size_t>(z * across_ + x));
            }
        }
    };
    listed_.build(static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_),
                  static_cast<std::uint32_t>(polygons_.size()),
                  cells_of);
}

bool Navmesh::over(std::uint32_t number, const Vec3& place, float& height) const {
    // A fan of triangles; the edges of neighbours belong to both.
    const Polygon& polygon = polygons_[number];
    for (int i = 1; i + 1 < polygon.size; ++i) {
        const OverTriangle at =
            over_triangle(vertices_[polygon.corners[0]],
                          vertices_[polygon.corners[static_cast<std::size_t>(i)]],
                          vertices_[polygon.corners[static_cast<std::size_t>(i) + 1]],
                          place);
        if (at.depth >= 0.0F) {
            height = relief_at(number, place, at.height);
            return true;
        }
    }
    return false;
}

float Navmesh::relief_at(std::uint32_t number, const Vec3& place, float height) const {
    if (relief_first_.empty()) {
        return height;
    }
    // On an edge, or between two triangles, it may be beside all of them by rounding.
    float deepest = -std::numeric_limits<float>::infinity();
    for (std::uint32_t t = relief_first_[number]; t < relief_first_[number + 1] && deepest < 0.0F;
         ++t) {
        const OverTriangle at = over_triangle(relief_[t][0], relief_[t][1], relief_[t][2], place);
        if (at.depth > deepest) {
            deepest = at.depth;
            height = at.height;
        }
    }
    return height;
}

Vec3 Navmesh::nearest_on_edge(std::uint32_t number, int i, const Vec3& place) const {
    const std::array<Vec3, 2> edge = edge_of(*this, polygons_[number], i);
    const Vec3 path = edge[1] - edge[0];
    const Vec2 along(path.x(), path.z());
    const Vec2 offset(place.x() - edge[0].x(), place.z() - edge[0].z());
    const float squared = along.squaredNorm();
    const float share = squared > 0.0F ? std::clamp(offset.dot(along) / squared, 0.0F, 1.0F) : 0.0F;
    Vec3 near = edge[0] + share * path;
    near.y() = relief_at(number, near, near.y());
    return near;
}

std::uint32_t Navmesh::nearest(const Vec3& place, float reach_m, float height_m, Vec3& on) const {
    const bool on_ground = std::isnan(place.y());
    std::uint32_t best = kNone;
    float least = std::numeric_limits<float>::infinity();
    const auto cell = [](float offset, int cells) {
        return static_cast<int>(
            std::clamp(offset / kIndexCell_m, 0.0F, static_cast<float>(cells - 1)));
    };
    const auto consider = [&](std::uint32_t p, float off, const Vec3& at) {
        if (off < least || (off == least && p < best)) {
            least = off;
            best = p;
            on = at;
        }
    };
    const auto over_or_under = [&](std::uint32_t p) {
        float height = 0.0F;
        if (over(p, place, height)) {
            const float off = on_ground ? height : std::abs(height - place.y());
            // A floor far above or below the place is not the place's floor.
            if (on_ground || off <= height_m) {
                consider(p, off, Vec3(place.x(), height, place.z()));
            }
        }
    };
    const auto visit = [&](float reach, const auto& take) {
        const int left = cell(place.x() - reach - min_x_, across_);
        const int right = cell(place.x() + reach - min_x_, across_);
        const int top = cell(place.z() - reach - min_z_, down_);
        const int bottom = cell(place.z() + reach - min_z_, down_);
        for (int z = top; z <= bottom; ++z) {
            for (int x = left; x <= right; ++x) {
                const auto at = static_cast<std::size_t>(z * across_ + x);
                for (const std::uint32_t p : listed_.of(at)) {
                    if (passable(p)) {
                        take(p);
                    }
                }
            }
        }
    };
    visit(0.0F, over_or_under);
    if (best != kNone && (on_ground || least <= kOnFloor_m)) {
        return best;
    }
    const bool on_another = best != kNone;
    visit(reach_m, [&](std::uint32_t p) {
        for (int e = 0; e < polygons_[p].size; ++e) {
            const Vec3 near = nearest_on_edge(p, e, place);
            const Vec3 path = near - place;
            const float off = on_ground ? Vec2(path.x(), path.z()).norm() : path.norm();
            if (off <= reach_m && !(on_another && std::abs(path.y()) > kOnFloor_m)) {
                consider(p, off, near);
            }
        }
    });
    return best;
}

std::size_t Navmesh::bytes() const {
    return vertices_.capacity() * sizeof(Vec3) + polygons_.capacity() * sizeof(Polygon) +
           relief_.capacity() * sizeof(relief_[0]) +
           relief_first_.capacity() * sizeof(std::uint32_t) + passable_.capacity() +
           gates_.capacity() * sizeof(Gate) + listed_.bytes();
}

NavmeshSearch::NavmeshAnswer NavmeshSearch::plan(const Navmesh& mesh,
                                                 const Vec3& from,
                                                 const Vec3& to,
                                                 float reach_m,
                                                 std::uint32_t max_work) {
    Vec3 start;
    Vec3 goal;
    corners_.clear();
    const std::uint32_t first = mesh.nearest(from, reach_m, start);
    const std::uint32_t last = mesh.nearest(to, reach_m, goal);
    if (first == Navmesh::kNone || last == Navmesh::kNone) {
        NavmeshAnswer none;
        none.outcome =
            first == Navmesh::kNone ? PathOutcome::kStartBlocked : PathOutcome::kGoalBlocked;
        return none;
    }
    return plan(mesh, first, last, start, goal, max_work);
}

NavmeshSearch::NavmeshAnswer NavmeshSearch::plan(const Navmesh& mesh,
                                                 std::uint32_t first,
                                                 std::uint32_t last,
                                                 const Vec3& from,
                                                 const Vec3& to,
                                                 std::uint32_t max_work) {
    NavmeshAnswer answer;
    corners_.clear();
    if (find(mesh, first, last, from, to, max_work, answer)) {
        pull(mesh, from, to);
        answer.outcome = PathOutcome::kFound;
        answer.length_m = length();
    }
    return answer;
}

NavmeshSearch::NavmeshAnswer NavmeshSearch::follow(const Navmesh& mesh,
                                                   std::span<const std::uint32_t> polygons,
                                                   const Vec3& from,
                                                   const Vec3& to) {
    corridor_.assign(polygons.begin(), polygons.end());
    corners_.clear();
    pull(mesh, from, to);
    return {PathOutcome::kFound, length(), static_cast<std::uint32_t>(polygons.size())};
}

float NavmeshSearch::length() const {
    float length = 0.0F;
    for (std::size_t i = 1; i < corners_.size(); ++i) {
        length += (corners_[i] - corners_[i - 1]).norm();
    }
    return length;
}

std::size_t NavmeshSearch::bytes() const {
    return known_.capacity() * sizeof(KnownPolygon) + open_.bytes() +
           (corridor_.capacity() + passed_.capacity()) * sizeof(std::uint32_t) +
           gates_.capacity() * sizeof(std::array<Vec3, 2>) + corners_.capacity() * sizeof(Vec3);
}

void NavmeshSearch::reach(std::uint32_t polygon,
                          float cost,
                          std::uint32_t from,
                          const Vec3& entry,
                          const Vec3& to) {
    KnownPolygon& k = known_[polygon];
    if (k.search == search_ && k.cost <= cost) {
        return;
    }
    k = {cost, from, search_, entry};
    open_.push({cost + (to - entry).norm(), polygon, cost});
}

bool NavmeshSearch::find(const Navmesh& mesh,
                         std::uint32_t first,
                         std::uint32_t last,
                         const Vec3& from,
                         const Vec3& to,
                         std::uint32_t max_work,
                         NavmeshAnswer& answer) {
    if (known_.size() != mesh.polygons().size() || ++search_ == 0) {
        known_.assign(mesh.polygons().size(), KnownPolygon{});
        search_ = 1;
    }
    open_.clear();
    reach(first, 0.0F, first, from, to);
    while (!open_.empty()) {
        const OpenPolygon at = open_.pop();
        if (at.cost > known_[at.node].cost) {
            continue;
        }
        if (answer.work++ == max_work) {
            answer.outcome = PathOutcome::kCutOff;
            return false;
        }
        if (at.node == last) {
            corridor_.assign(1, last);
            for (std::uint32_t p = last; p != first; p = known_[p].from) {
                corridor_.push_back(known_[p].from);
            }
            std::reverse(corridor_.begin(), corridor_.end());
            return true;
        }
        const Navmesh::Polygon& polygon = mesh.polygons()[at.node];
        const Vec3 entry = known_[at.node].entry;
        for (int e = 0; e < polygon.size; ++e) {
            const std::uint32_t next = polygon.neighbours[static_cast<std::size_t>(e)];
            if (next != Navmesh::kNone && mesh.passable(next)) {
                const std::array<Vec3, 2> edge = edge_of(mesh, polygon, e);
                const Vec3 middle = 0.5F * (edge[0] + edge[1]);
                reach(next, at.cost + (middle - entry).norm(), at.node, middle, to);
            }
        }
    }
    return false;
}

void NavmeshSearch::pull(const Navmesh& mesh, const Vec3& from, const Vec3& to) {
    gates_.clear();
    for (std::size_t i = 0; i + 1 < corridor_.size(); ++i) {
        const Navmesh::Polygon& polygon = mesh.polygons()[corridor_[i]];
        for (int e = 0; e < polygon.size; ++e) {
            if (polygon.neighbours[static_cast<std::size_t>(e)] == corridor_[i + 1]) {
                std::array<Vec3, 2> gate = edge_of(mesh, polygon, e);
                if (turn(middle_of(mesh, polygon), gate[0], gate[1]) < 0.0F) {
                    std::swap(gate[0], gate[1]);
                }
                gates_.push_back(gate);
                break;
            }
        }
    }
    gates_.push_back({to, to});
    // The region seen from the last corner through all gates so far lies between two lines. Where
    // the lines cross, the corner is the end that bars the view.
    passed_.clear();
    turn_at(from, 0);
    passed_.back() = 0;
    std::size_t apex = 0;  // gates before this one lie behind the last corner
    while (apex < gates_.size()) {
        const Vec3 corner = corners_.back();
        std::array<std::size_t, 2> at{apex, apex};  // gates whose ends bound the view
        bool turned = false;
        for (std::size_t i = apex; i < gates_.size() && !turned; ++i) {
            const Vec3& left = gates_[at[0]][0];
            const Vec3& right = gates_[at[1]][1];
            if (turn(corner, right, gates_[i][1]) <= 0.0F) {
                if (turn(corner, left, gates_[i][1]) < 0.0F) {
                    turn_at(left, at[0]);
                    apex = at[0] + 1;
                    turned = true;
                    continue;
                }
                at[1] = i;
            }
            if (turn(corner, left, gates_[i][0]) >= 0.0F) {
                if (turn(corner, gates_[at[1]][1], gates_[i][0]) > 0.0F) {
                    turn_at(gates_[at[1]][1], at[1]);
                    apex = at[1] + 1;
                    turned = true;
                    continue;
                }
                at[0] = i;
            }
        }
        if (!turned) {
            break;
        }
    }
    if (corners_.back() != to || corners_.size() == 1) {
        turn_at(to, gates_.size() - 1);
    }
}

void NavmeshSearch::turn_at(const Vec3& corner, std::size_t gate) {
    corners_.push_back(corner);
    passed_.push_back(static_cast<std::uint32_t>(gate) + 1);
}

}  // namespace zoned::ai::pathfinding
