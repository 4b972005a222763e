// The exports of the WebAssembly module beside those of zoned_client.h: flat numbers in place of
// structs, and rows of entities as the viewer draws them.
#include "client-sim/library/border.h"
#include "client-sim/web/web_verdict.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>
#include <vector>

#define ZONED_WEB_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

/// One entity as server/admin/viewer/entities.js reads it.
struct Row {
    std::array<float, 3> position{};
    std::uint32_t tick = 0;
    std::array<std::int16_t, 4> orientation{};  // x, y, z, w
    std::array<std::uint16_t, 3> velocity{};    // half floats: 0, as rows are made for each picture
    std::uint16_t type = 0;
    std::uint32_t id = 0;
    std::uint8_t flags = 0;  // 1: at rest, 2: the own avatar
    std::uint8_t zone = 0;
    std::uint16_t heat = 0;
};

static_assert(sizeof(Row) == 40, "rows are read as they lie");

constexpr std::size_t kHeadWords = 4;
constexpr std::size_t kRowWords = sizeof(Row) / 4;
constexpr std::uint8_t kAtRest = 1;
constexpr std::uint8_t kAvatar = 2;

std::array<char, 512> error_text{};
std::array<char, ZONED_CLIENT_NAME_BYTES> name_text{};
std::vector<zoned_client_entity> entities;
std::vector<zoned_client_box> boxes;

template <class Struct>
Struct sized() {
    Struct out{};
    out.size = sizeof(Struct);
    return out;
}

/// Fills `entities` with those displayed now.
void read_entities(const zoned_client* client) {
    entities.resize(zoned_client_entities(client, nullptr, 0));
    std::fill(entities.begin(), entities.end(), sized<zoned_client_entity>());
    zoned_client_entities(client, entities.data(), entities.size());
}

std::int16_t part_of(float share) {
    return static_cast<std::int16_t>(std::lround(std::clamp(share, -1.0F, 1.0F) * 32767.0F));
}

void put_orientation(Row& row, const float (&q)[4]) {
    row.orientation = {part_of(q[0]), part_of(q[1]), part_of(q[2]), part_of(q[3])};
}

template <class Numbers>
void put(double*& out, const Numbers& numbers) {
    for (const auto number : numbers) {
        *out++ = static_cast<double>(number);
    }
}

/// Of a client that web_create() has made.
zoned::web::WebVerdict& verdict_of(const zoned_client& client) {
    return static_cast<zoned::web::WebVerdict&>(*client.game->observer());
}

}  // namespace

ZONED_WEB_EXPORT void* web_alloc(std::size_t bytes) {
    return std::malloc(bytes);
}

ZONED_WEB_EXPORT void web_free(void* memory) {
    std::free(memory);
}

/// Why the last creation failed.
ZONED_WEB_EXPORT const char* web_error() {
    return error_text.data();
}

/// Name or text that web_type(), web_field() or web_field_info() gave last.
ZONED_WEB_EXPORT const char* web_name() {
    return name_text.data();
}

ZONED_WEB_EXPORT zoned_client* web_create(const char* name,
                                          const char* team,
                                          const void* ticket,
                                          std::size_t ticket_size,
                                          std::uint32_t view) {
    auto settings = sized<zoned_client_settings>();
    settings.view = view;
    settings.measure = 1;
    settings.name = name;
    settings.team = team;
    settings.ticket = ticket_size > 0 ? ticket : nullptr;
    settings.ticket_size = ticket_size;
    zoned_client* const client =
        zoned_client_create(ZONED_CLIENT_ABI, &settings, error_text.data(), error_text.size());
    if (client != nullptr) {
        client->game->set_observer(std::make_unique<zoned::web::WebVerdict>(*client->game));
    }
    return client;
}

