#include "shared/core/json.h"

#include "shared/core/assert.h"

#include <charconv>
#include <cmath>
#include <cstdio>

namespace zoned::core {

namespace {

/// Length of the UTF-8 sequence at the front of `text`, 0 when it is not valid (RFC 3629: shortest
/// form, no surrogates, up to U+10FFFF).
std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t i) {
        return static_cast<unsigned char>(text[i]);
    };
    const unsigned char first = byte(0);
    if (first < 0x80) {
        return 1;
    }
    const std::size_t length = first >= 0xF0 ? 4 : (first >= 0xE0 ? 3 : 2);
    if (first < 0xC2 || first > 0xF4 || text.size() < length) {
        return 0;
    }
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) {
            return 0;
        }
    }
    const bool overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
    const bool beyond = (first == 0xED && byte(1) > 0x9F) || (first == 0xF4 && byte(1) > 0x8F);
    return overlong || beyond ? 0 : length;
}

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
        const std::size_t length = utf8_length(text.substr(i));
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

}  // namespace zoned::core
