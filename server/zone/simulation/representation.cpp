#include "server/zone/simulation/representation.h"

#include "server/zone/simulation/soft_hull.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::zone {

namespace {

/// A player within this share of the distance ends a lower level that began beyond it.
constexpr float kReturn = 0.9F;
/// A faster entity is found when it is nearer, m/s.
constexpr float kFast = 25.0F;
constexpr float kSlack = 0.05F;

/// Resting props of a lower level, so many that the surroundings of the players hold fewer.
constexpr std::size_t kManyReduced = 512;

/// Where players are: characters without an agent, ghosts too.
void collect_players(ZoneState& state) {
    const world::Entities& e = state.entities;
    state.players.clear();
    world::for_each_row(e.players(), [&](world::Row row) {
        if (!e.has(row, world::kHidden)) {
            state.players.push_back(e.position[row]);
        }
    });
}

/// Beyond it from all players nothing goes up a level, m.
float farthest_return(const world::TypeTable& types) {
    float farthest = 0.0F;
    for (const world::EntityType& type : types) {
        farthest = std::max({farthest, type.single_beyond_m, type.particle_beyond_m});
    }
    return kReturn * farthest;
}

/// The rows that may go to another level now, ascending: props that move, and those of a lower
/// level near a player. A prop that rests goes down no level, because it costs nothing.
void list_candidates(ZoneState& state, std::vector<world::Row>& out) {
    const world::Entities& e = state.entities;
    out.clear();
    if (e.reduced().count() <= kManyReduced) {
        world::for_each_row(e.moving(), e.reduced(), [&](world::Row row) { out.push_back(row); });
        return;
    }
    world::for_each_row(e.moving(), [&](world::Row row) { out.push_back(row); });
    const float reach = farthest_return(*state.settings.types);
    for (const Vec3& player : state.players) {
        current_grid(state).for_each_within(
            player.x(), player.z(), reach, [&](std::uint32_t row, float) {
                if (e.reduced().has(row)) {
                    out.push_back(row);
                }
            });
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
}

float nearest_player(const ZoneState& state, const Vec3& at) {
    float nearest2 = std::numeric_limits<float>::infinity();
    for (const Vec3& player : state.players) {
        nearest2 = std::min(nearest2, (player - at).squaredNorm());
    }
    return std::sqrt(nearest2);
}

/// The least level that it may have at that distance, with hysteresis against its present one.
Representation wanted_at(const world::EntityType& type, float distance, Representation now) {
    const auto beyond = [&](float limit, Representation what) {
        return limit > 0.0F && distance > (now >= what ? kReturn * limit : limit);
    };
    if (beyond(type.particle_beyond_m, Representation::kParticle)) {
        return Representation::kParticle;
    }
    return beyond(type.single_beyond_m, Representation::kSingle) ? Representation::kSingle
                                                                 : Representation::kFull;
}

/// Moving entities that may reach it, or that it may reach, before the next look.
bool may_touch(ZoneState& state, world::Row row, const world::EntityType& type) {
    const world::Entities& e = state.entities;
    const float time = static_cast<float>(2 * kRepresentationTicks) * state.settings.dt;
    const Vec3& at = e.position[row];
    const float speed = e.velocity[row].norm();
    state.bodies_near.clear();
    state.scene.overlap(Aabb{at, at}.grown(type.extent() + (speed + kFast) * time),
                        state.bodies_near);
    return std::any_of(state.bodies_near.begin(), state.bodies_near.end(), [&](BodyId body) {
        const world::Row other = e.find(EntityId(state.scene.user(body)));
        if (other == world::kNoRow || other == row) {
            return false;
        }
        const float apart = (e.position[other] - at).norm() - type.extent() -
                            (*state.settings.types)[e.type[other]].extent();
        return apart <= (speed + e.velocity[other].norm()) * time + kSlack;
    });
}

void become(ZoneState& state, world::Row row, Representation wanted) {
    world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    const auto now = static_cast<Representation>(e.representation[row]);
    if (is_soft(state, row)) {
        if (wanted == Representation::kFull) {
            step_up_soft(state, row);
        } else if (!step_down_soft(state, row)) {
            return;
        }
        e.set_representation(row, static_cast<std::uint8_t>(wanted));
        return;
    }
    const BodyId body = e.body[row];
    if ((now == Representation::kParticle) != (wanted == Representation::kParticle)) {
        const auto as = wanted == Representation::kParticle ? physics::BodyRepresentation::kParticle
                                                            : physics::BodyRepresentation::kFull;
        if (!state.scene.set_representation(body, as)) {
            return;  // it has joints: it stays as it is
        }
    }
    if (type.single_beyond_m > 0.0F && wanted != Representation::kParticle) {
        const auto& shapes =
            wanted == Representation::kSingle ? state.settings.outers : state.settings.solids;
        const bool fits = state.scene.set_shape(body, shapes[type.solid]).ok();
        ZONED_ASSERT(fits, "shapes of types are valid");
    }
    e.set_representation(row, static_cast<std::uint8_t>(wanted));
}

/// Whether it is in touch with something that may push it.
bool touches(const ZoneState& state, world::Row row) {
    const BodyId body = state.entities.body[row];
    return body ? state.scene.touches_bodies(body)
                : state.soft->bodies.touches_bodies(soft_of(state, state.entities.id[row]));
}

}  // namespace

std::uint32_t choose_representations(ZoneState& state) {
    if (state.now % kRepresentationTicks != 0) {
        return 0;
    }
    collect_players(state);
    world::Entities& e = state.entities;
    std::uint32_t changed = 0;
    list_candidates(state, state.representation_rows);
    for (const world::Row row : state.representation_rows) {
        const world::EntityType& type = (*state.settings.types)[e.type[row]];
        if (!type.reducible() || e.has(row, world::kGhost) ||
            !(e.body[row] || soft_of(state, e.id[row]))) {
            continue;
        }
        const auto now = static_cast<Representation>(e.representation[row]);
        Representation wanted = wanted_at(type, nearest_player(state, e.position[row]), now);
        if (wanted > now && (e.has(row, world::kAtRest) || touches(state, row))) {
            continue;  // a sleeping body costs nothing, and nobody pulls a stone out of a wall
        }
        if (wanted == Representation::kParticle && may_touch(state, row, type)) {
            wanted = type.single_beyond_m > 0.0F ? Representation::kSingle : Representation::kFull;
        }
        if (wanted != now) {
            become(state, row, wanted);
            ++changed;
        }
    }
    return changed;
}

}  // namespace zoned::zone
