#include "server/scripting/api/arguments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>

namespace zoned::scripting {

namespace {

constexpr float kMaxRadius = 10'000.0F;
constexpr std::int64_t kMaxTick = std::int64_t{1} << 53U;
constexpr lua_Integer kMostSeen = 8;
constexpr int kHitResults = 8;
// About what these cost, in instructions.
constexpr std::size_t kRayUnits = 100;
constexpr std::size_t kNearUnits = 50;
constexpr std::size_t kParticleUnits = 2'000;

/// Calls push(entities, row) for the entity that the first argument names; nil where the zone does
/// not know of it.
template <class Push>
int about_entity(lua_State* lua, Push&& push) {
    const world::Row row = known_row(lua, entity_argument(lua, 1));
    if (row == world::kNoRow) {
        lua_pushnil(lua);
        return 1;
    }
    return push(reading(lua).entities(), row);
}

/// entity_named(name): the entity that the config placed under this name; nil where there is none.
int entity_named(lua_State* lua) {
    push_entity(lua, reading(lua).entity_named(name_argument(lua, 1, "name")));
    return 1;
}

template <world::EntityFlag Flag>
int has_flag(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        lua_pushboolean(lua, entities.has(row, Flag) ? 1 : 0);
        return 1;
    });
}

int now(lua_State* lua) {
    lua_pushinteger(lua, reading(lua).now());
    return 1;
}

int tick_seconds(lua_State* lua) {
    lua_pushnumber(lua, static_cast<lua_Number>(reading(lua).dt()));
    return 1;
}

/// ticks(seconds): the number of ticks that last so long, at least one.
int ticks(lua_State* lua) {
    const float seconds = number_argument(lua, 1, "seconds", 1e6F);
    const auto count = static_cast<lua_Integer>(std::ceil(seconds / reading(lua).dt() - 1e-3F));
    lua_pushinteger(lua, std::max<lua_Integer>(count, 1));
    return 1;
}

int zone_number(lua_State* lua) {
    lua_pushinteger(lua, reading(lua).zone().value);
    return 1;
}

/// origin(): world coordinates of the zone's (0, 0, 0).
int origin(lua_State* lua) {
    const Vec3d at = reading(lua).origin();
    for (int axis = 0; axis < 3; ++axis) {
        lua_pushnumber(lua, at[axis]);
    }
    return 3;
}

int is_known(lua_State* lua) {
    lua_pushboolean(lua, known_row(lua, entity_argument(lua, 1)) != world::kNoRow ? 1 : 0);
    return 1;
}

int is_owned(lua_State* lua) {
    lua_pushboolean(lua, owned_row(lua, entity_argument(lua, 1)) != world::kNoRow ? 1 : 0);
    return 1;
}

int position(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        push_vector(lua, entities.position[row]);
        return 3;
    });
}

int velocity(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        push_vector(lua, entities.velocity[row]);
        return 3;
    });
}

/// orientation(entity): w, x, y, z
int orientation(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        const Quat& turned = entities.orientation[row];
        lua_pushnumber(lua, static_cast<lua_Number>(turned.w()));
        push_vector(lua, turned.vec());
        return 4;
    });
}

/// yaw(entity): 65536 a turn
int yaw(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        lua_pushinteger(lua, entities.yaw[row]);
        return 1;
    });
}

int type_of(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        push_text(lua, reading(lua).types()[entities.type[row]].name);
        return 1;
    });
}

int client_of(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        push_entity(lua, EntityId(entities.client[row].value));
        return 1;
    });
}

int appearance(lua_State* lua) {
    return about_entity(lua, [lua](const world::Entities& entities, world::Row row) {
        lua_pushinteger(lua, entities.appearance[row]);
        return 1;
    });
}

