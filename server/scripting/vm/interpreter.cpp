#include "server/scripting/vm/interpreter.h"

#include <new>

namespace zoned::scripting {

namespace {

/// Instructions between two looks at the budget.
constexpr int kStride = 1000;
/// A call that ends before the first look costs this much of the tick's budget.
constexpr std::int64_t kCallInstructions = 100;
constexpr int kTracebackSkips = 1;  // the handler itself

const char* text_of(ScriptOverrun overrun) {
    switch (overrun) {
        case ScriptOverrun::kInstructions:
            return "the call takes more instructions than script.instructions_per_call";
        case ScriptOverrun::kWork:
            return "the call makes the server work more than script.instructions_per_call";
        case ScriptOverrun::kMemory:
            return "more memory than script.memory_mb";
        case ScriptOverrun::kText:
            return "a string longer than 64 KiB";
        case ScriptOverrun::kValues:
            return "more than 250 values as '...'";
        case ScriptOverrun::kNone:
            break;
    }
    return "the call overran";
}

void on_stride(lua_State* lua, lua_Debug* at) {
    Budget& budget = Interpreter::of(lua).budget();
    budget.call_instructions -= kStride;
    budget.tick_instructions -= kStride;
    if (budget.call_instructions < kStride) {
        budget.flag(ScriptOverrun::kInstructions);
    }
    if (lua_getlocal(lua, at, -kMaxVarargs - 1) != nullptr) {
        budget.flag(ScriptOverrun::kValues);
    }
    if (budget.overrun != ScriptOverrun::kNone) {
        lua_sethook(lua, on_stride, LUA_MASKCOUNT, 1);  // whatever runs next ends as well
        Interpreter::raise_overrun(lua);
    }
}

/// Puts the traceback behind the error's text.
int add_traceback(lua_State* lua) {
    Interpreter::of(lua).budget().reporting = true;
    const char* text = lua_tostring(lua, 1);
    luaL_traceback(lua, lua, text != nullptr ? text : "an error that is no text", kTracebackSkips);
    return 1;
}

/// Only what runs outside of a call, which allocates nothing, could get here.
int on_panic(lua_State* /*lua*/) {
    throw std::bad_alloc();
}

ScriptError split(const std::string& report) {
    const std::size_t end = report.find("\nstack traceback:\n");
    if (end == std::string::npos) {
        return {report, {}};
    }
    return {report.substr(0, end), report.substr(end + 1)};
}

}  // namespace

Interpreter::Interpreter(std::size_t memory_bytes, void* owner) : owner_(owner) {
    budget_.memory_most = memory_bytes;
    lua_ = lua_newstate(limited_alloc, &budget_);
    if (lua_ == nullptr) {
        throw std::bad_alloc();
    }
    budget_.lua = lua_;
    *static_cast<Interpreter**>(lua_getextraspace(lua_)) = this;
    lua_atpanic(lua_, on_panic);
}

Interpreter::~Interpreter() {
    budget_.begin_call(0);
    budget_.reporting = true;
    lua_close(lua_);
}

void Interpreter::begin(std::int64_t instructions) {
    budget_.begin_call(instructions);
    budget_.tick_instructions -= kCallInstructions;
    lua_sethook(lua_, on_stride, LUA_MASKCOUNT, kStride);
    lua_settop(lua_, 0);
    lua_pushcfunction(lua_, add_traceback);
}

std::optional<ScriptError> Interpreter::finish(int status) {
    if (status == LUA_OK) {
        lua_settop(lua_, 0);
        return std::nullopt;
    }
    ScriptError error;
    if (status == LUA_ERRRUN && lua_isstring(lua_, -1) != 0) {
        error = split(lua_tostring(lua_, -1));
    }
    if (budget_.overrun != ScriptOverrun::kNone || status != LUA_ERRRUN) {
        const ScriptOverrun what =
            budget_.overrun != ScriptOverrun::kNone ? budget_.overrun : ScriptOverrun::kMemory;
        error.text = budget_.place.data() + std::string(": ") + text_of(what);
    }
    lua_settop(lua_, 0);
    if (budget_.memory_used > budget_.memory_most / 2) {
        lua_gc(lua_, LUA_GCCOLLECT);  // what the call left behind
    }
    return error;
}

void Interpreter::charge(lua_State* lua, std::size_t units) {
    Budget& budget = of(lua).budget();
    budget.call_work -= static_cast<std::int64_t>(units);
    if (budget.call_work < 0) {
        budget.flag(ScriptOverrun::kWork);
        raise_overrun(lua);
    }
}

void Interpreter::raise_overrun(lua_State* lua) {
    of(lua).budget().reporting = true;
    lua_pushstring(lua, "overrun");  // finish() says it better
    of(lua).budget().reporting = false;
    lua_error(lua);
    __builtin_unreachable();
}

}  // namespace zoned::scripting
