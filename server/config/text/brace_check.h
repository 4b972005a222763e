// brace_check: finds the block of a text that has no end, by its braces and its indentation.
#pragma once

#include <optional>
#include <string>

namespace zoned::config {

/// A mistake in the nesting of a text; line and column count from 1.
struct BraceMistake {
    int line = 0;
    int column = 0;
    std::string text;
};

/// The first block without an end, or the first brace that closes nothing; nothing where braces and
/// brackets are in balance. Which block lacks its end is not in the braces: where the lines are
/// indented, the first closing brace that stands under another block's beginning tells, or the
/// first block that begins there. Comments and strings are passed over.
[[nodiscard]] std::optional<BraceMistake> find_brace_mistake(const std::string& text);

}  // namespace zoned::config
