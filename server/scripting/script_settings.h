// ScriptSettings: a script, what its calls may cost, and what errors lead to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace zoned::scripting {

/// The policy for a script that has made more errors than allowed.
enum class ErrorPolicy : std::uint8_t {
    kGoOn,      ///< it is called as before
    kMute,      ///< the callback that failed is not called any more
    kStopZone,  ///< its rules throw
};

/// The resources that a script may use up in a zone.
struct ScriptLimits {
    std::uint32_t instructions_per_call = 100'000;
    std::uint32_t instructions_per_tick = 2'000'000;
    std::size_t memory_bytes = 16U << 20U;  ///< of the interpreter
    std::size_t state_bytes = 16U << 20U;   ///< of the state that the script keeps

    bool operator==(const ScriptLimits&) const = default;
};

struct ScriptSettings {
    std::string name;               ///< for messages
    std::string source;             ///< Lua 5.4
    std::string avatar = "player";  ///< type of a player's avatar
    ScriptLimits limits;
    std::uint32_t errors_allowed = 100;  ///< kMute: of each callback
    ErrorPolicy on_errors = ErrorPolicy::kGoOn;

    bool operator==(const ScriptSettings&) const = default;
};

enum class ScriptLine : std::uint8_t {
    kPrinted,  ///< by the script
    kError,
};

/// Lines of a script for the log.
using ScriptLog = std::function<void(ScriptLine kind, const std::string& line)>;

}  // namespace zoned::scripting
