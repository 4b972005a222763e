// Functions that change entities. Each says whether it did: an entity that is gone, hidden or of
// another zone is no error.
#include "server/scripting/api/arguments.h"

#include <algorithm>
#include <cmath>

namespace zoned::scripting {

namespace {

constexpr std::int64_t kMaxUint16 = 0xFFFF;
constexpr std::int64_t kMaxParticles = 1000;
constexpr std::size_t kSpawnUnits = 500;
constexpr std::size_t kMoveUnits = 50;
/// With so many entities in a zone, scripts spawn_of_type no more: a mistake fills no scene.
constexpr std::size_t kMostEntities = 100'000;

/// An entity of this zone that is in the world.
bool is_in_world(lua_State* lua, EntityId entity) {
    const world::Row row = owned_row(lua, entity);
    return row != world::kNoRow && !reading(lua).entities().has(row, world::kHidden);
}

bool is_out_of_world(lua_State* lua, EntityId entity) {
    const world::Row row = owned_row(lua, entity);
    return row != world::kNoRow && reading(lua).entities().has(row, world::kHidden);
}

/// A type that may be spawned by its name.
TypeIndex type_argument(lua_State* lua, int index) {
    const std::string_view name = name_argument(lua, index, "type");
    const world::TypeTable& types = reading(lua).types();
    const auto at = std::find_if(types.begin(), types.end(), [&](const world::EntityType& type) {
        return type.name == name;
    });
    luaL_argcheck(lua, at != types.end(), index, "type: the world has none of that name");
    luaL_argcheck(lua, at->assembly == 0 || at->part == 0, index, "type: it is a part of another");
    return static_cast<TypeIndex>(at - types.begin());
}

void read_spawn_options(lua_State* lua, int options, zone::SpawnDef& def) {
    check_fields(lua, options, {"vx", "vy", "vz", "yaw", "appearance", "asleep"});
    constexpr const char* kAxes[] = {"vx", "vy", "vz"};
    for (int axis = 0; axis < 3; ++axis) {
        read_option(lua, options, kAxes[axis], [&](int at) {
            def.velocity[axis] = number_argument(lua, at, kAxes[axis], 1'000.0F);
        });
    }
    read_option(lua, options, "yaw", [&](int at) {
        def.yaw = static_cast<std::uint16_t>(integer_argument(lua, at, "yaw", 0, kMaxUint16));
    });
    read_option(lua, options, "appearance", [&](int at) {
        def.appearance =
            static_cast<std::uint16_t>(integer_argument(lua, at, "appearance", 0, kMaxUint16));
    });
    read_option(
        lua, options, "asleep", [&](int at) { def.asleep = truth_argument(lua, at, "asleep"); });
}

/// spawn(type, x, y, z [, { vx =, vy =, vz =, yaw =, appearance =, asleep = }]): the entity, nil
/// where the zone is full.
int spawn_of_type(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    zone::SpawnDef def;
    def.type = type_argument(lua, 1);
    def.position = position_argument(lua, 2);
    if (!lua_isnoneornil(lua, 5)) {
        read_spawn_options(lua, 5, def);
    }
    Interpreter::charge(lua, kSpawnUnits);
    const bool full = context.entities().size() >= kMostEntities;
    push_entity(lua, full ? EntityId() : context.spawn(def));
    return 1;
}

/// despawn(entity): no avatar of a client that is here.
int despawn(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const world::Row row = owned_row(lua, entity);
    if (row == world::kNoRow || context.entities().client[row]) {
        return push_done(lua, false);
    }
    context.despawn(entity);
    Host::of(lua).entities->set(std::int64_t{entity.value}, std::monostate());
    return push_done(lua, true);
}

/// teleport(entity, x, y, z)
int teleport(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 to = position_argument(lua, 2);
    Interpreter::charge(lua, kMoveUnits);
    const bool can = is_in_world(lua, entity);
    if (can) {
        context.teleport(entity, to);
    }
    return push_done(lua, can);
}

/// add_velocity(entity, vx, vy, vz)
int add_velocity(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 change = velocity_argument(lua, 2);
    const bool can = is_in_world(lua, entity);
    if (can) {
        context.add_velocity(entity, change);
    }
    return push_done(lua, can);
}

int hide(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    Interpreter::charge(lua, kMoveUnits);
    const bool can = is_in_world(lua, entity);
    if (can) {
        context.hide(entity);
    }
    return push_done(lua, can);
}

/// show(entity, x, y, z): what was hidden, at rest.
int show(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const Vec3 at = position_argument(lua, 2);
    Interpreter::charge(lua, kMoveUnits);
    const bool can = is_out_of_world(lua, entity);
    if (can) {
        context.show(entity, at, Vec3::Zero());
    }
    return push_done(lua, can);
}

/// set_appearance(entity, appearance)
int set_appearance(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const auto to =
        static_cast<std::uint16_t>(integer_argument(lua, 2, "appearance", 0, kMaxUint16));
    const bool can = owned_row(lua, entity) != world::kNoRow;
    if (can) {
        context.set_appearance(entity, to);
    }
    return push_done(lua, can);
}

/// set_field(entity, name, value): false where the entity is not owned, or its type does not
/// declare the field, or the field cannot hold the value. Numbers beyond its range are clamped.
int set_field(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const wire::FieldId id = field_argument(lua, 2);
    const wire::FieldValue value = value_argument(lua, 3);
    return push_done(lua, context.set_field(entity, id, value) != wire::FieldOutcome::kRefused);
}

/// set_stance(entity, name)
int set_stance(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const EntityId entity = entity_argument(lua, 1);
    const auto stance = context.stance_named(name_argument(lua, 2, "stance"));
    luaL_argcheck(lua, stance.has_value(), 2, "stance: the world has none of that name");
    const world::Row row = owned_row(lua, entity);
    if (row != world::kNoRow &&
        context.entities().stance[row] != static_cast<std::uint8_t>(*stance)) {
        context.set_stance(entity, *stance);
    }
    return push_done(lua, row != world::kNoRow);
}

/// emit(system, x, y, z, vx, vy, vz, count)
int emit(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const std::int64_t count = integer_argument(lua, 8, "count", 1, kMaxParticles);
    Interpreter::charge(lua, static_cast<std::size_t>(count));
    return push_done(lua,
                     context.emit(name_argument(lua, 1, "system"),
                                  position_argument(lua, 2),
                                  velocity_argument(lua, 5),
                                  static_cast<std::uint32_t>(count)));
}

/// set_door(name, open, ahead_s)
int set_door(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    return push_done(
        lua,
        context.set_door(name_argument(lua, 1, "name"),
                         truth_argument(lua, 2, "open"),
                         static_cast<double>(number_argument(lua, 3, "ahead_s", 1e6F))));
}

/// move_platform(name, stop, ahead_s)
int move_platform(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    const lua_Integer stop = luaL_checkinteger(lua, 2);
    luaL_argcheck(lua, stop >= 0 && stop < 64, 2, "stop: 0 to 63");
    return push_done(
        lua,
        context.move_platform(name_argument(lua, 1, "name"),
                              static_cast<std::uint32_t>(stop),
                              static_cast<double>(number_argument(lua, 3, "ahead_s", 1e6F))));
}

/// set_clock_rate(name, rate_per_s, ahead_s)
int set_clock_rate(lua_State* lua) {
    zone::RulesContext& context = changing(lua);
    return push_done(
        lua,
        context.set_clock_rate(name_argument(lua, 1, "name"),
                               static_cast<double>(number_argument(lua, 2, "rate_per_s", 1e6F)),
                               static_cast<double>(number_argument(lua, 3, "ahead_s", 1e6F))));
}

/// note_outcome(player_succeeded)
int note_outcome(lua_State* lua) {
    changing(lua).note_outcome(truth_argument(lua, 1, "player_succeeded"));
    return 0;
}

/// keep_awake(seconds): on_tick is called until then, although nobody is here.
int keep_awake(lua_State* lua) {
    const zone::RulesContext& context = changing(lua);
    const float seconds = number_argument(lua, 1, "seconds", 1e6F);
    const auto ticks = static_cast<Tick>(std::ceil(std::max(seconds, 0.0F) / context.dt()));
    Tick& until = Host::of(lua).awake_until;
    until = std::max(until, context.now() + ticks);
    return 0;
}

}  // namespace

void open_actions(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"spawn", spawn_of_type},
                                       {"despawn", guarded<despawn>},
                                       {"teleport", teleport},
                                       {"add_velocity", add_velocity},
                                       {"hide", hide},
                                       {"show", show},
                                       {"set_appearance", set_appearance},
                                       {"set_field", set_field},
                                       {"set_stance", set_stance},
                                       {"emit", emit},
                                       {"set_clock_rate", set_clock_rate},
                                       {"set_door", set_door},
                                       {"move_platform", move_platform},
                                       {"note_outcome", note_outcome},
                                       {"keep_awake", keep_awake},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
