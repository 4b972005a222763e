// PointsOfInterest of a config and what is traded there, in the form in which agents have them, and
// what is wrong with them.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/npc/choices.h"
#include "server/config/text/diagnostics.h"
#include "server/config/world/spline_config.h"
#include "proto/config.pb.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace zoned::config {

ai::PoiSettings expand_points_of_interest(const proto::Config& config);

/// Index of the place of that name, -1: none.
int find_point_of_interest(const proto::Config& config, const std::string& name);

/// What "PLACE.distance" or "PLACE.GOOD" means; none where there is no such place or stock.
std::optional<ai::PointOfInterestSense> find_poi_sense(const proto::Config& config,
                                                       const std::string& sense);

/// Names that mean nothing become the first place and variable.
ai::Trade expand_trade(const proto::Config& config,
                       const proto::Config::Trade& trade,
                       const VariableOf& variable_of);

ai::ForageDef expand_forage(const proto::Config& config, const proto::Config::Forage& forage);

ai::FormationDef expand_formation(const proto::Config::Formation& formation);

/// What a state or action says of places, formations and food, but where it does not go.
template <class ActionSpec>
void expand_action_details(const proto::Config& config,
                           const ActionSpec& action,
                           const VariableOf& variable_of,
                           ai::BrainState& out) {
    if (action.action() == proto::Config::GO) {
        out.place = static_cast<std::uint16_t>(
            std::max(find_point_of_interest(config, action.point_of_interest()), 0));
    }
    if (action.action() == proto::Config::FORM_UP) {
        out.formation = expand_formation(action.formation());
    }
    if (action.action() == proto::Config::FORAGE) {
        out.forage = expand_forage(config, action.forage());
    }
    if (action.action() == proto::Config::FOLLOW_TRACK) {
        out.follow = expand_follow(config, action.follow());
    }
    for (const std::string& place : action.along()) {
        out.along.push_back(
            static_cast<std::uint16_t>(std::max(find_point_of_interest(config, place), 0)));
    }
    for (const auto& trade : action.trade()) {
        out.trades.push_back(expand_trade(config, trade, variable_of));
    }
}

/// PointsOfInterest by themselves: names, stock, that they lie in the world, and those with stock
/// in one zone.
void check_points_of_interest(const proto::Config& config,
                              const std::vector<ZoneRegion>& zones,
                              Diagnostics& diagnostics);

/// What a state or action at `path` says of places: that those it names exist, that whoever goes
/// somewhere says where, and that goods are variables of brain `root`.
template <class ActionSpec>
void check_action_details(const proto::Config& config,
                          int root,
                          const ActionSpec& action,
                          const std::string& path,
                          Diagnostics& diagnostics);

}  // namespace zoned::config
