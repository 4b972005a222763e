// Json: writes JSON text, for reports.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace zoned::core {

/// Writes one value from front to back, indented. The class writes commas, quotes and escapes. The
/// caller is responsible for nesting: every begin has its end, and in an object each value follows
/// a key.
class JsonWriter {
  public:
    JsonWriter& begin_object();
    JsonWriter& end_object();
    JsonWriter& begin_array();
    JsonWriter& end_array();
    /// Key of an object's member, before its value.
    JsonWriter& key(std::string_view name);

    /// Text; bytes that are not UTF-8 become U+FFFD.
    JsonWriter& value(std::string_view text);

    JsonWriter& value(const char* text) { return value(std::string_view(text)); }

    JsonWriter& value(bool truth);
    /// Shortest text that reads back to the same number; a number that is not finite becomes null.
    JsonWriter& value(double number);

    template <class T>
        requires(std::is_integral_v<T> && !std::is_same_v<T, bool>)

    JsonWriter& value(T number) { return raw(std::to_string(number)); }

    /// An object with a number for each name.
    JsonWriter& value(const std::map<std::string, std::uint64_t>& counts);

    /// key and value in one.
    template <class T>
    JsonWriter& field(std::string_view name, const T& v) {
        key(name);
        return value(v);
    }

    /// The text so far; complete when everything is closed.
    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    JsonWriter& raw(std::string_view text);
    void before_value();
    void close(char bracket);
    void new_line();

    std::string text_;
    std::vector<bool> has_elements_;  // per open bracket
    bool after_key_ = false;
};

/// The text in double quotes with all escapes (RFC 8259, section 7).
std::string json_quote(std::string_view text);

}  // namespace zoned::core
