// Options: the command line of zoned-stability.
#pragma once

#include "tests/stability/random/random_lab.h"
#include "tests/stability/run.h"

#include <optional>
#include <string>
#include <vector>

namespace zoned::stability {

enum ExitCode {
    kGood = 0,
    kFailed = 1,
    kBadUsage = 2,
    kEnvironment = 3,
};

struct Options {
    std::vector<std::string> only;  ///< names of cases, or of invariants; empty: all
    std::string json_file;          ///< empty: none
    Fault fault = Fault::kNone;
    std::uint64_t seed = 1;
    bool quick = false;
    bool list = false;
    bool quiet = false;
    std::optional<RandomLabOptions> random;  ///< random scenes in place of the cases
    std::string replay_file;                 ///< one scene in place of the cases; empty: none
    std::vector<Invariant> invariants;       ///< of `only`, where it names those
};

/// Nothing where the program is to end with `exit_code`: help was asked for, or the line is wrong.
std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code);

}  // namespace zoned::stability
