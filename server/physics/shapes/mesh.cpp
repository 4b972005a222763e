#include "server/physics/shapes/mesh.h"

#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace zoned::physics {

namespace {

using MeshTables = TriangleMesh::MeshTables;
using Corners = std::array<std::uint32_t, 3>;

constexpr float kMinWeld = 1.0e-6F;

/// Cells as wide as the reach: a near vertex lies in the same cell or in one beside it.
using Cell = std::array<std::int64_t, 3>;

Cell cell_of(const Vec3& p, float reach) {
    Cell cell{};
    for (int i = 0; i < 3; ++i) {
        cell[static_cast<std::size_t>(i)] =
            static_cast<std::int64_t>(std::floor(static_cast<double>(p[i]) / reach));
    }
    return cell;
}

/// For each vertex the first one that lies at the very same place.
std::vector<std::uint32_t> weld_equal(std::span<const Vec3> vertices) {
    std::vector<std::uint32_t> order(vertices.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t i) {
        return std::tuple(vertices[i].x(), vertices[i].y(), vertices[i].z());
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return key(a) < key(b) || (key(a) == key(b) && a < b);
    });
    std::vector<std::uint32_t> same(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool as_before = i > 0 && key(order[i]) == key(order[i - 1]);
        same[order[i]] = as_before ? same[order[i - 1]] : order[i];
    }
    return same;
}

/// For each vertex the first one within reach that stands for itself.
std::vector<std::uint32_t> weld_near(std::span<const Vec3> vertices, float reach) {
    std::vector<std::pair<Cell, std::uint32_t>> cells;
    for (std::uint32_t i = 0; i < vertices.size(); ++i) {
        cells.emplace_back(cell_of(vertices[i], reach), i);
    }
    std::sort(cells.begin(), cells.end());
    constexpr std::uint32_t kFree = ~0U;
    std::vector<std::uint32_t> same(vertices.size(), kFree);
    for (std::uint32_t at = 0; at < vertices.size(); ++at) {
        if (same[at] != kFree) {
            continue;
        }
        const Cell home = cell_of(vertices[at], reach);
        for (int k = 0; k < 27; ++k) {
            const Cell cell{home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1};
            for (auto it = std::lower_bound(cells.begin(), cells.end(), std::pair(cell, 0U));
                 it != cells.end() && it->first == cell;
                 ++it) {
                const std::uint32_t other = it->second;
                if (same[other] == kFree && (vertices[other] - vertices[at]).norm() <= reach) {
                    same[other] = at;
                }
            }
        }
    }
    return same;
}

/// One side of an edge: the triangle that runs along it from `from` to `to`.
struct Side {
    std::uint32_t low, high;  // the edge's vertices, for sorting
    std::uint32_t triangle;
    std::uint8_t edge;
    bool upward;  // runs from low to high
};

std::vector<Side> sorted_sides(const std::vector<Corners>& corners) {
    std::vector<Side> sides;
    sides.reserve(3 * corners.size());
    for (std::uint32_t t = 0; t < corners.size(); ++t) {
        for (std::uint8_t e = 0; e < 3; ++e) {
            const std::uint32_t from = corners[t][e];
            const std::uint32_t to = corners[t][(e + 1U) % 3U];
            sides.push_back({std::min(from, to), std::max(from, to), t, e, from < to});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.triangle, a.edge) <
               std::tie(b.low, b.high, b.triangle, b.edge);
    });
    return sides;
}

bool bends_less(const EdgeBend& a, const EdgeBend& b) {
    return a.cosine > b.cosine;
}

Triangle triangle_at(const MeshTables& t, std::uint32_t i) {
    const Corners& c = t.corners[i];
    return {{t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]}, t.normals[i], t.bends[i], i};
}

/// The bend of one side of an edge among all triangles at it: where several go on from here, the
/// one that lies most to the front hides the others.
EdgeBend bend_at(const MeshTables& t, std::span<const Side> sides, const Side& side) {
    const Triangle triangle = triangle_at(t, side.triangle);
    EdgeBend bend = EdgeBend::open();
    bool found = false;
    for (const Side& other : sides) {
        if (other.upward == side.upward) {
            continue;  // itself, or one that faces the opposite direction
        }
        const Vec3& apex = t.vertices[t.corners[other.triangle][(other.edge + 2U) % 3U]];
        const EdgeBend b = bend_towards(triangle, side.edge, t.normals[other.triangle], apex);
        if (!found || bends_less(b, bend)) {
            bend = b;
        }
        found = true;
    }
    return bend;
}

/// Counts an edge, and keeps the first.
void note(const Side& side, std::uint32_t& count, std::array<std::uint32_t, 2>& first) {
    if (count++ == 0) {
        first = {side.low, side.high};
    }
}

