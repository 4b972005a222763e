// Zone doors: shut doors are solid for bodies and rays, and push out characters that stand in them.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// Puts the bodies of those that are shut at the first tick there.
void add_doors(ZoneState& state);

/// Doors that stand other than they do at `state.now`.
std::uint32_t doors_to_turn(const ZoneState& state);

/// Shuts and opens them. A body that sleeps or rests against one wakes. Returns how many.
std::uint32_t turn_doors(ZoneState& state);

/// Whether a ray hits a box nearer than `hit.distance`: then distance, point and normal are in
/// `hit`. `direction` has unit length.
bool ray_to_box(const motion::StaticBox& box,
                const Vec3& origin,
                const Vec3& direction,
                RayResult& hit);

/// The nearest door that was shut at a tick on a ray, within `hit.distance`: true where there is
/// one, with distance, point and normal in `hit`. `direction` has unit length.
bool ray_to_door(const ZoneState& state,
                 Tick tick,
                 const Vec3& origin,
                 const Vec3& direction,
                 RayResult& hit);

}  // namespace zoned::zone
