#include "server/physics/soft/collision/skin.h"

#include "server/physics/soft/soft_body.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace zoned::physics::soft {

namespace {

/// Faces of one tetrahedron only. Those of two tetrahedra lie within the body.
std::vector<SoftFace> boundary_of(std::span<const SoftTetrahedron> tetrahedra) {
    using Sided = std::pair<SoftFace, SoftFace>;  // corners ascending, corners in their sense
    // Outward for a tetrahedron of positive volume.
    constexpr std::array<std::array<std::size_t, 3>, 4> kSides{
        {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
    std::vector<Sided> all;
    all.reserve(4 * tetrahedra.size());
    for (const SoftTetrahedron& t : tetrahedra) {
        for (const auto& side : kSides) {
            const SoftFace face{t[side[0]], t[side[1]], t[side[2]]};
            SoftFace key = face;
            std::sort(key.begin(), key.end());
            all.emplace_back(key, face);
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<SoftFace> outer;
    for (std::size_t i = 0; i < all.size();) {
        std::size_t end = i + 1;
        while (end < all.size() && all[end].first == all[i].first) {
            ++end;
        }
        if (end == i + 1) {
            outer.push_back(all[i].second);
        }
        i = end;
    }
    return outer;
}

std::vector<SoftFace> segments_of(std::span<const Spring> springs) {
    std::vector<SoftFace> segments;
    for (const Spring& s : springs) {
        if (s.alive && s.kind == SpringKind::kStructural) {
            segments.push_back({s.a, s.b, s.b});
        }
    }
    return segments;
}

/// Each face counts by its area (a cross product is twice that).
void point_outward(SoftBody& body) {
    std::vector<Vec3>& normals = body.skin.normals;
    normals.assign(body.x.size(), Vec3::Zero());
    for (const SoftFace& f : body.skin.faces) {
        const Vec3 a = body.position(f[0]);
        const Vec3 n = (body.position(f[1]) - a).cross(body.position(f[2]) - a);
        for (const std::uint32_t corner : f) {
            normals[corner] += n;
        }
    }
    for (Vec3& n : normals) {
        n = n.normalized();  // a node within stays zero
    }
}

}  // namespace

bool is_closed(std::span<const SoftFace> faces) {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Edge> there;
    std::vector<Edge> back;
    for (const SoftFace& f : faces) {
        for (std::size_t i = 0; i < 3; ++i) {
            there.emplace_back(f[i], f[(i + 1) % 3]);
            back.emplace_back(f[(i + 1) % 3], f[i]);
        }
    }
    std::sort(there.begin(), there.end());
    std::sort(back.begin(), back.end());
    return !faces.empty() && there == back &&
           std::adjacent_find(there.begin(), there.end()) == there.end();
}

void find_skin(SoftBody& body) {
    SoftSkin& skin = body.skin;
    if (skin.closed && (body.gas > 0.0 || body.faces.empty())) {
        return;  // no tear changes a surface that holds gas, nor tetrahedra
    }
    skin = SoftSkin();
    if (is_closed(body.faces)) {
        skin.faces = body.faces;
        skin.closed = true;
    } else if (!body.tetrahedra.empty()) {
        skin.faces = boundary_of(body.tetrahedra);
        skin.closed = true;
    } else if (!body.faces.empty()) {
        skin.faces = body.faces;
    } else {
        skin.faces = segments_of(body.springs);
        skin.segments = true;
    }
    for (const SoftFace& f : skin.faces) {
        skin.nodes.insert(skin.nodes.end(), f.begin(), f.end());
    }
    std::sort(skin.nodes.begin(), skin.nodes.end());
    skin.nodes.erase(std::unique(skin.nodes.begin(), skin.nodes.end()), skin.nodes.end());
}

void fit_skin(SoftBody& body) {
    SoftSkin& skin = body.skin;
    const bool fresh = skin.boxes.empty();
    skin.boxes.resize(skin.faces.size());
    for (std::size_t i = 0; i < skin.faces.size(); ++i) {
        const SoftFace& f = skin.faces[i];
        const Vec3 a = body.position(f[0]);
        const Vec3 b = body.position(f[1]);
        const Vec3 c = body.position(f[2]);
        skin.boxes[i] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    }
    if (fresh) {
        skin.rows.resize(skin.faces.size());
        std::iota(skin.rows.begin(), skin.rows.end(), 0U);
        skin.tree.reserve(skin.faces.size());
        for (const std::uint32_t row : skin.rows) {
            skin.tree.insert(row, skin.boxes[row]);
        }
        skin.tree.rebuild();
    } else {
        skin.tree.update(skin.rows, skin.boxes);
    }
    if (skin.closed) {
        point_outward(body);
    }
}

}  // namespace zoned::physics::soft
