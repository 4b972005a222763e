// JsonWriter: writes a report as JSON (RFC 8259), two spaces deep per level.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace zoned::measure {

/// Keys and values in the order of the calls; commas, quotes and escapes are taken care of.
class JsonWriter {
  public:
    void begin_object() { open('{'); }

    void begin_object(std::string_view key_name) {
        key(key_name);
        open('{');
    }

    void end_object() { close('}'); }

    void begin_array(std::string_view key_name) {
        key(key_name);
        open('[');
    }

    void end_array() { close(']'); }

    void field(std::string_view key_name, std::string_view value);
    void field(std::string_view key_name, double value);
    void field(std::string_view key_name, std::uint64_t value);
    void field(std::string_view key_name, bool value);
    void element(std::string_view value);

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    void open(char bracket);
    void close(char bracket);
    void separate();
    void key(std::string_view name);
    void quoted(std::string_view value);

    std::string text_;
    int depth_ = 0;
    bool first_ = true;
    bool after_key_ = false;
};

}  // namespace zoned::measure
