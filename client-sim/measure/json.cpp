#include "client-sim/measure/json.h"

#include <cmath>
#include <cstdio>

namespace zoned::measure {

void JsonWriter::separate() {
    if (after_key_) {
        after_key_ = false;
        return;
    }
    if (!first_) {
        text_ += ',';
    }
    if (depth_ > 0) {
        text_ += '\n';
        text_.append(static_cast<std::size_t>(2 * depth_), ' ');
    }
    first_ = false;
}

void JsonWriter::open(char bracket) {
    separate();
    text_ += bracket;
    ++depth_;
    first_ = true;
}

void JsonWriter::close(char bracket) {
    --depth_;
    if (!first_) {
        text_ += '\n';
        text_.append(static_cast<std::size_t>(2 * depth_), ' ');
    }
    text_ += bracket;
    first_ = false;
    if (depth_ == 0) {
        text_ += '\n';
    }
}

void JsonWriter::key(std::string_view name) {
    separate();
    quoted(name);
    text_ += ": ";
    after_key_ = true;
}

void JsonWriter::quoted(std::string_view value) {
    text_ += '"';
    for (const char c : value) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            text_ += '\\';
            text_ += c;
        } else if (byte < 0x20) {
            char escaped[8];
            std::snprintf(escaped, sizeof(escaped), "\\u%04x", byte);
            text_ += escaped;
        } else {
            text_ += c;
        }
    }
    text_ += '"';
}

void JsonWriter::field(std::string_view key_name, std::string_view value) {
    key(key_name);
    after_key_ = false;
    quoted(value);
}

void JsonWriter::field(std::string_view key_name, double value) {
    key(key_name);
    after_key_ = false;
    if (!std::isfinite(value)) {
        text_ += "null";
        return;
    }
    char number[40];
    std::snprintf(number, sizeof(number), "%.9g", value);
    text_ += number;
}

void JsonWriter::field(std::string_view key_name, std::uint64_t value) {
    key(key_name);
    after_key_ = false;
    text_ += std::to_string(value);
}

void JsonWriter::field(std::string_view key_name, bool value) {
    key(key_name);
    after_key_ = false;
    text_ += value ? "true" : "false";
}

void JsonWriter::element(std::string_view value) {
    separate();
    quoted(value);
}

}  // namespace zoned::measure
