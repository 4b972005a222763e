#include "server/zone/viewers/fault_injection.h"

#include <algorithm>

namespace zoned::zone {

namespace {

void hide_from(const ZoneState& state, world::VisibleSet& set) {
    const auto hidden = [&](EntityId id) {
        return state.settings.faults.hide.hits(id.value, state.now);
    };
    const auto is_hidden = [&](const world::Visible& v) {
        return hidden(v.entity);
    };
    std::erase_if(set.visible, is_hidden);
    std::erase_if(set.entered, is_hidden);
    std::erase_if(set.lod_changed, is_hidden);
    std::erase_if(set.left, hidden);
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
    state.replicated = state.visibility;
    for (std::size_t i = 0; i < state.replicated.size(); ++i) {
        world::VisibleSet& set = state.replicated[i];
        hide_from(state, set);
        set.changed = true;
        const world::Row avatar = state.entities.find(state.viewers[i].avatar);
        if (!f.leak.hits(set.client.value, state.now) || avatar == world::kNoRow) {
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
    const FaultSettings& f = state.settings.faults;
    if (f.corrupt.share == 0.0) {
        return;
    }
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        if (f.corrupt.hits(state.entities.id[row].value, state.now)) {
            state.entities.position[row].x() += sign * f.corrupt_offset_m;
        }
    }
}

}  // namespace zoned::zone
