// Collision of a body's nodes with each other: pairs found once per step in a hashed grid (Teschner
// et al., "Optimized Spatial Hashing for Collision Detection of Deformable Objects", 2003), kept
// apart in each substep. A grid of its own beside spatial::PointGrid: cloth folds in all three
// dimensions, and its cells need no bounds.
#include "server/physics/soft/soft_body.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

std::uint64_t link_of(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
}

std::uint32_t cell_of(int x, int y, int z) {
    return static_cast<std::uint32_t>(x) * 73856093U ^ static_cast<std::uint32_t>(y) * 19349663U ^
           static_cast<std::uint32_t>(z) * 83492791U;
}

/// How close nodes may come: no closer than twice the thickness, but springs are shorter at times.
float least_distance(const SoftBody& body) {
    float shortest = INFINITY;
    for (const Spring& s : body.springs) {
        shortest = s.alive ? std::min(shortest, s.rest) : shortest;
    }
    return std::min(2.0F * body.material.thickness, shortest);
}

Eigen::Vector3i cell_at(const Vec3& x, float size) {
    return (x / size).array().floor().cast<int>();
}

void pair_up(SoftBody& body, std::uint32_t i, const Eigen::Vector3i& cell, float reach) {
    const std::uint64_t key = std::uint64_t{cell_of(cell.x(), cell.y(), cell.z())} << 32U;
    auto it = std::lower_bound(body.grid.begin(), body.grid.end(), key);
    for (; it != body.grid.end() && *it >> 32U == key >> 32U; ++it) {
        const auto j = static_cast<std::uint32_t>(*it);
        if (j > i && (body.x[i] - body.x[j]).head<3>().squaredNorm() < reach * reach &&
            !std::binary_search(body.linked.begin(), body.linked.end(), link_of(i, j))) {
            body.close_pairs.push_back({i, j});
        }
    }
}

}  // namespace

void find_close_pairs(SoftBody& body) {
    body.close_pairs.clear();
    if (!body.material.self_collision) {
        return;
    }
    if (body.linked.empty()) {
        for (const Spring& s : body.springs) {
            body.linked.push_back(link_of(s.a, s.b));
        }
        std::sort(body.linked.begin(), body.linked.end());
    }
    // Half as far again, so that nodes that come close within the step are among them.
    const float reach = 1.5F * least_distance(body);
    body.grid.clear();
    for (std::uint32_t i = 0; i < body.x.size(); ++i) {
        const Eigen::Vector3i c = cell_at(body.position(i), reach);
        body.grid.push_back((std::uint64_t{cell_of(c.x(), c.y(), c.z())} << 32U) | i);
    }
    std::sort(body.grid.begin(), body.grid.end());
    for (std::uint32_t i = 0; i < body.x.size(); ++i) {
        const Eigen::Vector3i c = cell_at(body.position(i), reach);
        for (int k = 0; k < 27; ++k) {
            pair_up(body, i, c + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1), reach);
        }
    }
    // Two of the 27 cells may share a hash: their pairs come twice.
    std::sort(body.close_pairs.begin(), body.close_pairs.end());
    body.close_pairs.erase(std::unique(body.close_pairs.begin(), body.close_pairs.end()),
                           body.close_pairs.end());
}

void solve_close_pairs(SoftBody& body) {
    if (body.close_pairs.empty()) {
        return;
    }
    const float least = least_distance(body);
    for (const auto& [i, j] : body.close_pairs) {
        const Vec3 d = body.position(j) - body.position(i);
        const float length = d.norm();
        const float mass = body.x[i].w() + body.x[j].w();
        if (length < least && length > 1.0e-9F && mass > 0.0F) {
            const Vec3 push = (least - length) / (mass * length) * d;
            body.x[i].head<3>() -= body.x[i].w() * push;
            body.x[j].head<3>() += body.x[j].w() * push;
        }
    }
}

}  // namespace zoned::physics::soft
