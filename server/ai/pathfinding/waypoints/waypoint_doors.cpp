#include "server/ai/pathfinding/waypoints/waypoint_doors.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// The part of a line in a box about the origin, as shares of it (Ericson, Real-Time Collision
/// Detection, 5.3.3).
bool meets_box(const Vec3& from, const Vec3& to, const Vec3& low, const Vec3& high) {
    float begin = 0.0F;
    float end = 1.0F;
    for (int axis = 0; axis < 3; ++axis) {
        const float path = to[axis] - from[axis];
        if (std::abs(path) < 1e-9F) {
            if (from[axis] < low[axis] || from[axis] > high[axis]) {
                return false;
            }
            continue;
        }
        const float a = (low[axis] - from[axis]) / path;
        const float b = (high[axis] - from[axis]) / path;
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return begin <= end;
}

/// A door as a line of feet meets it.
class DoorBody {
  public:
    DoorBody(const motion::StaticGeometry& world,
             std::uint32_t door,
             const motion::CharacterLimits& limits)
        : axes_(world.box_axes(static_cast<std::uint32_t>(world.boxes().size()) + door)),
          box_(world.box(static_cast<std::uint32_t>(world.boxes().size()) + door)) {
        const float tall = 2.0F * (limits.radius + limits.half_segment);
        const Vec3 half = box_.half_extents;
        // Along the box's own axes: where the body's axis may not be, and where feet are carried.
        // The body is a cylinder here, so that doors that lean are taken to be a little larger.
        const Vec3 wide(limits.radius, 0.0F, limits.radius);
        low_ = -half - wide - Vec3(0.0F, tall, 0.0F);
        high_ = half + wide;
        high_.y() = half.y() - limits.step_up;
        carried_low_ = Vec3(-half.x(), half.y() - limits.step_up, -half.z());
        carried_high_ = Vec3(half.x(), half.y() + limits.step_down, half.z());
    }

    [[nodiscard]] bool stops(const Vec3& from, const Vec3& to) const {
        return meets_box(local(from), local(to), low_, high_);
    }

    [[nodiscard]] bool carries(const Vec3& from, const Vec3& to) const {
        return meets_box(local(from), local(to), carried_low_, carried_high_);
    }

  private:
    [[nodiscard]] Vec3 local(const Vec3& p) const { return axes_.transpose() * (p - box_.centre); }

    Mat3 axes_;
    motion::StaticBox box_;
    Vec3 low_;
    Vec3 high_;
    Vec3 carried_low_;
    Vec3 carried_high_;
};

}  // namespace

std::vector<WaypointDoor> waypoint_doors(const WaypointGraph& graph,
                                         const motion::StaticGeometry& world,
                                         const motion::CharacterLimits& limits) {
    std::vector<WaypointDoor> doors(world.doors().size());
    for (std::uint32_t d = 0; d < doors.size(); ++d) {
        const DoorBody body(world, d, limits);
        const auto note = [&](std::uint32_t what, const Vec3& from, const Vec3& to) {
            if (body.carries(from, to)) {
                doors[d].given.push_back(what);
            } else if (body.stops(from, to)) {
                doors[d].taken.push_back(what);
            }
        };
        for (std::uint32_t n = 0; n < graph.size(); ++n) {
            note(n, graph.position(n), graph.position(n));
        }
        for (std::uint32_t n = 0; n < graph.size(); ++n) {
            for (std::uint32_t e = graph.first_edge(n); e < graph.first_edge(n + 1); ++e) {
                note(graph.size() + e, graph.position(n), graph.position(graph.edge(e).to));
            }
        }
    }
    return doors;
}

}  // namespace zoned::ai::pathfinding
