// Lag compensation: rays through the world as a client saw it when it acted.
//
// Rewinding as in Bernier, "Latency Compensating Methods in Client/Server In-game Protocol Design
// and Optimization" (GDC 2001), section "Lag Compensation", with one difference. There the server
// guesses the displayed state from the round trip and the interpolation delay. Here the client
// reports the state that it displayed. The server believes the report as far as the updates sent to
// the client explain it. So a prediction, and the blending after it, are judged as they were seen.
// A lie gains no more than `slack_m` and the jump of a blend.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// Records this tick. An entity counts if it is of a rewindable type, not hidden, and either
/// somebody's avatar or in a visible set; ghosts too. Returns how many entities.
std::uint32_t record_history(ZoneState& state);

/// The ray through the world as the client says it saw it. An entity named among Seen::entities
/// stands where it was displayed, as far as that is explained. For a view of the present, the
/// explanation is the prediction from the publication that the client names. That publication must
/// have been sent to this client and have been the newest within RewindSettings::most_ticks. For a
/// view of the past, it is the entity's place at that tick. Other rewindable entities stand where
/// they were then, and doors and platforms as they did; all else is where it is now. Nothing is hit
/// that has appeared, respawned or jumped since, or is hidden now.
SeenHit ray_cast_as_seen(const ZoneState& state,
                         ClientId client,
                         const Seen& seen,
                         const Vec3& origin,
                         const Vec3& direction,
                         float max_distance,
                         EntityId ignore);

}  // namespace zoned::zone
