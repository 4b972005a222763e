// Interpreter: one Lua state behind its budget. Whatever a script does, a call comes back.
#pragma once

#include "server/scripting/vm/budget.h"

#include <lua.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace zoned::scripting {

/// Why a call ended early.
struct ScriptError {
    std::string text;       ///< "game.lua:12: what went wrong"
    std::string traceback;  ///< the calls that led there, a line each
};

/// Nothing of a state outlives a call but its functions and what they read; so a fresh one goes on
/// where another left off.
class Interpreter {
  public:
    /// `owner` is what functions of the host are about.
    Interpreter(std::size_t memory_bytes, void* owner);
    ~Interpreter();
    Interpreter(const Interpreter&) = delete;
    Interpreter& operator=(const Interpreter&) = delete;

    [[nodiscard]] static Interpreter& of(lua_State* lua) {
        return **static_cast<Interpreter**>(lua_getextraspace(lua));
    }

    [[nodiscard]] lua_State* lua() { return lua_; }

    [[nodiscard]] void* owner() const { return owner_; }

    [[nodiscard]] Budget& budget() { return budget_; }

    /// Runs work(lua) on an empty stack within so many instructions. Errors, overruns and lack of
    /// memory end it. Everything that may touch the state happens in such a call.
    template <class Work>
    std::optional<ScriptError> run(std::int64_t instructions, Work&& work) {
        begin(instructions);
        lua_pushcfunction(lua_, &trampoline<Work>);
        lua_pushlightuserdata(lua_, &work);
        return finish(lua_pcall(lua_, 1, 0, 1));
    }

    /// Counts work that no instruction stands for; ends the call when there was too much.
    static void charge(lua_State* lua, std::size_t units);

    /// The error that the overrun stands for, which no pcall of a script keeps.
    [[noreturn]] static void raise_overrun(lua_State* lua);

  private:
    template <class Work>
    static int trampoline(lua_State* lua) {
        auto& work = *static_cast<std::remove_reference_t<Work>*>(lua_touserdata(lua, 1));
        lua_settop(lua, 0);
        work(lua);
        return 0;
    }

    void begin(std::int64_t instructions);
    std::optional<ScriptError> finish(int status);

    Budget budget_;
    void* owner_;
    lua_State* lua_;
};

}  // namespace zoned::scripting
