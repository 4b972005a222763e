// The world's half of the C interface: entities, the own avatar, types, zones and measurements.
#include "client-sim/library/border.h"
#include "client-sim/library/sized_struct.h"
#include "client-sim/library/static_world.h"
#include "client-sim/view/aim.h"

#include <numbers>

namespace zoned::library {

namespace {

/// 0, or what is wrong with the caller's struct.
template <class Struct>
int given(Struct* out, const Struct& value) {
    return give(out, value) ? 0 : ZONED_CLIENT_BAD_ARGUMENT;
}

/// False for an entity that is not on the screen, and for the own avatar.
bool read_entity(const GameClient& game,
                 EntityId id,
                 const view::Entity& entity,
                 zoned_client_entity& out) {
    const view::View& view = *game.view();
    if (!entity.present() || !entity.typed || id == view.own().id()) {
        return false;
    }
    const auto shown = view.on_screen(entity, game.fraction());
    if (!shown) {
        return false;
    }
    const view::Version& newest = entity.versions.back();
    out.id = id.value;
    out.type = entity.type;
    out.zone = newest.zone.value;
    give_vector(out.position, shown->position);
    give_quaternion(out.orientation, shown->orientation);
    give_vector(out.velocity, shown->velocity);
    out.appearance = newest.quantized.appearance;
    out.at_rest = newest.quantized.at_rest ? 1 : 0;
    return true;
}

}  // namespace

// In a namespace g++ forgets that the header shows them.
#pragma GCC visibility push(default)

extern "C" {

size_t zoned_client_entities(const zoned_client* client,
                             zoned_client_entity* out,
                             size_t capacity) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return 0;
    }
    SizedArray array(out, capacity);
    for (const auto& [id, entity] : view->store().entities()) {
        zoned_client_entity filled{};
        if (read_entity(*client->game, id, entity, filled)) {
            array.add(filled);
        }
    }
    return array.count();
}

int zoned_client_get_entity(const zoned_client* client, uint32_t id, zoned_client_entity* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    const view::Entity* const entity = view->store().find(EntityId(id));
    zoned_client_entity filled{};
    if (entity == nullptr || !read_entity(*client->game, EntityId(id), *entity, filled)) {
        return 0;
    }
    return give(out, filled) ? 1 : ZONED_CLIENT_BAD_ARGUMENT;
}

int zoned_client_own(const zoned_client* client, zoned_client_avatar* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    const view::OwnAvatar& own = view->own();
    const motion::CharacterState* const state = own.known() ? own.state() : nullptr;
    if (state == nullptr) {
        return 0;
    }
    const Vec3d position = own.position_between(client->game->own_fraction());
    zoned_client_avatar filled{};
    filled.id = own.id().value;
    filled.zone = own.zone().value;
    filled.grounded = state->grounded ? 1 : 0;
    filled.carried = state->carried ? 1 : 0;
    filled.yaw = static_cast<float>(state->yaw) * static_cast<float>(std::numbers::pi / 32768.0);
    give_vector(filled.position, position);
    give_vector(filled.eye, Vec3d(position + Vec3d(0.0, view::eye_height(own.limits()), 0.0)));
    give_vector(filled.velocity, state->velocity);
    filled.tick = own.newest_tick();
    return give(out, filled) ? 1 : ZONED_CLIENT_BAD_ARGUMENT;
}

int zoned_client_get_world(const zoned_client* client, zoned_client_world* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    zoned_client_world filled{};
    filled.types = static_cast<std::uint32_t>(view->world().types.size());
    filled.zones = static_cast<std::uint32_t>(view->world().zones.size());
    filled.rights = client->game->player()->client().rights();
    filled.tick_s = view->world().tick_s;
    filled.server_time = client->game->server_time();
    filled.tick = view->displayed_tick();
    return given(out, filled);
}

int zoned_client_type(const zoned_client* client, uint32_t index, zoned_client_type_info* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    if (index >= view->world().types.size()) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    const view::TypeInfo& type = view->world().types[index];
    zoned_client_type_info filled{};
    filled.upright = type.upright ? 1 : 0;
    filled.character = type.character ? 1 : 0;
    filled.seats = type.seats;
    filled.radius = type.limits.radius;
    filled.half_segment = type.limits.half_segment;
    filled.speed = type.limits.speed;
    filled.sprint_factor = type.limits.sprint_factor;
    filled.jump_speed = type.limits.jump_speed;
    filled.gravity = type.limits.gravity;
    give_name(filled.name, type.name);
    return given(out, filled);
}

int zoned_client_zone(const zoned_client* client, uint32_t index, zoned_client_zone_info* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    return index < view->world().zones.size() ? given(out, zone_info(view->world().zones[index]))
                                              : ZONED_CLIENT_BAD_ARGUMENT;
}

size_t zoned_client_boxes(const zoned_client* client,
                          uint32_t zone_index,
                          zoned_client_box* out,
                          size_t capacity) {
    const view::View* const view = view_of(client);
    if (view == nullptr || zone_index >= view->world().zones.size()) {
        return 0;
    }
    SizedArray array(out, capacity);
    const Tick tick = view->displayed_tick();
    // The own avatar is predicted: what it stands on is drawn where it finds it.
    const Tick own_tick = view->own().known() ? view->own().newest_tick() : tick;
    add_boxes(view->world().zones[zone_index], tick, own_tick, array);
    return array.count();
}

