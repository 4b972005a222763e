// ResultsReader: reads what to_json() wrote, for reports, comparisons and runs that go on.
#pragma once

#include "tests/bench/results.h"

#include <string>

namespace zoned::bench {

/// Numbers that are null become NaN; fields that older files lack stay at their defaults. Throws
/// std::runtime_error where the text is no JSON object with rows; the message names `source`.
Results results_from_json(const std::string& text, const std::string& source);

/// The whole of a file. Throws std::runtime_error where it can't be read.
std::string read_text_file(const std::string& path);

/// Makes the folders above the file. Throws std::runtime_error where it can't be written. An
/// interrupted call leaves the old file in place.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace zoned::bench
