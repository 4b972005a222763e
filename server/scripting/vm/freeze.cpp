#include "server/scripting/vm/freeze.h"

#include "server/scripting/vm/bytecode.h"

#include <string>
#include <unordered_set>

namespace zoned::scripting {

namespace {

constexpr const char* kReadOnly =
    "the file's globals and tables are read-only once it has run: keep what changes in state";

int refuse_write(lua_State* lua) {
    return luaL_error(lua, kReadOnly);
}

int refuse_unknown(lua_State* lua) {
    return luaL_error(lua, "there is no global '%s'", luaL_tolstring(lua, 2, nullptr));
}

int frozen_length(lua_State* lua) {
    push_entries(lua, 1);
    lua_pushinteger(lua, static_cast<lua_Integer>(lua_rawlen(lua, -1)));
    return 1;
}

int append(lua_State* /*lua*/, const void* bytes, std::size_t count, void* to) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(bytes), count);
    return 0;
}

/// Raises the first finding about the function at the top of the stack.
void inspect(lua_State* lua, bool outlives) {
    std::string dump;
    lua_dump(lua, append, &dump, 0);
    const std::vector<BytecodeFinding> findings = inspect_bytecode(dump, outlives);
    if (!findings.empty()) {
        lua_Debug at{};
        lua_pushvalue(lua, -1);
        lua_getinfo(lua, ">S", &at);
        lua_pushfstring(lua, "%s:%d: %s", at.short_src, findings[0].line, findings[0].text.c_str());
        lua_error(lua);
    }
}

/// Goes through everything that functions of the file can reach.
class Freezer {
  public:
    explicit Freezer(lua_State* lua) : lua_(lua) {}

    /// The value at the top of the stack; it stays there.
    void visit() {
        luaL_checkstack(lua_, 8, "tables lie too deep");
        if (lua_istable(lua_, -1)) {
            if (seen_.insert(lua_topointer(lua_, -1)).second) {
                freeze();
            }
        } else if (lua_isfunction(lua_, -1) && lua_iscfunction(lua_, -1) == 0) {
            if (seen_.insert(lua_topointer(lua_, -1)).second) {
                inspect(lua_, true);
                for (int i = 1; lua_getupvalue(lua_, -1, i) != nullptr; ++i) {
                    visit();
                    lua_pop(lua_, 1);
                }
            }
        }
    }

  private:
    /// Moves the entries into a table behind it, which only reads reach.
    void freeze() {
        const int table = lua_gettop(lua_);
        lua_newtable(lua_);
        const int entries = table + 1;
        for (lua_pushnil(lua_); lua_next(lua_, table) != 0;) {
            visit();
            lua_pushvalue(lua_, -2);
            lua_insert(lua_, -2);
            lua_rawset(lua_, entries);
        }
        for (lua_pushnil(lua_); lua_next(lua_, entries) != 0;) {
            lua_pop(lua_, 1);
            lua_pushvalue(lua_, -1);
            lua_pushnil(lua_);
            lua_rawset(lua_, table);
        }
        lua_createtable(lua_, 0, 3);
        lua_pushvalue(lua_, entries);
        lua_setfield(lua_, -2, "__index");
        lua_pushcfunction(lua_, refuse_write);
        lua_setfield(lua_, -2, "__newindex");
        lua_pushcfunction(lua_, frozen_length);
        lua_setfield(lua_, -2, "__len");
        lua_setmetatable(lua_, table);
        lua_settop(lua_, table);
    }

    lua_State* lua_;
    std::unordered_set<const void*> seen_;
};

}  // namespace

bool is_frozen(lua_State* lua, int table) {
    if (luaL_getmetafield(lua, table, "__index") == LUA_TNIL) {
        return false;
    }
    lua_pop(lua, 1);
    return true;
}

void push_entries(lua_State* lua, int table) {
    lua_pushvalue(lua, table);
    if (luaL_getmetafield(lua, -1, "__index") != LUA_TNIL) {
        lua_remove(lua, -2);
    }
}

void refuse_powers(lua_State* lua) {
    inspect(lua, false);
}

void freeze_globals(lua_State* lua) {
    const int globals = lua_gettop(lua);
    Freezer freezer(lua);
    freezer.visit();
    push_entries(lua, globals);
    lua_createtable(lua, 0, 1);
    lua_pushcfunction(lua, refuse_unknown);
    lua_setfield(lua, -2, "__index");
    lua_setmetatable(lua, -2);
    lua_settop(lua, globals);
}

}  // namespace zoned::scripting
