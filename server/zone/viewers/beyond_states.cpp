#include "server/zone/viewers/beyond_states.h"

#include <cmath>

namespace zoned::zone {

void mark_beyond_states(ZoneState& state) {
    world::Entities& e = state.entities;
    const wire::Quantization& q = state.settings.replication.quantization;
    const auto mark = [&](world::Row row) {
        const Vec3& p = e.position[row];
        const bool told = std::abs(p.x()) <= q.horizontal_extent_m &&
                          std::abs(p.y()) <= q.vertical_extent_m &&
                          std::abs(p.z()) <= q.horizontal_extent_m;
        e.set(row, world::kBeyond, !told);
    };
    world::for_each_row(e.moving(), e.touched(world::Reader::kInterest), mark);
}

}  // namespace zoned::zone