/// field(entity, name): a number, a boolean or a text; nil where the entity has no such field.
int field(lua_State* lua) {
    const zone::RulesContext& context = reading(lua);
    const EntityId entity = entity_argument(lua, 1);
    const auto value = context.field(entity, field_argument(lua, 2));
    if (!value) {
        lua_pushnil(lua);
    } else if (const auto* number = std::get_if<double>(&*value)) {
        lua_pushnumber(lua, static_cast<lua_Number>(*number));
    } else if (const auto* truth = std::get_if<bool>(&*value)) {
        lua_pushboolean(lua, *truth ? 1 : 0);
    } else {
        push_text(lua, std::get<std::string_view>(*value));
    }
    return 1;
}

void push_list(lua_State* lua, const std::vector<EntityId>& entities) {
    Interpreter::charge(lua, entities.size());
    lua_createtable(lua, static_cast<int>(entities.size()), 0);
    for (std::size_t i = 0; i < entities.size(); ++i) {
        lua_pushinteger(lua, entities[i].value);
        lua_rawseti(lua, -2, static_cast<lua_Integer>(i + 1));
    }
}

/// avatars(): those that this zone owns, ascending.
int avatars(lua_State* lua) {
    const world::Entities& entities = reading(lua).entities();
    std::vector<EntityId>& found = Host::of(lua).found;
    found.clear();
    const world::RowSet& rows = entities.avatars();
    for (world::Row row = rows.next(0); row != world::kNoRow; row = rows.next(row + 1)) {
        if (!entities.has(row, world::kGhost)) {
            found.push_back(entities.id[row]);
        }
    }
    std::sort(found.begin(), found.end());
    push_list(lua, found);
    return 1;
}

/// near(x, y, z, radius [, type]): a list of entities, ascending; ghosts too.
int near(lua_State* lua) {
    const Vec3 point = position_argument(lua, 1);
    const float radius = number_argument(lua, 4, "radius", kMaxRadius);
    luaL_argcheck(lua, radius >= 0.0F, 4, "radius: it is negative");
    Interpreter::charge(lua, kNearUnits);
    std::vector<EntityId>& found = Host::of(lua).found;
    found.clear();
    const zone::RulesContext& context = reading(lua);
    context.near(point, radius, found);
    if (!lua_isnoneornil(lua, 5)) {
        const std::string_view type = name_argument(lua, 5, "type");
        std::erase_if(found, [&](EntityId entity) {
            const world::Row row = context.entities().find(entity);
            return reading(lua).types()[context.entities().type[row]].name != type;
        });
    }
    push_list(lua, found);
    return 1;
}

/// inside(trigger): a list of the entities of this zone in it.
int inside(lua_State* lua) {
    std::vector<EntityId>& found = Host::of(lua).found;
    found.clear();
    Interpreter::charge(lua, kNearUnits);
    reading(lua).inside(name_argument(lua, 1, "trigger"), found);
    push_list(lua, found);
    return 1;
}

/// distance(a, b): m, nil where the zone does not know of both.
int distance(lua_State* lua) {
    const world::Row a = known_row(lua, entity_argument(lua, 1, "a"));
    const world::Row b = known_row(lua, entity_argument(lua, 2, "b"));
    if (a == world::kNoRow || b == world::kNoRow) {
        lua_pushnil(lua);
        return 1;
    }
    const world::Entities& entities = reading(lua).entities();
    lua_pushnumber(lua,
                   static_cast<lua_Number>((entities.position[a] - entities.position[b]).norm()));
    return 1;
}

/// distance, entity (nil: the static world), point, normal; nil: nothing was hit.
int push_hit(lua_State* lua, const zone::RayResult& hit) {
    if (!hit.hit) {
        lua_pushnil(lua);
        return 1;
    }
    lua_pushnumber(lua, static_cast<lua_Number>(hit.distance));
    push_entity(lua, hit.entity);
    push_vector(lua, hit.point);
    push_vector(lua, hit.normal);
    return kHitResults;
}

/// ray_cast(x, y, z, dx, dy, dz, max_distance [, ignore])
int ray_cast(lua_State* lua) {
    Interpreter::charge(lua, kRayUnits);
    return push_hit(lua,
                    reading(lua).ray_cast(position_argument(lua, 1),
                                          direction_argument(lua, 4),
                                          number_argument(lua, 7, "max_distance", kMaxRadius),
                                          entity_argument(lua, 8, "ignore")));
}

