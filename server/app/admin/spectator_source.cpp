#include "server/app/admin/spectator_source.h"

#include "shared/core/json.h"

#include <algorithm>
#include <utility>

namespace zoned::app {

namespace {

/// Cut off rather than rounded: it runs for every entity between two ticks.
std::int16_t part_of(float unit) {
    return static_cast<std::int16_t>(std::clamp(unit, -1.0F, 1.0F) * 32767.0F);
}

template <class Values>
void numbers(core::JsonWriter& json, const char* name, const Values& values) {
    json.key(name).begin_array();
    for (const auto value : values) {
        json.value(static_cast<double>(value));
    }
    json.end_array();
}

/// Half sizes of a box; of a round shape radius, half of its segment, radius.
void write_type(core::JsonWriter& json, const world::EntityType& type) {
    Vec3 size = type.half_extents;
    bool round = false;
    switch (type.shape) {
        case world::TypeShape::kSphere:
            size = Vec3(type.radius, 0.0F, type.radius);
            round = true;
            break;
        case world::TypeShape::kCapsule:
            size = Vec3(type.radius, type.half_segment, type.radius);
            round = true;
            break;
        case world::TypeShape::kSolid:
            size = 0.5F * (type.standing.upper - type.standing.lower);
            break;
        case world::TypeShape::kBox:
        case world::TypeShape::kSoft:
            break;
    }
    json.begin_object().field("name", type.name).field("round", round);
    numbers(json, "size", size);
    json.end_object();
}

}  // namespace

std::string scene_json(const config::Settings& settings) {
    core::JsonWriter json;
    json.begin_object()
        .field("world", settings.world_name)
        .field("ground_height_m", static_cast<double>(settings.ground_height_m));
    json.key("types").begin_array();
    for (const world::EntityType& type : settings.types) {
        write_type(json, type);
    }
    json.end_array().key("zones").begin_array();
    for (const config::ZoneRegion& zone : settings.zones) {
        json.begin_object()
            .field("name", zone.name)
            .field("min_x", zone.min_x)
            .field("min_z", zone.min_z)
            .field("max_x", zone.max_x)
            .field("max_z", zone.max_z)
            .end_object();
    }
    json.end_array().key("boxes").begin_array();
    for (const motion::StaticBox& box : settings.boxes) {
        json.begin_object();
        numbers(json, "p", box.centre);
        numbers(json, "size", box.half_extents);
        numbers(json, "q", box.orientation.coeffs());
        json.end_object();
    }
    json.end_array().end_object();
    return json.text();
}

admin::SpectatorSample sample_of(const World& world) {
    admin::SpectatorSample out;
    out.tick = world.now();
    std::size_t all = 0;
    for (const auto& zone : world.zones()) {
        all += zone->report().census.entities;
    }
    out.rows.reserve(all);
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = std::as_const(*zone).state();
        const world::Entities& entities = state.entities;
        const Vec3d origin = state.settings.region().origin();
        for (world::Row row = 0; row < entities.size(); ++row) {
            if ((entities.flags[row] & (world::kGhost | world::kHidden)) != 0) {
                continue;
            }
            admin::SpectatorRow& to = out.rows.emplace_back();
            const Vec3d at = origin + entities.position[row].cast<double>();
            const Quat& turn = entities.orientation[row];
            to.id = entities.id[row].value;
            to.position = {
                static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
            to.orientation = {
                part_of(turn.x()), part_of(turn.y()), part_of(turn.z()), part_of(turn.w())};
            to.type = entities.type[row];
            if (entities.has(row, world::kAtRest)) {
                to.flags |= admin::kSpectatorAtRest;
            }
            if (entities.client[row]) {
                to.flags |= admin::kSpectatorAvatar;
            }
            to.zone = static_cast<std::uint8_t>(state.settings.id.value);
        }
    }
    return out;
}

admin::SpectatorSource spectator_source(const config::Settings& settings, TickLoop& loop) {
    admin::SpectatorSource source;
    source.scene = [&settings] {
        return scene_json(settings);
    };
    source.sample = [&loop](std::function<void(admin::SpectatorSample)> take) {
        return loop.visit([take = std::move(take)](const World& world) { take(sample_of(world)); });
    };
    return source;
}

}  // namespace zoned::app
