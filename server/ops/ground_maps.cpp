#include "server/ops/ground_maps.h"

#include "server/ai/navigation/ground_grid.h"
#include "server/ops/config_numbers.h"
#include "server/zone/zone_settings.h"

#include <string>

namespace zoned::ops {

void check_ground_maps(const proto::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics) {
    if (!config.ai().has_ways()) {
        return;
    }
    const float cell_m = narrow(config.ai().ways().cell_m());
    for (const ZoneRegion& zone : zones) {
        const std::string defect = ai::navigation::GroundGrid::defect_of(
            zone::ways_area(zone.max_x - zone.min_x,
                            zone.max_z - zone.min_z,
                            narrow(config.zones().handoff_hysteresis_m()),
                            cell_m),
            cell_m);
        if (!defect.empty()) {
            diagnostics.add("ai.ways.cell_m", "zone '" + zone.name + "': " + defect);
            return;
        }
    }
}

}  // namespace zoned::ops
