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
/// entity will then be.
void lead_body(ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const float dt = state.settings.dt;
    const physics::BodyState body = state.scene.state(e.body[row]);
    const Vec3 error = e.position[row] - body.position;
    if (error.squaredNorm() > kTeleport * kTeleport) {
        state.scene.set_state(
            e.body[row],
            {e.position[row], e.orientation[row], e.velocity[row], e.angular_velocity[row], false});
        return;
    }
    const Vec3 turn = turn_rate(body.orientation, e.orientation[row], dt);
    const bool still = e.has(row, world::kAtRest) && error.squaredNorm() < kStill * kStill &&
                       turn.squaredNorm() * dt * dt < kStill * kStill;
    state.scene.set_velocity(e.body[row],
                             still ? Vec3(Vec3::Zero()) : Vec3(e.velocity[row] + error / dt),
                             still ? Vec3(Vec3::Zero()) : Vec3(e.angular_velocity[row] + turn));
}

/// Ghosts near the border are solid: they follow their owner's motion as kinematic bodies.
void update_body(ZoneState& state, world::Row row, double outside_m) {
    const world::Entities& e = state.entities;
    const bool wanted = outside_m <= kContactMargin && !e.has(row, world::kHidden);
    if (!wanted) {
        remove_body(state, row);
    } else if (e.body[row]) {
        lead_body(state, row);
    } else {
        add_body(state, row, false);
    }
}

struct GhostArrival {
    const EntityState* state = nullptr;
    ZoneId owner;
    Vec3 shift = Vec3::Zero();
    double outside_m = 0.0;
};

std::vector<GhostArrival> collect_arrivals(const ZoneState& state,
                                           std::span<ZoneState* const> zones) {
    std::vector<GhostArrival> arrivals;
    const Region& region = state.settings.region();
    for (const ZoneState* source : zones) {
        if (source == &state) {
            continue;
        }
        const Vec3d origin = source->settings.region().origin();
        const Vec3 shift = (origin - region.origin()).cast<float>();
        for (const EntityState& ghost : source->ghosts_out) {
            const Vec3d at = origin + ghost.position.cast<double>();
            const double outside = region.outside(at.x(), at.z());
            if (outside <= state.settings.ghost_margin_m) {
                arrivals.push_back({&ghost, source->settings.id, shift, outside});
            }
        }
    }
    std::sort(arrivals.begin(), arrivals.end(), [](const GhostArrival& a, const GhostArrival& b) {
        return a.state->id < b.state->id;
    });
    return arrivals;
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

/// Which rows neighbours hear of: only those can have changed that stir or were touched.
void follow_border(ZoneState& state) {
    world::Entities& e = state.entities;
    const Vec3d origin = state.settings.region().origin();
    while (state.near_border.size() < e.size()) {
        state.near_border.push_back(false);
    }
    while (state.near_border.size() > e.size()) {
        state.near_border.move_last_into(static_cast<world::Row>(state.near_border.size() - 1));
    }
    world::for_each_row(e.stirring(), e.touched(world::Reader::kExport), [&](world::Row row) {
        const bool exported = !e.has(row, world::kGhost) && !e.has(row, world::kHidden);
        state.near_border.put(
            row, exported && reaches_another_zone(state, origin + e.position[row].cast<double>()));
    });
    e.forget_touched(world::Reader::kExport);
}

}  // namespace

void export_ghosts(ZoneState& state, bool something_changed) {
    state.ghosts_out_changed = something_changed;
    if (!something_changed) {
        return;
    }
    state.ghosts_out.clear();
    follow_border(state);
    world::for_each_row(state.near_border, [&](world::Row row) {
        state.ghosts_out.push_back(read_entity(state.entities, row));
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
    const std::vector<GhostArrival> arrivals = collect_arrivals(state, zones);
    remove_missing(state, arrivals);
    world::Entities& e = state.entities;
    state.ghost_ids.clear();
    state.ghost_owners.clear();
    for (const GhostArrival& arrival : arrivals) {
        state.ghost_ids.push_back(arrival.state->id);
        state.ghost_owners.push_back(arrival.owner);
        world::Row row = e.find(arrival.state->id);
        if (row == world::kNoRow) {
            row = e.add(arrival.state->id, arrival.state->type);
            e.set(row, world::kGhost, true);
        } else if (same(*arrival.state, e, row, arrival.shift)) {
            if (e.body[row]) {
                lead_body(state, row);
            }
            continue;
        }
        write_entity(*arrival.state, arrival.shift, e, row);
        e.set(row, world::kGhost, true);
        e.set(row, world::kDozing, false);  // here its owner moves it
        update_body(state, row, arrival.outside_m);
        state.ghosts_moved = true;
    }
    state.grid_valid = state.grid_valid && !state.ghosts_moved;
    return static_cast<std::uint32_t>(state.ghost_ids.size());
}

}  // namespace zoned::zone
