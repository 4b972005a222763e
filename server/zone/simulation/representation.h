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

/// Looks at the props whose types allow it, every kRepresentationTicks: steps those down that are
/// far from all players (ghosts of players count) and touch nothing that moves, and those up again
/// to which one comes or which something may touch. Returns how many changed.
std::uint32_t choose_representations(ZoneState& state);

inline constexpr Tick kRepresentationTicks = 8;

}  // namespace zoned::zone