/// Says why when there is an edge of too many triangles; empty otherwise.
std::string find_bends(MeshTables& t, BuiltMesh& report) {
    const std::vector<Side> sides = sorted_sides(t.corners);
    t.bends.resize(t.corners.size());
    for (std::size_t first = 0; first < sides.size();) {
        std::size_t last = first;
        while (last < sides.size() && sides[last].low == sides[first].low &&
               sides[last].high == sides[first].high) {
            ++last;
        }
        const std::span<const Side> edge(sides.data() + first, last - first);
        if (edge.size() > kMaxEdgeTriangles) {
            return "mesh: more than " + std::to_string(kMaxEdgeTriangles) +
                   " triangles at the edge of vertices " + std::to_string(edge[0].low) + " and " +
                   std::to_string(edge[0].high);
        }
        if (edge.size() == 1) {
            note(edge[0], report.open_edges, report.first_open);
        } else if (edge.size() > 2) {
            note(edge[0], report.shared_edges, report.first_shared);
        } else if (edge[0].upward == edge[1].upward) {
            note(edge[0], report.turned_edges, report.first_turned);
        }
        for (const Side& side : edge) {
            t.bends[side.triangle][side.edge] = bend_at(t, edge, side);
        }
        first = last;
    }
    return {};
}

/// Which triangles have the corners of an earlier one, in the same sense of rotation.
std::vector<bool> find_repeated(std::span<const std::uint32_t> indices,
                                const std::vector<std::uint32_t>& same) {
    std::vector<std::pair<Corners, std::uint32_t>> all;
    all.reserve(indices.size() / 3);
    for (std::uint32_t i = 0; i < indices.size() / 3; ++i) {
        Corners c{same[indices[3 * i]], same[indices[3 * i + 1]], same[indices[3 * i + 2]]};
        std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
        all.emplace_back(c, i);
    }
    std::sort(all.begin(), all.end());
    std::vector<bool> again(all.size());
    for (std::size_t k = 1; k < all.size(); ++k) {
        again[all[k].second] = all[k].first == all[k - 1].first;
    }
    return again;
}

/// Only the vertices that triangles name, in their order.
void leave_out_unused(MeshTables& t) {
    std::vector<std::uint32_t> number(t.vertices.size(), 0U);
    for (const Corners& c : t.corners) {
        for (const std::uint32_t v : c) {
            number[v] = 1;
        }
    }
    std::uint32_t kept = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] != 0) {
            t.vertices[kept] = t.vertices[v];
            number[v] = kept++;
        }
    }
    t.vertices.resize(kept);
    t.vertices.shrink_to_fit();
    for (Corners& c : t.corners) {
        for (std::uint32_t& v : c) {
            v = number[v];
        }
    }
}

Aabb box_of(const MeshTables& t, const Corners& c) {
    const Vec3& p = t.vertices[c[0]];
    const Vec3& q = t.vertices[c[1]];
    const Vec3& r = t.vertices[c[2]];
    return {p.cwiseMin(q).cwiseMin(r), p.cwiseMax(q).cwiseMax(r)};
}

/// False for a triangle without area; `normal` is noise then.
bool has_area(const MeshTables& t, const Corners& c, Vec3& normal) {
    const Vec3& p = t.vertices[c[0]];
    const Vec3& q = t.vertices[c[1]];
    const Vec3& r = t.vertices[c[2]];
    float area = 0.0F;
    normal = triangle_normal(p, q, r, area);
    const float longest =
        std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
    // Lower than a hundred thousandth of its length, its normal is noise.
    return area > 1.0e-5F * longest;
}

std::string why_unfit(std::span<const Vec3> vertices, std::size_t triangles) {
    if (triangles > kMaxMeshTriangles) {
        return "mesh: more than " + std::to_string(kMaxMeshTriangles) + " triangles";
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (!fit_position(vertices[i])) {
            return "mesh: vertex " + std::to_string(i) + " is not finite or out of range";
        }
    }
    return {};
}

std::string why_unfit(std::span<const Vec3> vertices,
                      std::span<const std::uint32_t> indices,
                      const MeshOptions& options) {
    if (indices.size() % 3 != 0) {
        return "mesh: the number of indices is no multiple of three";
    }
    if (options.weld != 0.0F && !(options.weld >= kMinWeld && options.weld <= kMaxSize)) {
        return "mesh: weld out of range";
    }
    std::string reason = why_unfit(vertices, indices.size() / 3);
    for (std::size_t i = 0; reason.empty() && i < indices.size(); ++i) {
        if (indices[i] >= vertices.size()) {
            reason = "mesh: index " + std::to_string(i) + " names no vertex";
        }
    }
    return reason;
}

