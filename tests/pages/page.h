// Page: a Markdown page as the sequence of steps that its reader takes, and the names that it
// mentions.
//
// Each fenced block has a language. A block in `sh` is run; what becomes of any other block stands
// in a comment on the line above it, which readers of the page do not see:
//
//   <!-- page: file PATH -->        the block is a file, written to PATH
//   <!-- page: extends CONFIG -->   the block, added to that config, passes `zoned check`
//   <!-- page: output -->           the last commands printed these lines, in this order ("..."
//   stands for anything)
//   <!-- page: output numbers -->   likewise, any number in place of a number
//   <!-- page: skip REASON -->      not run; the reason is printed
//   <!-- page: exit 2 -->           the commands end with this exit code
//   <!-- page: seconds 120 -->      they may take so long (60)
//   <!-- page: background TEXT -->  the command runs on once it has printed TEXT, until `stop` or
//   the end of the page
//   <!-- page: env A=1 B=2 -->      with this environment: a shorter run
//   <!-- page: append --quick -->   with this behind the command: a shorter run
//
// And on lines of their own:
//
//   <!-- page: stop -->             ends what runs in the background; it must end with exit code 0,
//                                   or with that of its own `exit`
//   <!-- page: sh COMMAND -->       runs a command that the reader need not
//   <!-- page: ports 7777 7778 -->  free ports take the place of these numbers wherever the page
//   has them
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace zoned::pages {

/// Something wrong with a page, or to be known of it.
struct Finding {
    int line = 0;  ///< of the page, from 1
    std::string text;
};

struct Step {
    enum class Kind {
        kRun,
        kFile,
        kExtends,
        kOutput,
        kSkip,
        kStop,
    };

    Kind kind = Kind::kRun;
    int line = 0;
    std::string text;        ///< of the block, without the indentation of its fence
    std::string argument;    ///< path, config or reason
    std::string background;  ///< runs on once it has printed this; empty: in the foreground
    std::string environment;
    std::string append;
    int exit_code = 0;
    double seconds = 60.0;
    bool any_number = false;
    bool hidden = false;
};

/// Inline code, or the target of a link.
struct Mention {
    int line = 0;
    std::string text;
    bool link = false;
};

struct Page {
    std::string path;  ///< from the root of the repository
    std::vector<Step> steps;
    std::vector<Mention> mentions;
    std::vector<std::string> ports;
    std::vector<Finding> defects;  ///< blocks without a language, unknown comments, ...
};

Page read_page(const std::string& path, std::string_view text);

/// Whether `printed` has the lines of `expected` in this order, others in between; the first line
/// that is missing goes to `missing`.
bool has_lines(const std::string& printed,
               const std::string& expected,
               bool any_number,
               std::string& missing);

}  // namespace zoned::pages
