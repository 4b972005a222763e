// stances: the stances that choose an entity's radii: four of every world, and the named ones of a
// config.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
class Radii;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Index of the column of radii that hold in the stance (world::EntityType::aura_m); -1 where the
/// config has none of that name.
int find_stance(const proto::config::Config& config, const std::string& name);

/// Largest radius over all stances, m.
double largest_radius(const proto::config::Radii& radii);

/// Names of stances are unique, and radii and agents name no others.
void check_stances(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
