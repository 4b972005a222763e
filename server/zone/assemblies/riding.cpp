#include "server/zone/assemblies/riding.h"

#include "server/zone/assemblies/motors.h"
#include "server/zone/simulation/approaching_props.h"
#include "server/zone/simulation/type_body.h"

#include <algorithm>
#include <vector>

namespace zoned::zone {

namespace {

template <class Riders>
auto rider_at(Riders& riders, EntityId rider) {
    return std::lower_bound(
        riders.begin(), riders.end(), rider, [](const Rider& one, EntityId wanted) {
            return one.rider < wanted;
        });
}

bool may_ride(const ZoneState& state, world::Row rider, world::Row carrier) {
    const world::Entities& e = state.entities;
    const auto here = [&](world::Row row) {
        return row != world::kNoRow && !e.has(row, world::kGhost) && !e.has(row, world::kHidden);
    };
    return here(rider) && here(carrier) && !is_prop(state, rider) && is_prop(state, carrier) &&
           e.body[carrier] && !e.has(rider, world::kCarried) &&
           state.agents.find(e.id[rider]) == nullptr;
}

/// Moving bodies and a rider do not push each other: its seat would throw the rider out.
void meet_nothing(ZoneState& state, world::Row row, bool on) {
    const BodyId body = state.entities.body[row];
    if (!body) {
        return;
    }
    physics::Filter filter = filter_of((*state.settings.types)[state.entities.type[row]]);
    if (on) {
        filter.mask = 0;
    }
    state.scene.set_filter(body, filter);
}

void carry(ZoneState& state, const Rider& ride) {
    world::Entities& e = state.entities;
    const world::Row row = e.find(ride.rider);
    const world::Row carrier = e.find(ride.carrier);
    const Vec3 arm = e.orientation[carrier] * ride.place;
    const Vec3 velocity = e.velocity[carrier] + e.angular_velocity[carrier].cross(arm);
    const Vec3 before = e.velocity[row];
    const Vec3 place = e.position[carrier] + arm;
    const bool still = place == e.position[row] && e.command[row].yaw == e.yaw[row];
    e.position[row] = place;
    e.velocity[row] = velocity;
    e.acceleration[row] = (velocity - before) / state.settings.dt;
    const std::uint16_t yaw = e.command[row].yaw;
    if (e.yaw[row] != yaw) {
        e.yaw[row] = yaw;
        e.orientation[row] = motion::orientation_from_yaw(yaw);
    }
    e.set(row, world::kAtRest, still && e.has(carrier, world::kAtRest));
    if (e.body[row]) {
        state.scene.set_state(e.body[row],
                              {e.position[row], e.orientation[row], velocity, Vec3::Zero(), false});
    }
}

}  // namespace

bool mount(ZoneState& state, EntityId rider, EntityId carrier, const Vec3& place, EntityId drives) {
    world::Entities& e = state.entities;
    const world::Row row = e.find(rider);
    if (!may_ride(state, row, e.find(carrier)) || !place.allFinite()) {
        return false;
    }
    auto& riders = state.assemblies.riders;
    const Rider ride{rider, carrier, place, drives};
    riders.insert(rider_at(riders, rider), ride);
    e.set(row, world::kCarried, true);
    e.set(row, world::kGrounded, false);
    e.discontinuity_tick[row] = state.now;
    meet_nothing(state, row, true);
    carry(state, ride);
    e.acceleration[row].setZero();
    state.grid_valid = false;
    return true;
}

void dismount(ZoneState& state, EntityId rider) {
    const Rider* ride = ride_of(state, rider);
    if (ride == nullptr) {
        return;
    }
    const EntityId drives = ride->drives;
    take_ride(state, rider);
    world::Entities& e = state.entities;
    const world::Row row = e.find(rider);
    e.set(row, world::kCarried, false);
    e.set(row, world::kAtRest, false);
    e.discontinuity_tick[row] = state.now;
    meet_nothing(state, row, false);
    if (drives) {
        release_controls(state, drives);
    }
}

void end_rides_of(ZoneState& state, EntityId entity) {
    std::vector<EntityId> riders;
    for (const Rider& ride : state.assemblies.riders) {
        if (ride.rider == entity || ride.carrier == entity) {
            riders.push_back(ride.rider);
        }
    }
    for (const EntityId rider : riders) {
        dismount(state, rider);
    }
}

const Rider* ride_of(const ZoneState& state, EntityId rider) {
    const auto& riders = state.assemblies.riders;
    const auto at = rider_at(riders, rider);
    return at != riders.end() && at->rider == rider ? &*at : nullptr;
}

void give_ride(ZoneState& state, const Rider& rider) {
    auto& riders = state.assemblies.riders;
    riders.insert(rider_at(riders, rider.rider), rider);
    const world::Row row = state.entities.find(rider.rider);
    meet_nothing(state, row, true);
}

void take_ride(ZoneState& state, EntityId rider) {
    auto& riders = state.assemblies.riders;
    const auto at = rider_at(riders, rider);
    if (at != riders.end() && at->rider == rider) {
        riders.erase(at);
    }
}

std::uint32_t carry_riders(ZoneState& state) {
    for (const Rider& ride : state.assemblies.riders) {
        carry(state, ride);
    }
    const auto count = static_cast<std::uint32_t>(state.assemblies.riders.size());
    state.grid_valid = state.grid_valid && count == 0;
    return count;
}

}  // namespace zoned::zone
