#include "shared/core/json.h"

#include "shared/core/assert.h"
#include "shared/core/utf8.h"

#include <charconv>
#include <cmath>
#include <cstdio>

namespace zoned::core {

namespace {

void append_control(char c, std::string& out) {
    switch (c) {
        case '\n':
            out += "\\n";
            return;
        case '\r':
            out += "\\r";
            return;
        case '\t':
            out += "\\t";
            return;
        default: {
            char buffer[8];
            std::snprintf(buffer, sizeof(buffer), "\\u%04x", static_cast<unsigned char>(c));
            out += buffer;
        }
    }
}

}  // namespace

std::string json_quote(std::string_view text) {
    std::string out = "\"";
    for (std::size_t i = 0; i < text.size();) {
        const char c = text[i];
        std::uint32_t code = 0;
        const std::size_t length = decode_utf8(text.substr(i), code);
        if (length == 0) {
            out += "\xEF\xBF\xBD";
            ++i;
            continue;
        }
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
            append_control(c, out);
        } else {
            out += text.substr(i, length);
        }
        i += length;
    }
    return out + "\"";
}

void JsonWriter::new_line() {
    text_ += '\n';
    text_.append(2 * has_elements_.size(), ' ');
}

void JsonWriter::before_value() {
    if (after_key_) {
        after_key_ = false;
        return;
    }
    if (has_elements_.empty()) {
        return;
    }
    if (has_elements_.back()) {
        text_ += ',';
    }
    has_elements_.back() = true;
    new_line();
}

JsonWriter& JsonWriter::raw(std::string_view text) {
    before_value();
    text_ += text;
    return *this;
}

JsonWriter& JsonWriter::begin_object() {
    raw("{");
    has_elements_.push_back(false);
    return *this;
}

JsonWriter& JsonWriter::begin_array() {
    raw("[");
    has_elements_.push_back(false);
    return *this;
}

void JsonWriter::close(char bracket) {
    ZONED_ASSERT(!has_elements_.empty() && !after_key_, "an end needs its begin");
    const bool filled = has_elements_.back();
    has_elements_.pop_back();
    if (filled) {
        new_line();
    }
    text_ += bracket;
}

JsonWriter& JsonWriter::end_object() {
    close('}');
    return *this;
}

JsonWriter& JsonWriter::end_array() {
    close(']');
    return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
    ZONED_ASSERT(!after_key_, "a key needs its value");
    before_value();
    text_ += json_quote(name);
    text_ += ": ";
    after_key_ = true;
    return *this;
}

JsonWriter& JsonWriter::value(std::string_view text) {
    return raw(json_quote(text));
}

JsonWriter& JsonWriter::value(bool truth) {
    return raw(truth ? "true" : "false");
}

JsonWriter& JsonWriter::value(double number) {
    if (!std::isfinite(number)) {
        return raw("null");
    }
    char buffer[64];
    const auto end = std::to_chars(buffer, buffer + sizeof(buffer), number);
    return raw(std::string_view(buffer, static_cast<std::size_t>(end.ptr - buffer)));
}

JsonWriter& JsonWriter::value(const std::map<std::string, std::uint64_t>& counts) {
    begin_object();
    for (const auto& [name, count] : counts) {
        field(name, count);
    }
    return end_object();
}

}  // namespace zoned::core
