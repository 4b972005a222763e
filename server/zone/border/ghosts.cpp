#include "server/zone/border/ghosts.h"

#include "server/zone/simulation/spawning.h"
#include "shared/math/turn_rate.h"

#include <algorithm>

namespace zoned::zone {

namespace {

/// Ghosts this close to the own region get a kinematic body: something of ours may touch them.
constexpr double kContactMargin = 6.0;

bool reaches_another_zone(const ZoneState& state, const Vec3d& at) {
    for (const Region& region : state.settings.regions) {
        if (region.id != state.settings.id &&
            region.outside(at.x(), at.z()) <= state.settings.ghost_margin_m) {
            return true;
        }
    }
    return false;
}

bool same(const EntityState& a, const world::Entities& e, world::Row row, const Vec3& shift) {
    const auto fields = e.fields().block(row, e.type[row]);
    return a.position + shift == e.position[row] && a.velocity == e.velocity[row] &&
           a.orientation.coeffs() == e.orientation[row].coeffs() &&
           a.angular_velocity == e.angular_velocity[row] && a.acceleration == e.acceleration[row] &&
           a.appearance == e.appearance[row] && a.stance == e.stance[row] &&
           ((a.flags & ~world::kDozing) | world::kGhost) == e.flags[row] &&
           a.discontinuity_tick == e.discontinuity_tick[row] &&
           std::equal(a.fields.begin(), a.fields.end(), fields.begin(), fields.end());
}

/// A body this far off its owner's truth is put there at once; less is made up within the next
/// step, m.
constexpr float kTeleport = 1.0F;
constexpr float kStill = 1e-4F;

/// Gives the kinematic body the velocity that leads it, within the next step, to where its owner's
/// entity will then be. True when it is there and stays.
bool lead_body(ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const float dt = state.settings.dt;
    const physics::BodyState body = state.scene.state(e.body[row]);
    const Vec3 error = e.position[row] - body.position;
    if (error.squaredNorm() > kTeleport * kTeleport) {
        state.scene.set_state(
            e.body[row],
            {e.position[row], e.orientation[row], e.velocity[row], e.angular_velocity[row], false});
        return false;
    }
    const Vec3 turn = turn_rate(body.orientation, e.orientation[row], dt);
    const bool still = e.has(row, world::kAtRest) && error.squaredNorm() < kStill * kStill &&
                       turn.squaredNorm() * dt * dt < kStill * kStill;
    state.scene.set_velocity(e.body[row],
                             still ? Vec3(Vec3::Zero()) : Vec3(e.velocity[row] + error / dt),
                             still ? Vec3(Vec3::Zero()) : Vec3(e.angular_velocity[row] + turn));
    return still;
}

/// Ghosts near the border are solid: they follow their owner's motion as kinematic bodies. True
/// when the body, if there is one, is there and stays.
bool update_body(ZoneState& state, world::Row row, double outside_m) {
    const world::Entities& e = state.entities;
    const bool wanted = outside_m <= kContactMargin && !e.has(row, world::kHidden);
    if (!wanted) {
        remove_body(state, row);
        return true;
    }
    if (e.body[row]) {
        return lead_body(state, row);
    }
    add_body(state, row, false);
    return false;
}

/// What the entry of another zone's export is to this zone.
GhostArrival arrival_of(const ZoneState& state, const ZoneState& source, const EntityState& ghost) {
    const Region& region = state.settings.region();
    const Vec3d origin = source.settings.region().origin();
    const Vec3d at = origin + ghost.position.cast<double>();
    return {&ghost,
            source.settings.id,
            (origin - region.origin()).cast<float>(),
            region.outside(at.x(), at.z())};
}

void sort_arrivals(std::vector<GhostArrival>& arrivals) {
    std::sort(arrivals.begin(), arrivals.end(), [](const GhostArrival& a, const GhostArrival& b) {
        return a.state->id < b.state->id;
    });
}

void collect_arrivals(const ZoneState& state,
                      std::span<ZoneState* const> zones,
                      std::vector<GhostArrival>& arrivals) {
    arrivals.clear();
    for (const ZoneState* source : zones) {
        if (source == &state) {
            continue;
        }
        for (const EntityState& ghost : source->ghosts_out) {
            const GhostArrival arrival = arrival_of(state, *source, ghost);
            if (arrival.outside_m <= state.settings.ghost_margin_m) {
                arrivals.push_back(arrival);
            }
        }
    }
    sort_arrivals(arrivals);
}

/// Index into state.ghost_ids, or -1.
std::ptrdiff_t imported_place(const ZoneState& state, EntityId id) {
    const auto at = std::lower_bound(state.ghost_ids.begin(), state.ghost_ids.end(), id);
    return at != state.ghost_ids.end() && *at == id ? at - state.ghost_ids.begin() : -1;
}

/// The entries that are not as they were in the last import, and those whose bodies are not yet
/// where they belong. False where ghosts have come or gone: then all are looked at.
bool collect_changes(const ZoneState& state,
                     std::span<ZoneState* const> zones,
                     std::vector<GhostArrival>& out) {
    std::size_t led = 0;
    for (const ZoneState* source : zones) {
        if (source == &state) {
            continue;
        }
        if (source->ghosts_out_changed) {
            if (source->ghosts_out_anew) {
                return false;
            }
            for (const std::uint32_t place : source->ghosts_out_fresh) {
                const GhostArrival arrival = arrival_of(state, *source, source->ghosts_out[place]);
                const bool here = arrival.outside_m <= state.settings.ghost_margin_m;
                const std::ptrdiff_t at = imported_place(state, arrival.state->id);
                const bool known =
                    at >= 0 && state.ghost_owners[static_cast<std::size_t>(at)] == arrival.owner;
                if (here != known) {
                    return false;
                }
                if (here) {
                    out.push_back(arrival);
                }
            }
        }
        for (const LedGhost& ghost : state.led_ghosts) {
            if (ghost.owner == source->settings.id) {
                const auto& exported = source->ghosts_out;
                if (ghost.place >= exported.size() || exported[ghost.place].id != ghost.entity) {
                    return false;
                }
                out.push_back(arrival_of(state, *source, exported[ghost.place]));
                ++led;
            }
        }
    }
    if (led != state.led_ghosts.size()) {
        return false;
    }
    sort_arrivals(out);
    const auto same_entity = [](const GhostArrival& a, const GhostArrival& b) {
        return a.state == b.state;
    };
    out.erase(std::unique(out.begin(), out.end(), same_entity), out.end());
    return true;
}

void remove_missing(ZoneState& state, const std::vector<GhostArrival>& arrivals) {
    world::Entities& e = state.entities;
    for (const EntityId id : state.ghost_ids) {
        const auto it = std::lower_bound(
            arrivals.begin(), arrivals.end(), id, [](const GhostArrival& a, EntityId wanted) {
                return a.state->id < wanted;
            });
        if (it != arrivals.end() && it->state->id == id) {
            continue;
        }
        const world::Row row = e.find(id);
        // A ghost that was handed to this zone is an owned entity by now.
        if (row != world::kNoRow && e.has(row, world::kGhost)) {
            remove_body(state, row);
            e.remove(row);
            state.ghosts_moved = true;
        }
    }
}

/// Which rows neighbours hear of: only those can have changed that stir or were touched. True when
/// they are others than before; else `state.ghosts_out_fresh` lists the places in the export of
/// those that may have changed.
bool follow_border(ZoneState& state) {
    world::Entities& e = state.entities;
    const Vec3d origin = state.settings.region().origin();
    bool others = state.ghosts_out_rows.size() != state.near_border.count() ||
                  state.ghosts_out.size() != state.near_border.count();
    while (state.near_border.size() < e.size()) {
        state.near_border.push_back(false);
    }
    while (state.near_border.size() > e.size()) {
        const auto last = static_cast<world::Row>(state.near_border.size() - 1);
        others = others || state.near_border.has(last);
        state.near_border.move_last_into(last);
    }
    state.ghosts_out_fresh.clear();
    world::for_each_row(e.stirring(), e.touched(world::Reader::kExport), [&](world::Row row) {
        const bool exported = !e.has(row, world::kGhost) && !e.has(row, world::kHidden) &&
                              reaches_another_zone(state, origin + e.position[row].cast<double>());
        others = others || exported != state.near_border.has(row);
        state.near_border.put(row, exported);
        if (exported && !others) {
            const auto at =
                std::lower_bound(state.ghosts_out_rows.begin(), state.ghosts_out_rows.end(), row);
            state.ghosts_out_fresh.push_back(
                static_cast<std::uint32_t>(at - state.ghosts_out_rows.begin()));
        }
    });
    e.forget_touched(world::Reader::kExport);
    return others;
}

/// Makes the ghost like its entity. True when its body, if it has one, is there and stays.
bool follow_ghost(ZoneState& state, const GhostArrival& arrival) {
    world::Entities& e = state.entities;
    world::Row row = e.find(arrival.state->id);
    if (row == world::kNoRow) {
        row = e.add(arrival.state->id, arrival.state->type);
        e.set(row, world::kGhost, true);
    } else if (same(*arrival.state, e, row, arrival.shift)) {
        return !e.body[row] || lead_body(state, row);
    }
    write_entity(*arrival.state, arrival.shift, e, row);
    e.set(row, world::kGhost, true);
    e.set(row, world::kDozing, false);  // here its owner moves it
    state.ghosts_moved = true;
    return update_body(state, row, arrival.outside_m);
}

}  // namespace

void export_ghosts(ZoneState& state, bool something_changed) {
    state.ghosts_out_changed = something_changed;
    if (!something_changed) {
        return;
    }
    world::Entities& e = state.entities;
    state.ghosts_out_anew = follow_border(state);
    if (!state.ghosts_out_anew) {
        for (const std::uint32_t place : state.ghosts_out_fresh) {
            EntityState& exported = state.ghosts_out[place];
            const world::Row row = state.ghosts_out_rows[place];
            state.ghosts_out_anew = state.ghosts_out_anew || exported.id != e.id[row];
            exported = read_entity(e, row);
        }
        return;
    }
    state.ghosts_out.clear();
    state.ghosts_out_rows.clear();
    world::for_each_row(state.near_border, [&](world::Row row) {
        state.ghosts_out.push_back(read_entity(e, row));
        state.ghosts_out_rows.push_back(row);
    });
}

std::uint32_t import_ghosts(ZoneState& state, std::span<ZoneState* const> zones) {
    state.ghosts_moved = false;
    const bool changed = std::any_of(zones.begin(), zones.end(), [&](const ZoneState* z) {
        return z != &state && z->ghosts_out_changed;
    });
    if (!changed) {
        return static_cast<std::uint32_t>(state.ghost_ids.size());
    }
    std::vector<GhostArrival>& arrivals = state.ghost_arrivals;
    arrivals.clear();
    if (!collect_changes(state, zones, arrivals)) {
        collect_arrivals(state, zones, arrivals);
        remove_missing(state, arrivals);
        state.ghost_ids.clear();
        state.ghost_owners.clear();
        for (const GhostArrival& arrival : arrivals) {
            state.ghost_ids.push_back(arrival.state->id);
            state.ghost_owners.push_back(arrival.owner);
        }
    }
    state.led_ghosts.clear();
    for (const GhostArrival& arrival : arrivals) {
        if (!follow_ghost(state, arrival)) {
            const ZoneState& source = *zones[arrival.owner.value - 1U];
            state.led_ghosts.push_back(
                {arrival.state->id,
                 arrival.owner,
                 static_cast<std::uint32_t>(arrival.state - source.ghosts_out.data())});
        }
    }
    state.grid_valid = state.grid_valid && !state.ghosts_moved;
    return static_cast<std::uint32_t>(state.ghost_ids.size());
}

}  // namespace zoned::zone
