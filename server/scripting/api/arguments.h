// arguments: reads what a script passes, and says which argument of which function is wrong.
#pragma once

#include "server/scripting/api/host.h"

#include <initializer_list>
#include <span>
#include <string_view>

namespace zoned::scripting {

/// Wraps a function of the host so that what C++ throws becomes an error of the script.
template <int (*Function)(lua_State*)>
int guarded(lua_State* lua) {
    try {
        return Function(lua);
    } catch (const StateIsFull&) {
        return luaL_error(lua, "state takes more than script.state_mb");
    }
}

/// Throws the error "bad argument #2 to 'near' (radius: a number is wanted, not nil)".
[[noreturn]] void refuse(lua_State* lua, int index, const char* name, const char* wanted);

/// Finite, and no larger than `most` either way.
float number_argument(lua_State* lua, int index, const char* name, float most);
std::int64_t integer_argument(lua_State* lua,
                              int index,
                              const char* name,
                              std::int64_t least,
                              std::int64_t most);
bool truth_argument(lua_State* lua, int index, const char* name);
std::string_view text_argument(lua_State* lua, int index, const char* name, std::size_t most);
/// UTF-8 without control characters, not empty.
std::string_view name_argument(lua_State* lua, int index, const char* name);

/// The name of a declared field: an error where no type of the world declares it.
wire::FieldId field_argument(lua_State* lua, int index);
/// A number, a boolean or a text; the text is good while it stays on the stack.
wire::FieldValue value_argument(lua_State* lua, int index);

/// Three numbers from an index on.
Vec3 vector_argument(lua_State* lua, int index, const char* name, float most);
/// Zone-local, m.
Vec3 position_argument(lua_State* lua, int index);
/// m/s
Vec3 velocity_argument(lua_State* lua, int index);
/// Of unit length.
Vec3 direction_argument(lua_State* lua, int index);

/// Nil is nobody.
EntityId entity_argument(lua_State* lua, int index, const char* name = "entity");
ClientId client_argument(lua_State* lua, int index);

/// kNoRow where the zone does not know of the entity.
world::Row known_row(lua_State* lua, EntityId entity);
/// kNoRow where the zone does not own it, too.
world::Row owned_row(lua_State* lua, EntityId entity);

void push_vector(lua_State* lua, const Vec3& vector);
/// Nil for nobody.
void push_entity(lua_State* lua, EntityId entity);
void push_text(lua_State* lua, std::string_view text);
/// Into the table at the top of the stack.
void set_text(lua_State* lua, const char* field, std::string_view text);
/// The one result of functions that say whether they did something.
int push_done(lua_State* lua, bool was_done);

/// The fields of the table at an index are among these names; a wrong word is an error.
void check_fields(lua_State* lua, int index, std::span<const std::string_view> names);
void check_fields(lua_State* lua, int index, std::initializer_list<std::string_view> names);

/// Calls read(index of the value) where the table at `options` holds something under the name.
template <class Read>
void read_option(lua_State* lua, int options, const char* name, Read&& read) {
    if (lua_getfield(lua, options, name) != LUA_TNIL) {
        read(lua_gettop(lua));
    }
    lua_pop(lua, 1);
}

}  // namespace zoned::scripting
