// Coverage: the table of what the server has to show, checked against worlds, schema and tests.
#pragma once

#include "tests/lint/check.h"
#include "proto/config/config.pb.h"

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::lint {

/// A row of the table.
struct CoverageRow {
    int line = 0;    ///< of the page, counted from 1
    int number = 0;  ///< of the item
    std::string item;
    std::string state;                  ///< one of kCoverageStates
    std::vector<std::string> worlds;    ///< files of config/ without their ending
    std::vector<std::string> settings;  ///< of the config, or commands of a program
    std::vector<std::string> tests;     ///< "Suite.Name", "Suite.Begin*" or "zoned-bench SUITE"
    std::string remark;
};

/// x: in a shipped world by config; s: by a setting that no shipped world uses; l: in the library,
/// tests and benchmarks alone; p: in part; -: missing; n: not sensible.
inline constexpr std::string_view kCoverageStates = "xslp-n";

/// The numbers of the items: from the first to the last of each pair.
using ItemNumbers = std::vector<std::pair<int, int>>;

/// All that a row may name.
struct CoverageFacts {
    std::map<std::string, proto::config::Config> worlds;
    std::set<std::string> tests;  ///< "Suite.Name", of parametrised ones also "Prefix/Suite.Name"
    std::set<std::string> benchmarks;             ///< names of suites
    std::map<std::string, std::string> programs;  ///< sources of their command lines, by name
};

/// Adds the tests of GoogleTest that a source defines; those that are disabled are none.
void add_tests(std::string_view source, std::set<std::string>& tests);

/// Adds the suites of zoned-bench that a source registers.
void add_benchmarks(std::string_view source, std::set<std::string>& benchmarks);

/// The rows of the table and the counts by state that its head gives agree with each other, with
/// `numbers` and with the facts. A page has tables of states (state, meaning, number of items) and
/// of items (number, item, state, worlds, settings, tests, remark); other tables are findings.
[[nodiscard]] std::vector<Finding> check_coverage(const SourceFile& page,
                                                  const ItemNumbers& numbers,
                                                  const CoverageFacts& facts);

}  // namespace zoned::lint
