// LoadedScript: a script whose file has run, ready to be called.
#pragma once

#include "server/scripting/api/host.h"
#include "server/scripting/callbacks.h"
#include "server/scripting/script_settings.h"
#include "server/scripting/vm/interpreter.h"

#include <array>
#include <optional>
#include <vector>

namespace zoned::scripting {

class LoadedScript {
  public:
    /// Compiles the source and runs it, which may take as many instructions as a tick may. Throws
    /// std::runtime_error with file and line of the mistake. `host` must outlive the script.
    LoadedScript(const ScriptSettings& settings,
                 const zone::RulesSettings& rules,
                 const world::TypeTable& types,
                 Host& host);

    [[nodiscard]] bool has(Callback callback) const {
        return functions_[static_cast<std::size_t>(callback)] != LUA_NOREF;
    }

    [[nodiscard]] Budget& budget() { return interpreter_.budget(); }

    /// The callback with the arguments that push(lua) pushes, whose number it returns, and
    /// take(lua) with its result on the stack.
    template <class Push, class Take>
    std::optional<ScriptError> call(Callback callback,
                                    std::int64_t instructions,
                                    Push&& push,
                                    Take&& take) {
        return interpreter_.run(instructions, [&](lua_State* lua) {
            lua_rawgeti(lua, LUA_REGISTRYINDEX, functions_[static_cast<std::size_t>(callback)]);
            const int arguments = push(lua);
            lua_call(lua, arguments, 1);
            take(lua);
        });
    }

    /// The entry of a type in the script's table `contact_wish`.
    [[nodiscard]] zone::ContactWish contact_wish(TypeIndex type) const { return wishes_[type]; }

    /// The script's table `fields`.
    [[nodiscard]] const std::vector<zone::TypeField>& fields() const { return fields_; }

  private:
    void run_file(lua_State* lua, const ScriptSettings& settings, const zone::RulesSettings& rules);
    void find_callbacks(lua_State* lua);
    void read_wishes(lua_State* lua, const world::TypeTable& types);

    Interpreter interpreter_;
    std::array<int, kCallbacks> functions_{};  // in Lua's registry
    std::vector<zone::ContactWish> wishes_;    // by type
    std::vector<zone::TypeField> fields_;
};

}  // namespace zoned::scripting