/// { entity =, x =, y =, z = [, publication =] }, zone-local.
zone::SeenEntity seen_entity_argument(lua_State* lua, int index) {
    check_fields(lua, index, {"entity", "x", "y", "z", "publication"});
    zone::SeenEntity seen;
    lua_getfield(lua, index, "entity");
    seen.entity = entity_argument(lua, -1);
    lua_getfield(lua, index, "x");
    lua_getfield(lua, index, "y");
    lua_getfield(lua, index, "z");
    seen.position = position_argument(lua, lua_gettop(lua) - 2);
    read_option(lua, index, "publication", [&](int at) {
        seen.publication = integer_argument(lua, at, "publication", -1, kMaxTick);
    });
    lua_pop(lua, 4);
    return seen;
}

/// The entities that a client says it displayed near the ray, into the host's scratch.
void read_seen_entities(lua_State* lua, int list) {
    std::vector<zone::SeenEntity>& seen = Host::of(lua).seen;
    luaL_checktype(lua, list, LUA_TTABLE);
    const lua_Integer count = luaL_len(lua, list);
    luaL_argcheck(lua, count <= kMostSeen, list, "entities: at most 8 are wanted");
    for (lua_Integer i = 1; i <= count; ++i) {
        lua_geti(lua, list, i);
        seen.push_back(seen_entity_argument(lua, lua_gettop(lua)));
        lua_pop(lua, 1);
    }
}

/// The display that a client claims to have seen:
/// { tick = [, fraction =, past =, aimed =, entities = { { entity =, x =, y =, z = }, ... }] }.
zone::Seen seen_argument(lua_State* lua, int index) {
    check_fields(lua, index, {"tick", "fraction", "past", "aimed", "entities"});
    zone::Seen seen;
    Host::of(lua).seen.clear();
    read_option(lua, index, "entities", [&](int at) { read_seen_entities(lua, at); });
    seen.entities = Host::of(lua).seen;
    lua_getfield(lua, index, "tick");
    seen.tick = integer_argument(lua, -1, "tick", -1, kMaxTick);
    lua_getfield(lua, index, "fraction");
    seen.fraction = lua_isnil(lua, -1)
                        ? 0.0F
                        : std::clamp(number_argument(lua, -1, "fraction", 1.0F), 0.0F, 1.0F);
    lua_getfield(lua, index, "past");
    seen.view = lua_toboolean(lua, -1) != 0 ? zone::Seen::DisplayedTime::kPast
                                            : zone::Seen::DisplayedTime::kPresent;
    lua_getfield(lua, index, "aimed");
    seen.aimed = entity_argument(lua, -1, "aimed");
    lua_pop(lua, 4);
    return seen;
}

/// ray_cast_as_seen(client, seen, x, y, z, dx, dy, dz, max_distance [, ignore]): the eight results
/// of ray_cast, all nil where nothing is hit, and { rewound_s =, cut =, doubted =, aimed_near = }.
int ray_cast_as_seen(lua_State* lua) {
    Interpreter::charge(lua, kRayUnits);
    const ClientId client = client_argument(lua, 1);
    const zone::Seen seen = seen_argument(lua, 2);
    const zone::SeenHit hit =
        reading(lua).ray_cast_as_seen(client,
                                      seen,
                                      position_argument(lua, 3),
                                      direction_argument(lua, 6),
                                      number_argument(lua, 9, "max_distance", kMaxRadius),
                                      entity_argument(lua, 10, "ignore"));
    const int top = lua_gettop(lua);
    push_hit(lua, hit);
    lua_settop(lua, top + kHitResults);
    lua_createtable(lua, 0, 4);
    lua_pushnumber(lua, static_cast<lua_Number>(hit.rewound_s));
    lua_setfield(lua, -2, "rewound_s");
    const std::pair<const char*, bool> flags[] = {
        {"cut", hit.cut}, {"doubted", hit.doubted}, {"aimed_near", hit.aimed_near}};
    for (const auto& [name, value] : flags) {
        lua_pushboolean(lua, value ? 1 : 0);
        lua_setfield(lua, -2, name);
    }
    return kHitResults + 1;
}

