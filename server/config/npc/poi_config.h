// PointsOfInterest of a config and what is traded there, in the form in which agents have them, and
// what is wrong with them.
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

/// What "PLACE.distance" or "PLACE.GOOD" means; none where there is no such place or stock.
std::optional<ai::PointOfInterestSense> find_poi_sense(const proto::config::Config& config,
                                                       const std::string& sense);

/// Names that mean nothing become the first place and variable.
ai::Trade expand_trade(const proto::config::Config& config,
                       const proto::config::Trade& trade,
                       const VariableOf& variable_of);

ai::ForageDef expand_forage(const proto::config::Config& config,
                            const proto::config::Forage& forage);

ai::FormationDef expand_formation(const proto::config::Formation& formation);

/// What a state or action says of places, formations and food, but where it does not go.
template <class ActionSpec>
void expand_action_details(const proto::config::Config& config,
                           const ActionSpec& action,
                           const VariableOf& variable_of,
                           ai::BrainState& out);

/// PointsOfInterest by themselves: names, stock, that they lie in the world, and those with stock
/// in one zone.
void check_points_of_interest(const proto::config::Config& config,
                              const std::vector<ZoneRegion>& zones,
                              Diagnostics& diagnostics);

/// What a state or action at `path` says of places: that those it names exist, that whoever goes
/// somewhere says where, and that goods are variables of brain `root`.
template <class ActionSpec>
void check_action_details(const proto::config::Config& config,
                          int root,
                          const ActionSpec& action,
                          const std::string& path,
                          Diagnostics& diagnostics);

}  // namespace zoned::config