ZONED_WEB_EXPORT int web_input(zoned_client* client,
                               std::uint32_t buttons,
                               float move_x,
                               float move_z,
                               float yaw,
                               float pitch) {
    auto input = sized<zoned_client_input>();
    input.buttons = buttons;
    input.move_x = move_x;
    input.move_z = move_z;
    input.yaw = yaw;
    input.pitch = pitch;
    return zoned_client_set_input(client, &input);
}

/// 1: kind and number of a field of an entity; web_name() is its text. 0: there is none. `named`:
/// its name where it is not null, else `index` counts.
ZONED_WEB_EXPORT int web_field(const zoned_client* client,
                               std::uint32_t entity,
                               std::uint32_t index,
                               const char* named,
                               double* out) {
    auto value = sized<zoned_client_field_value>();
    const int result = named != nullptr ? zoned_client_field_named(client, entity, named, &value)
                                        : zoned_client_field_at(client, entity, index, &value);
    if (result != 1) {
        return 0;
    }
    std::memcpy(name_text.data(), value.text, name_text.size());
    put(out, std::array<double, 2>{double(value.kind), value.number});
    return 1;
}

/// 1: kind, minimum, maximum, quantum and number of values of a field of a type; web_name() is its
/// name. 0: there is none.
ZONED_WEB_EXPORT int web_field_info(const zoned_client* client,
                                    std::uint32_t type,
                                    std::uint32_t index,
                                    double* out) {
    auto info = sized<zoned_client_field_info>();
    if (zoned_client_field(client, type, index, &info) != 0) {
        return 0;
    }
    std::memcpy(name_text.data(), info.name, name_text.size());
    put(out,
        std::array<double, 5>{
            double(info.kind), info.minimum, info.maximum, info.quantum, double(info.values)});
    return 1;
}

/// 1: id, zone, grounded, carried, yaw, position (3), eye (3), velocity (3), tick.
ZONED_WEB_EXPORT int web_own(const zoned_client* client, double* out) {
    auto own = sized<zoned_client_avatar>();
    if (zoned_client_own(client, &own) != 1) {
        return 0;
    }
    put(out,
        std::array<double, 5>{double(own.id),
                              double(own.zone),
                              double(own.grounded),
                              double(own.carried),
                              double(own.yaw)});
    put(out, own.position);
    put(out, own.eye);
    put(out, own.velocity);
    *out = static_cast<double>(own.tick);
    return 1;
}

/// 1: types, zones, rights, length of a tick, server time, displayed tick.
ZONED_WEB_EXPORT int web_world(const zoned_client* client, double* out) {
    auto world = sized<zoned_client_world>();
    if (zoned_client_get_world(client, &world) != 0) {
        return 0;
    }
    put(out,
        std::array<double, 6>{double(world.types),
                              double(world.zones),
                              double(world.rights),
                              world.tick_s,
                              world.server_time,
                              double(world.tick)});
    return 1;
}

/// 1: upright, character, radius, half segment, seats; web_name() is its name.
ZONED_WEB_EXPORT int web_type(const zoned_client* client, std::uint32_t index, double* out) {
    auto type = sized<zoned_client_type_info>();
    if (zoned_client_type(client, index, &type) != 0) {
        return 0;
    }
    std::memcpy(name_text.data(), type.name, name_text.size());
    put(out,
        std::array<double, 5>{double(type.upright),
                              double(type.character),
                              double(type.radius),
                              double(type.half_segment),
                              double(type.seats)});
    return 1;
}

/// 1: id, lower x and z, upper x and z, ground, boxes, triangles.
ZONED_WEB_EXPORT int web_zone(const zoned_client* client, std::uint32_t index, double* out) {
    auto zone = sized<zoned_client_zone_info>();
    if (zoned_client_zone(client, index, &zone) != 0) {
        return 0;
    }
    *out++ = zone.id;
    put(out, zone.lower);
    put(out, zone.upper);
    put(out, std::array<double, 3>{zone.ground_height, double(zone.boxes), double(zone.triangles)});
    return 1;
}