/// position_after(entity, tick)
int position_after(lua_State* lua) {
    const EntityId entity = entity_argument(lua, 1);
    const std::int64_t tick = integer_argument(lua, 2, "tick", 0, kMaxTick);
    const std::optional<Vec3> at = reading(lua).position_after(entity, tick);
    if (!at) {
        lua_pushnil(lua);
        return 1;
    }
    push_vector(lua, *at);
    return 3;
}

/// shared_value(name): of a shared clock or variable.
int shared_value(lua_State* lua) {
    const std::optional<double> value = reading(lua).shared_value(name_argument(lua, 1, "name"));
    if (value) {
        lua_pushnumber(lua, *value);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// door_open(name): of a door that rules move; nil where there is none.
int door_open(lua_State* lua) {
    const std::optional<bool> open = reading(lua).door_open(name_argument(lua, 1, "name"));
    if (open) {
        lua_pushboolean(lua, *open ? 1 : 0);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// platform_stop(name): of a platform that rules move; nil while it travels.
int platform_stop(lua_State* lua) {
    const std::optional<std::uint32_t> stop =
        reading(lua).platform_stop(name_argument(lua, 1, "name"));
    if (stop) {
        lua_pushinteger(lua, *stop);
    } else {
        lua_pushnil(lua);
    }
    return 1;
}

/// particles_near(system, x, y, z, radius)
int particles_near(lua_State* lua) {
    Interpreter::charge(lua, kParticleUnits);
    lua_pushinteger(lua,
                    reading(lua).particles_near(name_argument(lua, 1, "system"),
                                                position_argument(lua, 2),
                                                number_argument(lua, 5, "radius", kMaxRadius)));
    return 1;
}

/// math.random(), math.random(most), math.random(least, most): of the zone.
int random(lua_State* lua) {
    core::Rng& rng = changing(lua).rng();
    if (lua_gettop(lua) == 0) {
        lua_pushnumber(lua, static_cast<lua_Number>(rng.unit()));
        return 1;
    }
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
    const bool both = lua_gettop(lua) > 1;
    const std::int64_t least = both ? integer_argument(lua, 1, "least", -kMost, kMost) : 1;
    const std::int64_t most = integer_argument(lua, both ? 2 : 1, "most", least, kMost);
    lua_pushinteger(lua, least + rng.below(static_cast<std::uint32_t>(most - least + 1)));
    return 1;
}

}  // namespace

void open_queries(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"now", now},
                                       {"tick_seconds", tick_seconds},
                                       {"ticks", ticks},
                                       {"zone", zone_number},
                                       {"origin", origin},
                                       {"entity_named", entity_named},
                                       {"is_known", is_known},
                                       {"is_owned", is_owned},
                                       {"is_hidden", has_flag<world::kHidden>},
                                       {"is_at_rest", has_flag<world::kAtRest>},
                                       {"is_grounded", has_flag<world::kGrounded>},
                                       {"is_carried", has_flag<world::kCarried>},
                                       {"position", position},
                                       {"velocity", velocity},
                                       {"orientation", orientation},
                                       {"yaw", yaw},
                                       {"type_of", type_of},
                                       {"client_of", client_of},
                                       {"appearance", appearance},
                                       {"field", field},
                                       {"avatars", avatars},
                                       {"near", near},
                                       {"inside", inside},
                                       {"distance", distance},
                                       {"ray_cast", ray_cast},
                                       {"ray_cast_as_seen", ray_cast_as_seen},
                                       {"position_after", position_after},
                                       {"shared_value", shared_value},
                                       {"door_open", door_open},
                                       {"platform_stop", platform_stop},
                                       {"particles_near", particles_near},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
    lua_getfield(lua, -1, LUA_MATHLIBNAME);
    lua_pushcfunction(lua, random);
    lua_setfield(lua, -2, "random");
    lua_pop(lua, 1);
}

}  // namespace zoned::scripting