size_t zoned_client_triangles(const zoned_client* client,
                              uint32_t zone_index,
                              double* out,
                              size_t capacity) {
    const view::View* const view = view_of(client);
    if (view == nullptr || zone_index >= view->world().zones.size()) {
        return 0;
    }
    return copy_triangles(view->world().zones[zone_index], out, out != nullptr ? capacity : 0);
}

size_t zoned_client_particles(const zoned_client* client,
                              zoned_client_particle* out,
                              size_t capacity) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return 0;
    }
    return guarded(*client, std::size_t{0}, [&]() -> std::size_t {
        std::vector<motion::CosmeticParticle> alive;
        for (const view::CosmeticInfo& system : view->world().cosmetics) {
            for (const motion::CosmeticEmitter& emitter : system.emitters) {
                motion::replay(emitter, view->displayed_tick(), view->world().tick_s, alive);
            }
        }
        view->bursts().replay(view->displayed_tick(), alive);
        SizedArray array(out, capacity);
        for (const motion::CosmeticParticle& particle : alive) {
            zoned_client_particle filled{};
            filled.age = particle.age_share;
            give_vector(filled.position, particle.position);
            give_vector(filled.velocity, particle.velocity);
            array.add(filled);
        }
        return array.count();
    });
}

int zoned_client_aim(const zoned_client* client,
                     const double eye[3],
                     const double direction[3],
                     double range,
                     zoned_client_aim_info* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    if (eye == nullptr || direction == nullptr) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    const Vec3d from(eye[0], eye[1], eye[2]);
    const Vec3d along(direction[0], direction[1], direction[2]);
    if (!from.allFinite() || !along.allFinite() || !(along.norm() > 0.0) || !(range >= 0.0)) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    return guarded(*client, [&]() -> int {
        const view::Aim aim = view::aim(*view, from, along.normalized(), range);
        zoned_client_aim_info filled{};
        filled.past = aim.past ? 1 : 0;
        filled.tick = aim.tick;
        filled.fraction = aim.fraction;
        filled.hit = aim.hit.value;
        filled.distance = aim.distance;
        for (const view::AimSight& near : aim.near) {
            zoned_client_sight& sight = filled.sight[filled.sights++];
            sight.entity = near.entity.value;
            sight.publication = near.publication;
            give_vector(sight.position, near.position);
        }
        return given(out, filled);
    });
}

int zoned_client_shared_value(const zoned_client* client, const char* name, double* out) {
    const view::View* const view = view_of(client);
    if (view == nullptr) {
        return no_view(client);
    }
    const auto value = name != nullptr && out != nullptr
                           ? view->environment().at(name, view->displayed_tick())
                           : std::nullopt;
    if (!value) {
        return ZONED_CLIENT_BAD_ARGUMENT;
    }
    *out = *value;
    return 0;
}

double zoned_client_server_time(const zoned_client* client) {
    return game_of(client) != nullptr ? client->game->server_time() : 0.0;
}

int zoned_client_stats(const zoned_client* client, zoned_client_stats_info* out) {
    if (game_of(client) == nullptr || client->game->player() == nullptr) {
        return no_view(client);
    }
    const view::Player& player = *client->game->player();
    const link::DatagramStats& datagrams = player.client().datagrams();
    const link::SessionStats& session = player.client().stats();
    zoned_client_stats_info filled{};
    filled.tunnelled = session.tunnelled ? 1 : 0;
    filled.rtt_ms = 1e3 * player.client().clock().rtt_s();
    filled.input_lead_ms = 1e3 * player.inputs().lead_s();
    filled.packets_in = datagrams.in;
    filled.packets_out = datagrams.out;
    filled.bytes_in = datagrams.bytes_in + session.frame_bytes_in;
    filled.bytes_out = datagrams.bytes_out + session.frame_bytes_out;
    filled.malformed = datagrams.malformed + datagrams.unauthenticated + session.malformed_frames;
    filled.resumed = session.resumed;
    filled.inputs = player.inputs().stats().ticks;
    filled.inputs_missing = player.inputs().stats().missing;
    filled.events_dropped = client->game->events_dropped();
    const RecentValues& corrections = client->game->corrections();
    filled.corrections = corrections.count();
    filled.correction_last_m = corrections.last();
    filled.correction_p99_m = corrections.quantile(0.99);
    filled.correction_max_m = corrections.quantile(1.0);
    const TruthMeter& truth = client->game->truth();
    filled.compared = truth.displayed().count();
    filled.displayed_error_p50_m = truth.displayed().quantile(0.5);
    filled.displayed_error_p99_m = truth.displayed().quantile(0.99);
    filled.own_error_p99_m = truth.own().quantile(0.99);
    return given(out, filled);
}

}  // extern "C"

#pragma GCC visibility pop

}  // namespace zoned::library
