#include "server/config/world/terrain.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace zoned::config {

namespace {

constexpr float kEverywhere_m = 1e6F;
constexpr float kLevel_m = 0.01F;

constexpr int kSpokes = 8;
// sqrt(1/2) by hand: the same bits from every mathematics library.
constexpr float kD = 0.70710678F;
constexpr float kSpoke[kSpokes][2] =
    {{1, 0}, {kD, kD}, {0, 1}, {-kD, kD}, {-1, 0}, {-kD, -kD}, {0, -1}, {kD, -kD}};

/// Upper end of the part of the vertical line through (x, z) that lies in the box; false when it
/// misses. Slab method (Kay, Kajiya, SIGGRAPH 1986) in the box's own axes.
bool top_of_box(const motion::StaticBox& box, float x, float z, float& top) {
    const Quat inverse = box.orientation.conjugate();
    const Vec3 origin = inverse * Vec3(x - box.centre.x(), -box.centre.y(), z - box.centre.z());
    const Vec3 direction = inverse * Vec3::UnitY();
    float enter = -kEverywhere_m;
    float leave = kEverywhere_m;
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(direction[axis]) < 1e-6F) {
            if (std::abs(origin[axis]) > box.half_extents[axis]) {
                return false;
            }
            continue;
        }
        float a = (-box.half_extents[axis] - origin[axis]) / direction[axis];
        float b = (box.half_extents[axis] - origin[axis]) / direction[axis];
        if (a > b) {
            std::swap(a, b);
        }
        enter = std::max(enter, a);
        leave = std::min(leave, b);
    }
    top = leave;
    return enter <= leave;
}

std::vector<motion::StaticSurface> in_world_coordinates(
    const std::vector<SurfaceSettings>& surfaces) {
    std::vector<motion::StaticSurface> out;
    out.reserve(surfaces.size());
    for (const SurfaceSettings& surface : surfaces) {
        out.push_back(surface.around(Vec3d::Zero()));
    }
    return out;
}

/// True when `area` neither meets a triangle nor lies in the solid behind them.
bool surface_clear(const Aabb& area, const motion::PlacedSurface& placed) {
    const Vec3 centre = 0.5F * (area.lower + area.upper);
    const Vec3 half = 0.5F * (area.upper - area.lower);
    const Vec3 local = placed.to_local(centre);
    if (placed.surface().behind(local)) {
        return false;
    }
    const float around = elementary::hypot(half.x(), half.z());
    const Vec3 reach(around, half.y(), around);
    bool free = true;
    placed.surface().for_each_near({local - reach, local + reach}, [&](const FacedTriangle& t) {
        FacedTriangle turned;
        for (std::size_t i = 0; i < 3; ++i) {
            turned.corner[i] = placed.to_world(t.corner[i]);
        }
        turned.normal = placed.turned_to_world(t.normal);
        free = free && !box_triangle_overlap(centre, half, turned);
    });
    return free;
}

}  // namespace

bool boxes_overlap(const Aabb& area, const motion::StaticBox& box) {
    const Vec3 half = 0.5F * (area.upper - area.lower);
    const Vec3 offset = box.centre - 0.5F * (area.upper + area.lower);
    const Mat3 axes = box.orientation.toRotationMatrix();
    const auto separates = [&](const Vec3& axis) {
        const float length = axis.norm();
        if (length < 1e-4F) {
            return false;  // parallel edges: their faces' axes decide
        }
        const float reach =
            half.dot(axis.cwiseAbs()) + box.half_extents.dot((axes.transpose() * axis).cwiseAbs());
        return std::abs(offset.dot(axis)) >= reach;
    };
    for (int i = 0; i < 3; ++i) {
        if (separates(Vec3::Unit(i)) || separates(axes.col(i))) {
            return false;
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (separates(Vec3::Unit(i).cross(Vec3(axes.col(j))))) {
                return false;
            }
        }
    }
    return true;
}

Terrain::Terrain(std::vector<motion::StaticBox> boxes,
                 float ground_height,
                 const std::vector<SurfaceSettings>& surfaces)
    : geometry_(std::move(boxes),
                ground_height,
                motion::kStaticCell_m,
                in_world_coordinates(surfaces)) {
}

float Terrain::height(float x, float z) const {
    const Aabb line{Vec3(x, -kEverywhere_m, z), Vec3(x, kEverywhere_m, z)};
    float best = geometry_.floor_at(x, z);
    geometry_.for_each_near(line, [&](std::uint32_t index) {
        float top = 0.0F;
        if (top_of_box(geometry_.boxes()[index], x, z, top)) {
            best = std::max(best, top);
        }
    });
    return best;
}

bool Terrain::on_surface(float x, float z) const {
    return !geometry_.surfaces().empty() && geometry_.floor_at(x, z) >= height(x, z) &&
           geometry_.floor_at(x, z) > geometry_.ground_height();
}

float Terrain::highest(float x, float z, float radius) const {
    float best = height(x, z);
    for (const auto& spoke : kSpoke) {
        best = std::max(best, height(x + radius * spoke[0], z + radius * spoke[1]));
    }
    return best;
}

bool Terrain::level(float x, float z, float radius, float rise) const {
    const float centre = height(x, z);
    for (const auto& spoke : kSpoke) {
        const float there = height(x + radius * spoke[0], z + radius * spoke[1]);
        if (std::abs(there - centre) > kLevel_m + rise) {
            return false;
        }
    }
    return true;
}

bool Terrain::clear(const Aabb& area) const {
    if (area.lower.y() < geometry_.ground_height()) {
        return false;
    }
    bool free = true;
    geometry_.for_each_near(area, [&](std::uint32_t index) {
        free = free && !boxes_overlap(area, geometry_.boxes()[index]);
    });
    for (const motion::PlacedSurface& placed : geometry_.surfaces()) {
        free = free && surface_clear(area, placed);
    }
    return free;
}

}  // namespace zoned::config