/// Whether these may be a cosine and a sine of 0..180 degrees; false for NaN.
bool is_bend(const EdgeBend& bend) {
    constexpr float kOne = 1.0F + 1.0e-5F;  // rounding
    return std::abs(bend.cosine) <= kOne && bend.sine >= 0.0F && bend.sine <= kOne;
}

std::string why_unfit(const MeshParts& parts) {
    if (parts.corners.empty() || parts.bends.size() != parts.corners.size()) {
        return "mesh: has no triangles, or not as many bends";
    }
    std::string reason = why_unfit(parts.vertices, parts.corners.size());
    for (std::size_t i = 0; reason.empty() && i < parts.corners.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (parts.corners[i][k] >= parts.vertices.size()) {
                reason = "mesh: triangle " + std::to_string(i) + " names no vertex";
            } else if (!is_bend(parts.bends[i][k])) {
                reason = "mesh: triangle " + std::to_string(i) + " has no bend at an edge";
            }
        }
    }
    return reason;
}

}  // namespace

Triangle TriangleMesh::triangle(std::uint32_t i) const {
    return triangle_at(t_, i);
}

core::Result<BuiltMesh> build_mesh(std::span<const Vec3> vertices,
                                   std::span<const std::uint32_t> indices,
                                   const MeshOptions& options) {
    using Built = core::Result<BuiltMesh>;
    std::string reason = why_unfit(vertices, indices, options);
    if (!reason.empty()) {
        return Built::failure(std::move(reason));
    }
    const std::vector<std::uint32_t> same =
        options.weld > 0.0F ? weld_near(vertices, options.weld) : weld_equal(vertices);
    MeshTables t;
    t.vertices.assign(vertices.begin(), vertices.end());
    BuiltMesh out;
    std::vector<Aabb> boxes;
    std::vector<bool> named(vertices.size());
    const std::vector<bool> again = find_repeated(indices, same);
    for (std::uint32_t i = 0; i < indices.size() / 3; ++i) {
        const Corners given{indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]};
        named[given[0]] = named[given[1]] = named[given[2]] = true;
        const Corners c{same[given[0]], same[given[1]], same[given[2]]};
        Vec3 normal;
        if (!has_area(t, c, normal)) {
            out.first_degenerate = out.degenerate++ == 0 ? i : out.first_degenerate;
            continue;
        }
        if (again[i]) {
            out.first_repeated = out.repeated++ == 0 ? i : out.first_repeated;
            continue;
        }
        t.corners.push_back(c);
        t.normals.push_back(normal);
        boxes.push_back(box_of(t, c));
    }
    if (t.corners.empty()) {
        return Built::failure("mesh: no triangle has an area");
    }
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
        out.unused += named[v] ? 0 : 1;
        out.merged += named[v] && same[v] != v ? 1 : 0;
    }
    reason = find_bends(t, out);
    if (!reason.empty()) {
        return Built::failure(std::move(reason));
    }
    leave_out_unused(t);
    t.tree = BoxTree(boxes);
    out.mesh = std::make_shared<const TriangleMesh>(std::move(t));
    return out;
}

core::Result<std::shared_ptr<const TriangleMesh>> restore_mesh(MeshParts parts) {
    using Restored = core::Result<std::shared_ptr<const TriangleMesh>>;
    std::string reason = why_unfit(parts);
    if (!reason.empty()) {
        return Restored::failure(std::move(reason));
    }
    MeshTables t;
    t.vertices = std::move(parts.vertices);
    t.corners = std::move(parts.corners);
    t.bends = std::move(parts.bends);
    t.normals.resize(t.corners.size());
    std::vector<Aabb> boxes;
    boxes.reserve(t.corners.size());
    for (std::size_t i = 0; i < t.corners.size(); ++i) {
        if (!has_area(t, t.corners[i], t.normals[i])) {
            return Restored::failure("mesh: triangle " + std::to_string(i) + " has no area");
        }
        boxes.push_back(box_of(t, t.corners[i]));
    }
    auto tree = BoxTree::restore(std::move(parts.tree), boxes);
    if (!tree) {
        return Restored::failure("mesh: " + tree.error());
    }
    t.tree = std::move(*tree);
    return std::shared_ptr<const TriangleMesh>(std::make_shared<const TriangleMesh>(std::move(t)));
}

Shape Shape::mesh(std::shared_ptr<const TriangleMesh> mesh) {
    Shape shape;
    shape.kind = ShapeKind::kMesh;
    shape.geometry = std::move(mesh);
    return shape;
}

}  // namespace zoned::physics
