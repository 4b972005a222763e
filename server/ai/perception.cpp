#include "server/ai/perception.h"

#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

bool is_player(const world::Entities& entities, world::Row row) {
    return static_cast<bool>(entities.client[row]) && !entities.has(row, world::kHidden);
}

}  // namespace

Sight look(const world::Entities& entities,
           const spatial::PointGrid& grid,
           world::Row self,
           float perception_m,
           float far_m) {
    Sight sight;
    const Vec3& eye = entities.position[self];
    float nearest2 = std::numeric_limits<float>::infinity();
    const auto consider = [&](world::Row row, float d2) {
        if (row == self || !is_player(entities, row)) {
            return;
        }
        const EntityId id = entities.id[row];
        if (d2 < nearest2 || (d2 == nearest2 && id < sight.prey)) {
            nearest2 = d2;
            sight.prey = id;
        }
    };
    grid.for_each_within(eye.x(), eye.z(), perception_m, consider);
    sight.distance = std::sqrt(nearest2);
    sight.player_far = sight.distance > far_m;
    if (!sight.prey && far_m > perception_m) {
        bool any = false;
        grid.for_each_within(eye.x(), eye.z(), far_m, [&](world::Row row, float /*d2*/) {
            any = any || (row != self && is_player(entities, row));
        });
        sight.player_far = !any;
    }
    return sight;
}

}  // namespace zoned::ai
