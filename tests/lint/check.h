// The checks that keep the house in order: pure functions of a path and a text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace zoned::lint {

/// A file by its path from the repository root, with slashes.
struct SourceFile {
    std::string path;
    std::string text;
};

struct Finding {
    std::string path;
    int line = 0;  ///< counted from 1; 0 for the file as a whole
    std::string what;
};

/// Longest source file of the two programs, lines.
inline constexpr int kMaxLines = 600;

/// Includes go up the layer order only, are written from the repository root, and the rows that
/// replay bit for bit include nothing that could spoil that.
std::vector<Finding> check_includes(const SourceFile& file);

/// A header begins with a `// ` comment that says what it is for; `#pragma once` is the first line
/// after that comment.
std::vector<Finding> check_header(const SourceFile& file);

/// No file of server, client-sim or shared is longer than kMaxLines.
std::vector<Finding> check_length(const SourceFile& file);

/// No word that marks unfinished work.
std::vector<Finding> check_words(const SourceFile& file);

/// Nothing but the sandbox rules, the bots and the tests knows the messages of the sandbox game.
std::vector<Finding> check_sandbox(const SourceFile& file);

/// All of the above.
std::vector<Finding> check_file(const SourceFile& file);

/// `names` are the entries of the repository's root.
std::vector<Finding> check_top_level(const std::vector<std::string>& names);

/// One line per finding, for a test's message.
std::string to_text(const std::vector<Finding>& findings);

}  // namespace zoned::lint
