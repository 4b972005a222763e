// World settings: turns the checked config into the settings of each zone.
#pragma once

#include "server/config/settings.h"
#include "server/zone/zone.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::app {

std::vector<zone::Region> regions_of(const config::Settings& settings);

/// Statics are cut to the zone's region and margin, in zone-local coordinates; the geometry of
/// surfaces is shared among zones. `doors`, `platforms`: of all zones; null where rules move none.
zone::ZoneSettings zone_settings(const config::Settings& settings,
                                 ZoneId id,
                                 const std::shared_ptr<const world::TypeTable>& types,
                                 const std::shared_ptr<const motion::DoorCourses>& doors,
                                 const std::shared_ptr<const motion::PlatformCourses>& platforms);

/// A zone whose maps cannot be baked, with the reason; or empty, as far as it can be told without
/// baking them.
std::string paths_defect(const config::Settings& settings);

/// Spawns the config's initial entities in the zones where they lie.
void populate(const config::Settings& settings,
              const std::vector<zone::Region>& regions,
              std::span<const std::unique_ptr<zone::Zone>> zones);

}  // namespace zoned::app
