// text_repair: finds the statement that stopped the parser of text format, to read on without it.
#pragma once

#include <string>

namespace google::protobuf {
class Descriptor;
}

namespace zoned::config {

/// The parser's message and its place (from 1).
struct Remark {
    int line = 0;
    int column = 0;
    std::string text;
};

/// The statement `name: value` or `name { ... }` whose name, colon or value stands at `offset`.
struct Statement {
    std::size_t begin = 0;
    std::size_t value = 0;
    std::size_t end = 0;
    std::string name;
    std::string decimal;  ///< the number as it should be, where it was written with a comma
};

/// Offset of a line and column (both from 1) as the parser counts them: a tab leads to the next
/// multiple of eight.
std::size_t offset_of(const std::string& text, int line, int column);
/// The reverse.
void place_of(const std::string& text, std::size_t offset, int& line, int& column);

/// Text between the n-th pair of double quotes, counted from 0.
std::string quoted(const std::string& text, int n);

/// The statement that `remark` is about; false where no statement can be left out.
bool find_culprit(const std::string& text, const Remark& remark, Statement& out);

/// The parser's message in the words of this project; `root` is the message being read.
std::string explain(const Remark& remark,
                    const Statement& statement,
                    const google::protobuf::Descriptor& root);

}  // namespace zoned::config
