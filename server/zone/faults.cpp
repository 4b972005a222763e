#include "server/zone/faults.h"

#include <algorithm>

namespace zoned::zone {

namespace {

bool chosen(EntityId entity) {
    return entity.value % 16 == 1;
}

void hide_from(world::VisibleSet& set) {
    const auto is_chosen = [](const world::Visible& v) {
        return chosen(v.entity);
    };
    std::erase_if(set.visible, is_chosen);
    std::erase_if(set.entered, is_chosen);
    std::erase_if(set.lod_changed, is_chosen);
    std::erase_if(set.left, [](EntityId id) { return chosen(id); });
}

bool listed(const world::VisibleSet& set, EntityId entity) {
    return std::any_of(set.visible.begin(), set.visible.end(), [&](const world::Visible& v) {
        return v.entity == entity;
    });
}

/// The owned entity farthest from the viewer.
EntityId farthest(const ZoneState& state, const Vec3& from) {
    const world::Entities& e = state.entities;
    EntityId best;
    float best_d2 = -1.0F;
    for (world::Row row = 0; row < e.size(); ++row) {
        const float d2 = (e.position[row] - from).squaredNorm();
        if (!e.has(row, world::kHidden) && !e.client[row] && d2 > best_d2) {
            best_d2 = d2;
            best = e.id[row];
        }
    }
    return best;
}

}  // namespace

bool stalled(const ZoneState& state) {
    const FaultSettings& f = state.settings.faults;
    return f.stall_ticks > 0 && state.now >= f.stall_from &&
           state.now < f.stall_from + f.stall_ticks;
}

void corrupt_visibility(ZoneState& state) {
    const FaultSettings& f = state.settings.faults;
    if (!f.hide_entity && !f.leak_entity) {
        return;
    }
    state.replicated = state.visibility;
    for (std::size_t i = 0; i < state.replicated.size(); ++i) {
        world::VisibleSet& set = state.replicated[i];
        if (f.hide_entity) {
            hide_from(set);
        }
        const world::Row avatar = state.entities.find(state.viewers[i].avatar);
        if (!f.leak_entity || avatar == world::kNoRow) {
            continue;
        }
        const EntityId far = farthest(state, state.entities.position[avatar]);
        if (far && !listed(set, far)) {
            const auto at = std::lower_bound(
                set.visible.begin(),
                set.visible.end(),
                far,
                [](const world::Visible& v, EntityId id) { return v.entity < id; });
            const auto lod = static_cast<std::uint8_t>(state.settings.replication.lods.size() - 1);
            set.visible.insert(at, {far, lod});
            set.entered.push_back({far, lod});
        }
    }
}

void corrupt_positions(ZoneState& state, float sign) {
    const float offset = state.settings.faults.corrupt_position_m;
    if (offset == 0.0F) {
        return;
    }
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        if (chosen(state.entities.id[row])) {
            state.entities.position[row].x() += sign * offset;
        }
    }
}

}  // namespace zoned::zone
