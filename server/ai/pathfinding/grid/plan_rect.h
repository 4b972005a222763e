// PlanRect: the rectangle on the ground within which a static box lies.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/motion/static_geometry.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::pathfinding {

/// It is turned as the box is: exact for a box that is turned about y and pitched at most.
class PlanRect {
  public:
    PlanRect(const motion::StaticGeometry& world, std::uint32_t index) {
        const motion::StaticBox& box = world.box(index);
        const Mat3& axes = world.box_axes(index);
        centre_ = {box.centre.x(), box.centre.z()};
        int level = 0;
        for (int axis = 1; axis < 3; ++axis) {
            level = std::abs(axes(1, axis)) < std::abs(axes(1, level)) ? axis : level;
        }
        const float flat = length(axes(0, level), axes(2, level));
        x_ = axes(0, level) / flat;
        z_ = axes(2, level) / flat;
        for (int axis = 0; axis < 3; ++axis) {
            const float half = box.half_extents[axis];
            along_ += half * std::abs(x_ * axes(0, axis) + z_ * axes(2, axis));
            across_ += half * std::abs(x_ * axes(2, axis) - z_ * axes(0, axis));
        }
    }

    /// Distance of a place from it, m.
    [[nodiscard]] float distance(Spot at) const {
        const Spot a = local(at);
        return length(std::max(std::abs(a.x) - along_, 0.0F),
                      std::max(std::abs(a.z) - across_, 0.0F));
    }

    /// How deep a place lies in it, m; negative beside it.
    [[nodiscard]] float depth(Spot at) const {
        const Spot a = local(at);
        return std::min(along_ - std::abs(a.x), across_ - std::abs(a.z));
    }

    /// A lower bound on its distance from a line, m; exact but near its corners. The largest gap
    /// along its axes, and along the normal of the line. Source: Ericson, Real-Time Collision
    /// Detection, 5.2.1.
    [[nodiscard]] float least_distance(Spot begin, Spot end) const {
        const Spot a = local(begin);
        const Spot b = local(end);
        const float along = std::max(std::min(a.x, b.x), -std::max(a.x, b.x)) - along_;
        const float across = std::max(std::min(a.z, b.z), -std::max(a.z, b.z)) - across_;
        const float beside = length(std::max(along, 0.0F), std::max(across, 0.0F));
        const Spot line{b.x - a.x, b.z - a.z};
        const float whole = length(line.x, line.z);
        if (whole == 0.0F) {
            return beside;
        }
        const float off = std::abs(a.x * line.z - a.z * line.x) - along_ * std::abs(line.z) -
                          across_ * std::abs(line.x);
        return std::max(beside, off / whole);
    }

  private:
    static float length(float x, float z) { return std::sqrt(x * x + z * z); }

    [[nodiscard]] Spot local(Spot at) const {
        const Spot off{at.x - centre_.x, at.z - centre_.z};
        return {off.x * x_ + off.z * z_, off.z * x_ - off.x * z_};
    }

    Spot centre_;
    float x_;  ///< of the axis along it, a unit vector
    float z_;
    float along_ = 0.0F;  ///< half its size, m
    float across_ = 0.0F;
};

}  // namespace zoned::ai::pathfinding
