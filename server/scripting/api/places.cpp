// Functions that read places of the config: spawn points, and entities by type.
#include "server/scripting/api/arguments.h"

#include <algorithm>
#include <vector>

namespace zoned::scripting {

namespace {

// About what these cost, in instructions.
constexpr std::size_t kUnitsPerPoint = 10;
constexpr std::size_t kUnitsPerRow = 1;
constexpr std::size_t kTypeUnits = 20;

/// An optional text; nil is the empty one.
std::string_view optional_text(lua_State* lua, int index, const char* name) {
    return lua_isnoneornil(lua, index) ? std::string_view() : name_argument(lua, index, name);
}

/// Its place in coordinates of the zone.
Vec3 place_of(const zone::RulesContext& context, const zone::SpawnPoint& point) {
    return context.local(point.position);
}

/// spawn_points(team): { { name, team, x, y, z }, ... }; nil: of all teams and of none.
int spawn_points(lua_State* lua) {
    const zone::RulesContext& context = reading(lua);
    const bool all = lua_isnoneornil(lua, 1);
    const std::string_view team = optional_text(lua, 1, "team");
    Interpreter::charge(lua, kUnitsPerPoint * context.spawn_points().size());
    lua_newtable(lua);
    lua_Integer count = 0;
    for (const zone::SpawnPoint& point : context.spawn_points()) {
        if (!all && point.team != team) {
            continue;
        }
        lua_newtable(lua);
        set_text(lua, "name", point.name);
        set_text(lua, "team", point.team);
        const Vec3 at = place_of(context, point);
        constexpr const char* kAxes[] = {"x", "y", "z"};
        for (int axis = 0; axis < 3; ++axis) {
            lua_pushnumber(lua, static_cast<lua_Number>(at[axis]));
            lua_setfield(lua, -2, kAxes[axis]);
        }
        lua_rawseti(lua, -2, ++count);
    }
    return 1;
}

/// freest_spawn(team): x, y, z, name of the point that is farthest from all players.
int freest_spawn(lua_State* lua) {
    const zone::RulesContext& context = reading(lua);
    Interpreter::charge(lua,
                        kUnitsPerRow * context.entities().size() *
                            std::max<std::size_t>(1, context.spawn_points().size()));
    const zone::SpawnPoint* point = context.freest_spawn(optional_text(lua, 1, "team"));
    if (point == nullptr) {
        lua_pushnil(lua);
        return 1;
    }
    push_vector(lua, place_of(context, *point));
    push_text(lua, point->name);
    return 4;
}

/// entities(type): those of this zone, ascending, hidden ones too; nil: of all types.
int entities(lua_State* lua) {
    const zone::RulesContext& context = reading(lua);
    const world::Entities& e = context.entities();
    Interpreter::charge(lua, kUnitsPerRow * e.size());
    const std::string_view wanted = optional_text(lua, 1, "type");
    const world::TypeTable& types = context.types();
    const auto at = std::find_if(
        types.begin(), types.end(), [&](const world::EntityType& t) { return t.name == wanted; });
    luaL_argcheck(
        lua, wanted.empty() || at != types.end(), 1, "type: the world has none of that name");
    std::vector<EntityId>& found = Host::of(lua).found;
    found.clear();
    for (world::Row row = 0; row < e.size(); ++row) {
        if (!e.has(row, world::kGhost) &&
            (wanted.empty() || e.type[row] == static_cast<TypeIndex>(at - types.begin()))) {
            found.push_back(e.id[row]);
        }
    }
    std::sort(found.begin(), found.end());
    lua_createtable(lua, static_cast<int>(found.size()), 0);
    for (std::size_t i = 0; i < found.size(); ++i) {
        push_entity(lua, found[i]);
        lua_rawseti(lua, -2, static_cast<lua_Integer>(i + 1));
    }
    return 1;
}

/// stance(entity): its name; nil where the zone does not know of it.
int stance(lua_State* lua) {
    const world::Row row = known_row(lua, entity_argument(lua, 1));
    if (row == world::kNoRow) {
        lua_pushnil(lua);
        return 1;
    }
    const zone::RulesContext& context = reading(lua);
    push_text(lua, context.stance_name(static_cast<world::Stance>(context.entities().stance[row])));
    return 1;
}

void set_number(lua_State* lua, const char* field, float value) {
    lua_pushnumber(lua, static_cast<lua_Number>(value));
    lua_setfield(lua, -2, field);
}

/// type(name): its properties, in a table of its own; nil where the world has none of that name.
int type_properties(lua_State* lua) {
    const std::string_view name = name_argument(lua, 1, "type");
    Interpreter::charge(lua, kTypeUnits);
    const world::TypeTable& types = reading(lua).types();
    const auto at = std::find_if(
        types.begin(), types.end(), [&](const world::EntityType& t) { return t.name == name; });
    if (at == types.end()) {
        lua_pushnil(lua);
        return 1;
    }
    const bool walks = at->kind == world::EntityKind::kCharacter;
    const Vec3 size = 2.0F * at->half_size();
    lua_newtable(lua);
    set_text(lua, "name", at->name);
    set_text(lua, "kind", walks ? "character" : "prop");
    set_number(lua, "mass", at->mass);
    set_number(lua, "radius", at->extent());
    set_number(lua, "size_x", size.x());
    set_number(lua, "size_y", size.y());
    set_number(lua, "size_z", size.z());
    set_number(lua, "friction", at->friction);
    set_number(lua, "restitution", at->restitution);
    set_number(lua, "aura", at->aura_m[0]);
    set_number(lua, "nimbus", at->nimbus_m[0]);
    if (walks) {
        set_number(lua, "speed", at->character.speed);
        set_number(lua, "sprint_speed", at->character.speed * at->character.sprint_factor);
        set_number(lua, "acceleration", at->character.acceleration);
        set_number(lua, "jump_speed", at->character.jump_speed);
        set_number(lua, "step_up", at->character.step_up);
    }
    return 1;
}

}  // namespace

void open_places(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"spawn_points", spawn_points},
                                       {"freest_spawn", freest_spawn},
                                       {"entities", entities},
                                       {"stance", stance},
                                       {"type_properties", type_properties},
                                       {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting
