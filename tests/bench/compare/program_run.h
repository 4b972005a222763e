// ProgramRun: runs a zoned-bench of some build as a child process and reads its rows.
#pragma once

#include "tests/bench/results.h"

#include <string>
#include <vector>

namespace zoned::bench {

/// Runs `program` with the arguments and `--json` and returns its results. Its standard output is
/// dropped. Throws std::runtime_error where it can't be started or fails; the text holds the last
/// line of its standard error.
Results results_of_program(const std::string& program, const std::vector<std::string>& arguments);

/// True where the file begins like JSON; a program is anything else.
bool is_json_file(const std::string& path);

}  // namespace zoned::bench
