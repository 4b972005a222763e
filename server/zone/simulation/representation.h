// Representation: simulates entities far from all players at a lower level of detail.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// The simulated form of a prop; the higher, the cheaper. A column of the entities.
enum class Representation : std::uint8_t {
    kFull,
    kSingle,    ///< a compound as one hull around its parts, a soft body as its rigid hull
    kParticle,  ///< a point with its mass
};

/// Looks at the props whose types allow it, every kRepresentationTicks. Props far from all players
/// (ghosts of players count) that touch nothing that moves go to a lower level. Props go up again
/// when a player comes near or something may touch them. Returns how many changed.
std::uint32_t choose_representations(ZoneState& state);

inline constexpr Tick kRepresentationTicks = 8;

}  // namespace zoned::zone
