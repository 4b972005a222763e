// Visibility filter: hides entities from viewers that must not know of them although the radii
// reach.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Whether a viewer's avatar may know of an entity of a type that conceals itself, by the state of
/// this moment. The rules may decide it. Else it is the line of sight from the avatar's eyes (nine
/// tenths of the height from centre to top) to the entity's centre or top, past statics and bodies.
[[nodiscard]] bool may_know(const ZoneState& state,
                            const RulesContext& context,
                            world::Row viewer,
                            world::Row entity);

/// Whether nothing stands between the avatar's eyes and a place (zone-local). Solids within a tenth
/// of a metre of the place do not count.
[[nodiscard]] bool sees_place(const ZoneState& state, world::Row viewer, const Vec3& place);

/// Writes state.visibility: the matcher's sets without the concealed entities. Pairs are tested at
/// once when they come within the radii, and again before their answer is stale. The longest
/// untested come first, and no more than the budget. Without a valid answer an entity is not known.
/// Once known it stays so for the grace. Returns how many pairs it tested. No allocation after
/// warm-up.
std::uint32_t filter_visibility(ZoneState& state, const RulesContext& context);

/// By the tested pair: nullptr where the pair was not tested.
[[nodiscard]] const FilteredPair* find_filtered_pair(const ZoneState& state,
                                                     ClientId client,
                                                     EntityId entity);

}  // namespace zoned::zone
