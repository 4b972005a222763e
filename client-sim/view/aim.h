// Aim: what a view displays along a ray, to be told to the server with a shot.
#pragma once

#include "client-sim/view/view.h"

#include <vector>

namespace zoned::view {

/// A character as it is on the screen.
struct AimSight {
    EntityId entity;
    Vec3d position = Vec3d::Zero();  ///< world coordinates, m
    Tick publication = 0;            ///< that it is predicted from, in a view of the present
};

struct Aim {
    bool past = false;      ///< an interpolating view
    Tick tick = 0;          ///< displayed of others
    double fraction = 0.0;  ///< of the tick after it, [0, 1)
    EntityId hit;           ///< the first character along the ray; none: nobody
    double distance = 0.0;  ///< to it, m
    std::vector<AimSight> near;
};

/// Those nearer to the ray than this count as near, m from their surface, the nearest kMostSights
/// of them.
inline constexpr double kNearRayM = 1.5;
inline constexpr std::size_t kMostSights = 8;

/// Characters along the ray as displayed now, without the own avatar. `direction` is a unit vector;
/// of the static world only the flat ground is looked at.
[[nodiscard]] Aim aim(const View& view, const Vec3d& eye, const Vec3d& direction, double range_m);

/// Where the own avatar looks from after its newest command, as the server's rules have it: half a
/// radius above the centre of its head's sphere.
[[nodiscard]] Vec3d own_eye(const View& view);

/// How far along the ray it meets an upright capsule about `centre`; below 0: not at all. 0 where
/// it begins inside.
[[nodiscard]] double ray_capsule(const Vec3d& eye,
                                 const Vec3d& direction,
                                 const Vec3d& centre,
                                 double radius,
                                 double half_segment);

}  // namespace zoned::view
