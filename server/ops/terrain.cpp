#include "server/ops/terrain.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ops {

namespace {

constexpr float kEverywhere_m = 1e6F;
constexpr float kLevel_m = 0.01F;

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

Terrain::Terrain(std::vector<motion::StaticBox> boxes, float ground_height)
    : geometry_(std::move(boxes), ground_height, 16.0F) {
}

float Terrain::height(float x, float z) const {
    float best = geometry_.ground_height();
    const Aabb line{Vec3(x, -kEverywhere_m, z), Vec3(x, kEverywhere_m, z)};
    geometry_.for_each_near(line, [&](std::uint32_t index) {
        float top = 0.0F;
        if (top_of_box(geometry_.boxes()[index], x, z, top)) {
            best = std::max(best, top);
        }
    });
    return best;
}

bool Terrain::level(float x, float z, float radius) const {
    static constexpr int kSpokes = 8;
    const float centre = height(x, z);
    // sqrt(1/2) by hand: the same bits from every mathematics library.
    static constexpr float kD = 0.70710678F;
    static constexpr float kSpoke[kSpokes][2] = {
        {1, 0}, {kD, kD}, {0, 1}, {-kD, kD}, {-1, 0}, {-kD, -kD}, {0, -1}, {kD, -kD}};
    for (const auto& spoke : kSpoke) {
        if (std::abs(height(x + radius * spoke[0], z + radius * spoke[1]) - centre) > kLevel_m) {
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
    return free;
}

}  // namespace zoned::ops
