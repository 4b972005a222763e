// Aim: the characters that a view displays along a ray, to be sent to the server with a shot.
#pragma once

#include "client-sim/view/view.h"

#include <vector>

namespace zoned::view {

/// A character as it is on the screen.
struct AimSight {
    EntityId entity;
    Vec3d position = Vec3d::Zero();  ///< world coordinates, m
    Tick publication = 0;  ///< publication from which it is predicted, in a view of the present
};

struct Aim {
    bool past = false;      ///< an interpolating view
    Tick tick = 0;          ///< tick at which others are displayed
    double fraction = 0.0;  ///< of the tick after it, [0, 1)
    EntityId hit;           ///< the first character along the ray; none: no hit
    double distance = 0.0;  ///< to it, m
    std::vector<AimSight> near;
};

/// Characters count as near within this distance of the ray, m from their surface; at most the
/// nearest kMostSights.
inline constexpr double kNearRayM = 1.5;
inline constexpr std::size_t kMostSights = 8;

/// Characters along the ray as displayed now, without the own avatar. `direction` is a unit vector;
/// only the flat ground of the static world is considered.
[[nodiscard]] Aim aim(const View& view, const Vec3d& eye, const Vec3d& direction, double range_m);

/// Height of a character's eyes above its centre, as in the server's rules: half a radius above the
/// centre of its head's sphere, m.
[[nodiscard]] double eye_height(const motion::CharacterLimits& body);

/// The eyes of the own avatar after its newest command.
[[nodiscard]] Vec3d own_eye(const View& view);

/// Distance along the ray to an upright capsule about `centre`; below 0: no hit; 0: the ray begins
/// inside.
[[nodiscard]] double ray_capsule(const Vec3d& eye,
                                 const Vec3d& direction,
                                 const Vec3d& centre,
                                 double radius,
                                 double half_segment);

}  // namespace zoned::view
