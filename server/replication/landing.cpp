#include "server/replication/landing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::replication {

namespace {

constexpr int kSteps = 48;
constexpr float kStep_s = 1.0F / 16.0F;
constexpr float kNone = -std::numeric_limits<float>::infinity();

/// Height at which a vertical line through `p` leaves a box upwards; minus infinity beside it.
float top_of(const motion::StaticBox& box, const Mat3& axes, const Vec3& p) {
    const Vec3 local = axes.transpose() * (p - box.centre);
    const Vec3 up = axes.transpose() * Vec3::UnitY();
    float enter = kNone;
    float leave = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 3; ++i) {
        if (std::abs(up[i]) < 1e-6F) {
            if (std::abs(local[i]) > box.half_extents[i]) {
                return kNone;
            }
            continue;
        }
        const float a = (-box.half_extents[i] - local[i]) / up[i];
        const float b = (box.half_extents[i] - local[i]) / up[i];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? p.y() + leave : kNone;
}

/// The topmost solid at (p.x, p.z) whose top is not above `highest`.
float floor_under(const motion::StaticGeometry& ground, const Vec3& p, float highest) {
    const float level = ground.floor_at(p.x(), p.z());
    float best = level <= highest ? level : ground.ground_height();
    Aabb column;
    column.lower = Vec3(p.x(), best, p.z());
    column.upper = Vec3(p.x(), std::max(best, highest), p.z());
    ground.for_each_near(column, [&](std::uint32_t i) {
        const float top = top_of(ground.boxes()[i], ground.box_axes(i), p);
        if (top <= highest) {
            best = std::max(best, top);
        }
    });
    return best;
}

}  // namespace

float resting_height(const world::EntityType& type, const Quat& orientation) {
    switch (type.shape) {
        case world::TypeShape::kSphere:
            return type.radius;
        case world::TypeShape::kCapsule:
            return type.radius + type.half_segment * std::abs((orientation * Vec3::UnitY()).y());
        case world::TypeShape::kBox:
        case world::TypeShape::kSolid:
        case world::TypeShape::kSoft:
            break;
    }
    const bool box = type.shape == world::TypeShape::kBox;
    const Vec3 lower = box ? Vec3(-type.half_extents) : type.standing.lower;
    const Vec3 upper = box ? type.half_extents : type.standing.upper;
    // The axis that is most nearly vertical, and which of its ends is below.
    const Vec3 up = orientation.conjugate() * Vec3::UnitY();
    int axis = 0;
    up.cwiseAbs().maxCoeff(&axis);
    return up[axis] > 0.0F ? -lower[axis] : upper[axis];
}

float landing_height(const motion::StaticGeometry& ground,
                     const motion::KinematicState& from,
                     float height) {
    // An entity a little inside the floor (a contact, a step of quantisation) is still above it.
    constexpr float kInto_m = 0.05F;
    Vec3 before = from.position;
    for (int k = 1; k <= kSteps; ++k) {
        const float t = static_cast<float>(k) * kStep_s;
        const Vec3 p = from.position + (from.velocity + from.acceleration * (0.5F * t)) * t;
        if (p.y() < before.y()) {
            const float floor = floor_under(ground, p, before.y() - height + kInto_m);
            if (p.y() - height <= floor) {
                return floor + height;
            }
        }
        before = p;
    }
    return kNone;
}

}  // namespace zoned::replication
