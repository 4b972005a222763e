// Zone particles: makes particle systems from the settings, moves them, answers rules about them,
// and emits bursts that are simulated or sent to clients.
#pragma once

#include "server/zone/zone_state.h"

#include <string_view>

namespace zoned::zone {

/// Adds the systems that the settings give to this zone: those with an emitter in its region, and
/// those that rules may burst. They meet the ground plane and the first heightfield that is not
/// turned; boxes and meshes they do not meet.
void add_particle_systems(ZoneState& state);

/// Whether some system has particles or will have, in tick state.now.
bool particles_go_on(const ZoneState& state);

/// Births, deaths and motion of one tick. Returns the particles that there are then.
std::uint32_t step_particles(ZoneState& state);

/// `count` particles from `position` (zone-local, m) with about `velocity` (m/s), as the system's
/// burst settings say. Simulated: born in the next tick, if the particle pass runs then. Cosmetic:
/// put into the output for clients that hear the place, at most motion::kMostInCosmeticBurst of
/// them and as many events as the config allows; nothing else changes. False where the world has no
/// such system with a burst, the numbers are not finite, or there is nothing to emit or too much.
bool emit_particles(ZoneState& state,
                    std::string_view system,
                    const Vec3& position,
                    const Vec3& velocity,
                    std::uint32_t count);

/// Particles of a system within `radius` m of a point; 0 where this zone has no such system. Looks
/// at each particle of the system once.
std::uint32_t particles_near(const ZoneState& state,
                             std::string_view system,
                             const Vec3& point,
                             float radius);

}  // namespace zoned::zone
