// Options: the command line of zoned-bench.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace zoned::bench {

enum ExitCode {
    kGood = 0,
    kWorse = 1,  ///< a comparison found something
    kBadUsage = 2,
    kEnvironment = 3,
};

struct Options {
    std::vector<std::string> suites;   ///< empty: all
    std::vector<std::string> scenes;   ///< empty: all
    std::vector<std::string> methods;  ///< empty: all
    std::string json_file;             ///< empty: none
    std::string report;                ///< a page (.html) or a folder for it; empty: none
    std::string picture_file;          ///< empty: none
    std::string resume_file;           ///< empty: none
    std::string against_file;          ///< a baseline to compare with; empty: none
    std::string baseline_file;         ///< to write; empty: none
    int passes = 5;                    ///< of a baseline
    int repeats = 3;
    bool quick = false;
    bool list = false;
    bool metrics = false;
    bool advise_times = false;  ///< slower rows are named and don't fail
};

/// Nothing where the program must end with `exit_code`: help was asked for, or the line is wrong.
std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code);

}  // namespace zoned::bench