/// Solid boxes as the viewer lays them out: place, half sizes, turn (x, y, z, w). `kind`: 0 for
/// those that never change, 1 for doors that are shut now, 2 for platforms where they are now.
/// Returns how many; fills at most `capacity`.
ZONED_WEB_EXPORT std::size_t web_boxes(const zoned_client* client,
                                       std::uint32_t zone,
                                       int kind,
                                       float* out,
                                       std::size_t capacity) {
    const std::size_t count = zoned_client_boxes(client, zone, nullptr, 0);
    boxes.assign(count, sized<zoned_client_box>());
    zoned_client_boxes(client, zone, boxes.data(), count);
    std::size_t filled = 0;
    for (const zoned_client_box& box : boxes) {
        const int of_box = box.platform != 0 ? 2 : (box.door != 0 ? 1 : 0);
        if (of_box != kind || box.shut == 0) {
            continue;
        }
        if (filled++ < capacity) {
            for (const double part : box.centre) {
                *out++ = static_cast<float>(part);
            }
            out = std::copy(std::begin(box.half_extents), std::end(box.half_extents), out);
            out = std::copy(std::begin(box.orientation), std::end(box.orientation), out);
        }
    }
    return filled;
}

/// The entities that are displayed now. Returns how many there are; fills 15 numbers for each of at
/// most `capacity`: id, type, zone, appearance, at rest, position (3), orientation (4), velocity
/// (3).
ZONED_WEB_EXPORT std::size_t web_entities(const zoned_client* client,
                                          double* out,
                                          std::size_t capacity) {
    if (capacity == 0) {
        return zoned_client_entities(client, nullptr, 0);
    }
    read_entities(client);
    for (std::size_t i = 0; i < std::min(entities.size(), capacity); ++i) {
        const zoned_client_entity& entity = entities[i];
        put(out,
            std::array<std::uint32_t, 5>{
                entity.id, entity.type, entity.zone, entity.appearance, entity.at_rest});
        put(out, entity.position);
        put(out, entity.orientation);
        put(out, entity.velocity);
    }
    return entities.size();
}

/// The scene as it is displayed now, as one whole message of the viewer's stream; the own avatar
/// comes last. Returns its size in bytes, at most `capacity`.
ZONED_WEB_EXPORT std::size_t web_rows(const zoned_client* client,
                                      std::uint32_t own_type,
                                      std::uint32_t* out,
                                      std::size_t capacity) {
    auto world = sized<zoned_client_world>();
    if (zoned_client_get_world(client, &world) != 0 || capacity < 4 * kHeadWords) {
        return 0;
    }
    const std::size_t most = (capacity / 4 - kHeadWords) / (1 + kRowWords);
    read_entities(client);
    std::uint32_t count = 0;
    std::uint32_t* at = out + kHeadWords;
    const auto add = [&](Row& row) {
        if (count < most) {
            row.tick = static_cast<std::uint32_t>(world.tick);
            *at++ = count++;
            std::memcpy(at, &row, sizeof(row));
            at += kRowWords;
        }
    };
    for (const zoned_client_entity& entity : entities) {
        Row row;
        for (std::size_t k = 0; k < 3; ++k) {
            row.position[k] = static_cast<float>(entity.position[k]);
        }
        put_orientation(row, entity.orientation);
        row.type = static_cast<std::uint16_t>(entity.type);
        row.id = entity.id;
        row.flags = entity.at_rest != 0 ? kAtRest : 0;
        row.zone = static_cast<std::uint8_t>(entity.zone);
        add(row);
    }
    auto own = sized<zoned_client_avatar>();
    if (zoned_client_own(client, &own) == 1) {
        Row row;
        for (std::size_t k = 0; k < 3; ++k) {
            row.position[k] = static_cast<float>(own.position[k]);
        }
        row.orientation = {0,
                           part_of(zoned::elementary::sin(0.5F * own.yaw)),
                           0,
                           part_of(zoned::elementary::cos(0.5F * own.yaw))};
        row.type = static_cast<std::uint16_t>(own_type);
        row.id = own.id;
        row.flags = kAvatar;
        row.zone = static_cast<std::uint8_t>(own.zone);
        add(row);
    }
    out[0] = 1;
    out[1] = static_cast<std::uint32_t>(world.tick);
    out[2] = 0;
    out[3] = count;
    return 4 * static_cast<std::size_t>(at - out);
}

