#include "shared/core/files/line_reader.h"

#include <algorithm>

namespace zoned::core {

namespace {

constexpr std::string_view kBlanks = " \t";

}  // namespace

bool LineReader::next() {
    line_ = {};
    if (text_.empty()) {
        return false;
    }
    const std::size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
    line_ = text_.substr(0, end);
    if (comment_ != '\0') {
        line_ = line_.substr(0, line_.find(comment_));
    }
    const std::size_t ending = text_.substr(end, 2) == "\r\n" ? 2 : 1;
    text_.remove_prefix(std::min(end + ending, text_.size()));
    ++number_;
    return true;
}

bool LineReader::next_written() {
    while (next()) {
        if (line_.find_first_not_of(kBlanks) != std::string_view::npos) {
            return true;
        }
    }
    return false;
}

std::string_view LineReader::word() {
    line_.remove_prefix(std::min(line_.find_first_not_of(kBlanks), line_.size()));
    const std::string_view found = line_.substr(0, line_.find_first_of(kBlanks));
    line_.remove_prefix(found.size());
    return found;
}

bool LineReader::fail_at(std::size_t line, std::string_view what) {
    if (error_.empty()) {
        error_ = "line " + std::to_string(std::max<std::size_t>(line, 1)) + ": ";
        error_ += what;
    }
    return false;
}

std::string quoted(std::string_view word, std::size_t most) {
    std::string out = "'";
    for (const char c : word.substr(0, most)) {
        out += c >= ' ' && c <= '~' ? c : '?';
    }
    return out + (word.size() > most ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

}  // namespace zoned::core
