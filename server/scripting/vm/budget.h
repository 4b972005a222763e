// Budget: what a call of a script may still use up, and what ran out where.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

struct lua_State;

namespace zoned::scripting {

/// Texts longer than this are refused: comparing and copying them is one instruction each.
inline constexpr std::size_t kMaxTextBytes = 64U << 10U;

/// Passing `...` on copies all of its values in one instruction.
inline constexpr int kMaxVarargs = 250;

enum class ScriptOverrun : std::uint8_t {
    kNone,
    kInstructions,
    kWork,  ///< of functions of the host, which instructions do not count
    kMemory,
    kText,    ///< a text longer than kMaxTextBytes
    kValues,  ///< more than kMaxVarargs values as `...`
};

struct Budget {
    std::int64_t call_instructions = 0;  ///< left
    std::int64_t tick_instructions = 0;  ///< left, of all calls of a tick
    std::int64_t call_work = 0;          ///< left; a unit is about what an instruction costs
    std::size_t memory_used = 0;
    std::size_t memory_most = 0;
    int memory_refusals = 0;  ///< in this call
    bool reporting = false;   ///< an error is being reported, which may take a little more memory
    ScriptOverrun overrun = ScriptOverrun::kNone;
    std::array<char, 128> place{};  ///< "game.lua:12" of the overrun, or of the newest refusal
    lua_State* lua = nullptr;

    void begin_call(std::int64_t instructions) {
        call_instructions = instructions;
        call_work = instructions;
        memory_refusals = 0;
        reporting = false;
        overrun = ScriptOverrun::kNone;
        place[0] = '\0';
    }

    /// The first overrun of a call counts.
    void flag(ScriptOverrun what) {
        if (overrun == ScriptOverrun::kNone) {
            overrun = what;
            note_place();
        }
    }

    /// The line of the script that runs now.
    void note_place();
};

/// The allocator of Lua: refuses what goes beyond the Budget that `budget` points to.
void* limited_alloc(void* budget, void* block, std::size_t old_size, std::size_t new_size);

}  // namespace zoned::scripting