/// 1: round trip in ms, input lead in ms, bytes in and out, packets in, malformed, resumed, inputs,
/// inputs missing, corrections, and of these the last, the 99th percentile and the greatest, m;
/// entities compared with the truth, error displayed (p50, p99) and own error (p99), m.
ZONED_WEB_EXPORT int web_stats(const zoned_client* client, double* out) {
    auto stats = sized<zoned_client_stats_info>();
    if (zoned_client_stats(client, &stats) != 0) {
        return 0;
    }
    put(out,
        std::array<double, 17>{stats.rtt_ms,
                               stats.input_lead_ms,
                               double(stats.bytes_in),
                               double(stats.bytes_out),
                               double(stats.packets_in),
                               double(stats.malformed),
                               double(stats.resumed),
                               double(stats.inputs),
                               double(stats.inputs_missing),
                               double(stats.corrections),
                               stats.correction_last_m,
                               stats.correction_p99_m,
                               stats.correction_max_m,
                               double(stats.compared),
                               stats.displayed_error_p50_m,
                               stats.displayed_error_p99_m,
                               stats.own_error_p99_m});
    return 1;
}

/// 1: an event; `out` is its kind, tick and the size of its payload. 0: none. -3: the payload wants
/// more room than `capacity`, and the event stays the next.
ZONED_WEB_EXPORT int web_event(zoned_client* client,
                               double* out,
                               void* payload,
                               std::size_t capacity) {
    auto event = sized<zoned_client_event>();
    const int result = zoned_client_next_event(client, &event, payload, capacity);
    put(out,
        std::array<double, 3>{double(event.kind), double(event.tick), double(event.payload_size)});
    return result;
}

/// A ray from `from` along `along` (3 numbers each) over `range` m. Returns how many sights there
/// are, or below 0. `out`: past, tick, fraction, hit, then per sight entity, publication, place
/// (3).
ZONED_WEB_EXPORT int web_aim(const zoned_client* client,
                             const double* from,
                             const double* along,
                             double range,
                             double* out) {
    auto aim = sized<zoned_client_aim_info>();
    const int result = zoned_client_aim(client, from, along, range, &aim);
    if (result != 0) {
        return result;
    }
    put(out,
        std::array<double, 4>{double(aim.past), double(aim.tick), aim.fraction, double(aim.hit)});
    for (std::uint32_t i = 0; i < aim.sights; ++i) {
        *out++ = aim.sight[i].entity;
        *out++ = static_cast<double>(aim.sight[i].publication);
        put(out, aim.sight[i].position);
    }
    return static_cast<int>(aim.sights);
}

/// Judged by the promised bounds, as client-sim judges its bots: states compared, positions and
/// orientations beyond their bound, entities missing and entities too many, wrong values of fields
/// and of the shared environment, and the greatest error of a predicted position, m.
ZONED_WEB_EXPORT void web_judged(const zoned_client* client, double* out) {
    const zoned::audit::Tally& tally = verdict_of(*client).tally();
    put(out,
        std::array<double, 7>{double(tally.samples),
                              double(tally.position_violations),
                              double(tally.orientation_violations),
                              double(tally.missing),
                              double(tally.extra),
                              double(tally.field_violations + tally.environment_violations),
                              tally.predicted_m.max()});
}

/// "consistent", or "inconsistent" with its reasons; empty: nothing was compared.
ZONED_WEB_EXPORT const char* web_verdict(const zoned_client* client) {
    return verdict_of(*client).text().c_str();
}
