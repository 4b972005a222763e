// LineReader: a text line by line and word by word, for files that people write.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace zoned::core {

/// The whole `text` as a number in the form of std::from_chars; none where it is something else, or
/// does not fit.
template <class Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && at == end ? std::optional<Number>(value) : std::nullopt;
}

/// Lines end with LF, CR LF or CR; words lie between spaces and tabs. The first failure is kept.
class LineReader {
  public:
    /// Text after `comment` in a line is left out; '\0': no comments.
    explicit LineReader(std::string_view text, char comment = '\0')
        : text_(text),
          comment_(comment) {}

    /// Goes to the next line; false at the end of the text.
    bool next();
    /// Goes to the next line with a word in it; false at the end of the text.
    bool next_written();

    /// Number of the line, counted from 1; 0 before the first.
    [[nodiscard]] std::size_t line() const { return number_; }

    /// The unread rest of the line.
    [[nodiscard]] std::string_view rest() const { return line_; }

    /// The next word of the line; empty at its end.
    std::string_view word();

    /// The next word as a number; none where it is something else, or missing.
    template <class Number>
    std::optional<Number> number() {
        return parse_number<Number>(word());
    }

    /// Notes `what` as the mistake of line() and returns false.
    bool fail(std::string_view what) { return fail_at(number_, what); }

    bool fail_at(std::size_t line, std::string_view what);

    [[nodiscard]] bool failed() const { return !error_.empty(); }

    /// "line 3: what"; empty: nothing failed.
    [[nodiscard]] const std::string& error() const { return error_; }

  private:
    std::string_view text_;  // behind the line
    std::string_view line_;
    char comment_;
    std::size_t number_ = 0;
    std::string error_;
};

/// The first characters of a word from outside between quotes, as a message can hold them: `most`
/// of them, with ? for what is not printable.
[[nodiscard]] std::string quoted(std::string_view word, std::size_t most = 40);

/// Without the blanks at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

}  // namespace zoned::core
