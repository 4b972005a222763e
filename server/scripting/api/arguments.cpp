#include "server/scripting/api/arguments.h"

#include "shared/core/utf8.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::scripting {

namespace {

constexpr float kMaxPosition = 100'000.0F;
constexpr float kMaxVelocity = 1'000.0F;
constexpr std::size_t kMaxNameBytes = 64;

template <class Id>
Id id_argument(lua_State* lua, int index, const char* name) {
    if (lua_isnoneornil(lua, index)) {
        return {};
    }
    return Id(static_cast<std::uint32_t>(
        integer_argument(lua, index, name, 0, std::numeric_limits<std::uint32_t>::max())));
}

}  // namespace

zone::RulesContext& reading(lua_State* lua) {
    zone::RulesContext* const context = Host::of(lua).context;
    if (context == nullptr) {
        luaL_error(lua, "the world is not there yet while the file runs: use on_start");
    }
    return *context;
}

zone::RulesContext& changing(lua_State* lua) {
    zone::RulesContext& context = reading(lua);
    if (!Host::of(lua).may_change) {
        luaL_error(lua, "may_hear and on_stop change nothing");
    }
    return context;
}

void refuse(lua_State* lua, int index, const char* name, const char* wanted) {
    luaL_argerror(
        lua,
        index,
        lua_pushfstring(lua, "%s: %s is wanted, not %s", name, wanted, luaL_typename(lua, index)));
    __builtin_unreachable();
}

float number_argument(lua_State* lua, int index, const char* name, float most) {
    if (lua_type(lua, index) != LUA_TNUMBER) {
        refuse(lua, index, name, "a number");
    }
    const lua_Number number = lua_tonumber(lua, index);
    if (!(std::abs(number) <= static_cast<lua_Number>(most))) {
        luaL_argerror(lua,
                      index,
                      lua_pushfstring(lua,
                                      "%s: a finite number up to %f is wanted",
                                      name,
                                      static_cast<lua_Number>(most)));
    }
    return static_cast<float>(number);
}

std::int64_t integer_argument(lua_State* lua,
                              int index,
                              const char* name,
                              std::int64_t least,
                              std::int64_t most) {
    int is_integer = 0;
    const lua_Integer number =
        lua_type(lua, index) == LUA_TNUMBER ? lua_tointegerx(lua, index, &is_integer) : 0;
    if (is_integer == 0) {
        refuse(lua, index, name, "an integer");
    }
    if (number < least || number > most) {
        luaL_argerror(lua,
                      index,
                      lua_pushfstring(lua,
                                      "%s: an integer from %I to %I is wanted",
                                      name,
                                      static_cast<LUAI_UACINT>(least),
                                      static_cast<LUAI_UACINT>(most)));
    }
    return number;
}

bool truth_argument(lua_State* lua, int index, const char* name) {
    if (!lua_isboolean(lua, index)) {
        refuse(lua, index, name, "true or false");
    }
    return lua_toboolean(lua, index) != 0;
}

std::string_view text_argument(lua_State* lua, int index, const char* name, std::size_t most) {
    if (lua_type(lua, index) != LUA_TSTRING) {
        refuse(lua, index, name, "a string");
    }
    std::size_t length = 0;
    const char* text = lua_tolstring(lua, index, &length);
    if (length > most) {
        luaL_argerror(
            lua,
            index,
            lua_pushfstring(
                lua, "%s: at most %I bytes are wanted", name, static_cast<LUAI_UACINT>(most)));
    }
    return {text, length};
}

std::string_view name_argument(lua_State* lua, int index, const char* name) {
    const std::string_view text = text_argument(lua, index, name, kMaxNameBytes);
    if (text.empty() || !core::is_clean_utf8(text)) {
        luaL_argerror(
            lua, index, lua_pushfstring(lua, "%s: readable text is wanted, not empty", name));
    }
    return text;
}

wire::FieldId field_argument(lua_State* lua, int index) {
    const auto id = reading(lua).field_named(name_argument(lua, index, "field"));
    luaL_argcheck(lua, id.has_value(), index, "field: no type declares one of that name");
    return *id;
}

wire::FieldValue value_argument(lua_State* lua, int index) {
    switch (lua_type(lua, index)) {
        case LUA_TBOOLEAN:
            return lua_toboolean(lua, index) != 0;
        case LUA_TNUMBER:
            return static_cast<double>(lua_tonumber(lua, index));
        case LUA_TSTRING:
            return text_argument(lua, index, "value", 255);
        default:
            break;
    }
    refuse(lua, index, "value", "a number, true, false or a string");
}

Vec3 vector_argument(lua_State* lua, int index, const char* name, float most) {
    return {number_argument(lua, index, name, most),
            number_argument(lua, index + 1, name, most),
            number_argument(lua, index + 2, name, most)};
}

Vec3 position_argument(lua_State* lua, int index) {
    return vector_argument(lua, index, "position", kMaxPosition);
}

Vec3 velocity_argument(lua_State* lua, int index) {
    return vector_argument(lua, index, "velocity", kMaxVelocity);
}

Vec3 direction_argument(lua_State* lua, int index) {
    const Vec3 direction = vector_argument(lua, index, "direction", 1e6F);
    const float length = direction.norm();
    luaL_argcheck(lua, length > 1e-6F, index, "direction: it has no length");
    return direction / length;
}

EntityId entity_argument(lua_State* lua, int index, const char* name) {
    return id_argument<EntityId>(lua, index, name);
}

ClientId client_argument(lua_State* lua, int index) {
    return id_argument<ClientId>(lua, index, "client");
}

world::Row known_row(lua_State* lua, EntityId entity) {
    return reading(lua).entities().find(entity);
}

world::Row owned_row(lua_State* lua, EntityId entity) {
    const world::Row row = known_row(lua, entity);
    const bool ghost = row != world::kNoRow && reading(lua).entities().has(row, world::kGhost);
    return ghost ? world::kNoRow : row;
}

void push_vector(lua_State* lua, const Vec3& vector) {
    for (int axis = 0; axis < 3; ++axis) {
        lua_pushnumber(lua, static_cast<lua_Number>(vector[axis]));
    }
}

void push_entity(lua_State* lua, EntityId entity) {
    if (entity) {
        lua_pushinteger(lua, entity.value);
    } else {
        lua_pushnil(lua);
    }
}

void push_text(lua_State* lua, std::string_view text) {
    lua_pushlstring(lua, text.data(), text.size());
}

void set_text(lua_State* lua, const char* field, std::string_view text) {
    push_text(lua, text);
    lua_setfield(lua, -2, field);
}

int push_done(lua_State* lua, bool was_done) {
    lua_pushboolean(lua, was_done ? 1 : 0);
    return 1;
}

void check_fields(lua_State* lua, int index, std::initializer_list<std::string_view> names) {
    check_fields(lua, index, std::span(names.begin(), names.size()));
}

void check_fields(lua_State* lua, int index, std::span<const std::string_view> names) {
    luaL_checktype(lua, index, LUA_TTABLE);
    for (lua_pushnil(lua); lua_next(lua, index) != 0; lua_pop(lua, 1)) {
        std::size_t length = 0;
        const char* text = lua_type(lua, -2) == LUA_TSTRING ? lua_tolstring(lua, -2, &length) : "";
        if (std::find(names.begin(), names.end(), std::string_view(text, length)) == names.end()) {
            luaL_argerror(lua, index, lua_pushfstring(lua, "it has no setting '%s'", text));
        }
    }
}

}  // namespace zoned::scripting
