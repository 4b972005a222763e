// poi_config: reads and checks the points of interest of a config and their trade for agents.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/text/diagnostics.h"
#include "server/config/world/spline_config.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
class Forage;
class Formation;
class Trade;
}  // namespace zoned::proto::config

namespace zoned::config {

struct ZoneRegion;

ai::PoiSettings expand_points_of_interest(const proto::config::Config& config);

/// The sense of "PLACE.distance" or "PLACE.GOOD"; none without such a place or stock.
std::optional<ai::PointOfInterestSense> find_poi_sense(const proto::config::Config& config,
                                                       const std::string& sense);

/// Unknown names become the first place and variable.
ai::Trade expand_trade(const proto::config::Config& config,
                       const proto::config::Trade& trade,
                       const VariableOf& variable_of);

ai::ForageDef expand_forage(const proto::config::Config& config,
                            const proto::config::Forage& forage);

ai::FormationDef expand_formation(const proto::config::Formation& formation);

/// A state's or action's settings of places, formations and food.
template <class ActionSpec>
void expand_action_details(const proto::config::Config& config,
                           const ActionSpec& action,
                           const VariableOf& variable_of,
                           ai::BrainState& out);

/// Checks points of interest by themselves: names, stock, a position in the world, and in one zone
/// where they have stock.
void check_points_of_interest(const proto::config::Config& config,
                              const std::vector<ZoneRegion>& zones,
                              Diagnostics& diagnostics);

/// Checks the places of a state or action at `path`: its places exist, an action that goes
/// somewhere names its place, and goods are variables of brain `root`.
template <class ActionSpec>
void check_action_details(const proto::config::Config& config,
                          int root,
                          const ActionSpec& action,
                          const std::string& path,
                          Diagnostics& diagnostics);

}  // namespace zoned::config
