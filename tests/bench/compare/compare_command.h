// CompareCommand: `zoned-bench compare OLD NEW`, two builds or two files of rows against each
// other.
#pragma once

#include "tests/bench/compare/judgement.h"

#include <cstddef>
#include <string>
#include <vector>

namespace zoned::bench {

/// The whole command, with "compare" as its first argument. 0: nothing got worse; 1: something did;
/// 2: bad usage; 3: a program or file could not be used.
int compare_main(int argc, const char* const* argv);

/// Runs both programs `count` times four, in the order old, new, new, old and the reverse by turns,
/// and says on standard error how long it will take.
std::vector<Block> measured_blocks(const std::string& old_program,
                                   const std::string& new_program,
                                   const std::vector<std::string>& arguments,
                                   int count);

/// A table of the findings for a terminal, worse ones first, and one line that counts them.
std::string findings_table(const std::vector<Finding>& findings, std::size_t rows);

}  // namespace zoned::bench
