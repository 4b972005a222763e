// SettledWrite: a compare-and-set whose outcome is known in the end, although answers get lost.
#pragma once

#include "server/cluster/board.h"

#include <cstdint>
#include <string>

namespace zoned::cluster {

/// A write that may be tried again until it is known to be done or overtaken. No two writers may
/// want to write the same value under the same revision.
struct SettledWrite {
    std::string key;
    std::uint64_t expected = 0;
    std::string value;

    enum class Outcome : std::uint8_t {
        kDone,      ///< under `revision`
        kAgain,     ///< not known, or the board is out of reach: try the same again
        kOvertaken  ///< another write took its place: `present` is what is there
    };

    std::uint64_t revision = 0;
    BoardEntry present = {};
    std::string trouble = {};  ///< of kAgain

    /// One attempt. A write that timed out is neither done nor failed: the next attempt is made
    /// with the same revision, and one that finds its own value has been done.
    Outcome attempt(Board& board);
};

}  // namespace zoned::cluster
