#include "server/scripting/vm/budget.h"

#include <lua.hpp>

#include <cstdio>
#include <cstdlib>

namespace zoned::scripting {

namespace {

// A report of an error is written when memory is short already.
constexpr std::size_t kReportBytes = 64U << 10U;
// Lua answers a refusal with a full collection; near the limit each allocation would cost one.
constexpr int kMostRefusals = 8;
// Copying a text is one instruction, whatever its length: longer ones count as work.
constexpr std::size_t kUncountedTextBytes = 1024;
constexpr std::size_t kTextBytesPerUnit = 64;
// Of Lua's own, in front of a text's bytes.
constexpr std::size_t kTextHeaderBytes = 64;

/// Whether a new text may be made.
bool takes_text(Budget& budget, std::size_t size) {
    if (size > kMaxTextBytes + kTextHeaderBytes) {
        budget.flag(ScriptOverrun::kText);
        return false;
    }
    if (size >= kUncountedTextBytes) {
        budget.call_work -= static_cast<std::int64_t>(size / kTextBytesPerUnit);
        if (budget.call_work < 0) {
            budget.flag(ScriptOverrun::kWork);
            return false;
        }
    }
    return true;
}

bool takes_memory(Budget& budget, std::size_t more) {
    const std::size_t most = budget.memory_most + (budget.reporting ? kReportBytes : 0);
    if (budget.memory_used + more <= most) {
        return true;
    }
    budget.note_place();
    if (++budget.memory_refusals > kMostRefusals) {
        budget.flag(ScriptOverrun::kMemory);
    }
    return false;
}

bool takes(Budget& budget, bool is_text, std::size_t new_size, std::size_t more) {
    if (budget.reporting) {
        return takes_memory(budget, more);
    }
    return budget.overrun == ScriptOverrun::kNone && (!is_text || takes_text(budget, new_size)) &&
           takes_memory(budget, more);
}

}  // namespace

void Budget::note_place() {
    lua_Debug at{};
    for (int level = 0; lua != nullptr && lua_getstack(lua, level, &at) != 0; ++level) {
        lua_getinfo(lua, "Sl", &at);
        if (at.currentline > 0) {
            std::snprintf(place.data(), place.size(), "%s:%d", at.short_src, at.currentline);
            return;
        }
    }
}

void* limited_alloc(void* owner, void* block, std::size_t old_size, std::size_t new_size) {
    Budget& budget = *static_cast<Budget*>(owner);
    const bool is_text = block == nullptr && old_size == LUA_TSTRING;
    const std::size_t before = block != nullptr ? old_size : 0;
    if (new_size == 0) {
        budget.memory_used -= before;
        std::free(block);
        return nullptr;
    }
    if (new_size > before && !takes(budget, is_text, new_size, new_size - before)) {
        return nullptr;
    }
    void* const out = std::realloc(block, new_size);
    if (out != nullptr) {
        budget.memory_used += new_size;
        budget.memory_used -= before;
    }
    return out;
}

}  // namespace zoned::scripting
