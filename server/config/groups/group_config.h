// group_config: expands what the config says about groups of players.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/zone/groups/match.h"
#include "server/zone/groups/party.h"

#include <optional>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// None: the world has no parties.
std::optional<zone::PartySettings> expand_parties(const proto::config::Config& config);

/// None: the world has no matches. Mistakes (doubled names, instances that there are not, more who
/// are enough than a team holds) go to `diagnostics`.
std::optional<zone::MatchSettings> expand_matches(const proto::config::Config& config,
                                                  Diagnostics& diagnostics);

}  // namespace zoned::config
