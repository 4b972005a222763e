#include "server/config/text/text_repair.h"

#include "server/config/text/renamed_words.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <set>

namespace zoned::config {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
           c == '+';
}

bool is_space(char c) {
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

/// One past the value that begins at `at`: a word, a string or a balanced block; npos when it has
/// no end.
std::size_t end_of_value(const std::string& text, std::size_t at) {
    if (at >= text.size()) {
        return std::string::npos;
    }
    if (text[at] == '"' || text[at] == '\'') {
        for (std::size_t i = at + 1; i < text.size() && text[i] != '\n'; ++i) {
            if (text[i] == '\\') {
                ++i;
            } else if (text[i] == text[at]) {
                return i + 1;
            }
        }
        return std::string::npos;
    }
    if (text[at] == '{' || text[at] == '<' || text[at] == '[') {
        int depth = 0;
        for (std::size_t i = at; i < text.size();) {
            const char c = text[i];
            if (c == '#') {
                i = std::min(text.find('\n', i), text.size());
            } else if (c == '"' || c == '\'') {
                i = end_of_value(text, i);
                if (i == std::string::npos) {
                    return i;
                }
            } else {
                depth += (c == '{' || c == '<' || c == '[') ? 1 : 0;
                depth -= (c == '}' || c == '>' || c == ']') ? 1 : 0;
                ++i;
                if (depth == 0) {
                    return i;
                }
            }
        }
        return std::string::npos;
    }
    std::size_t i = at;
    while (i < text.size() && is_word(text[i])) {
        ++i;
    }
    return i == at ? std::string::npos : i;
}

bool statement_at(const std::string& text, std::size_t offset, Statement& out) {
    std::size_t i = std::min(offset, text.size());
    // Back over what lies between a name and the place: the value's own start needs no step.
    if (i < text.size() && is_word(text[i]) && (i == 0 || !is_word(text[i - 1]))) {
        // A word: either the value after a colon, or a name. Look ahead for a colon or a block.
        std::size_t after = end_of_value(text, i);
        while (after < text.size() && is_space(text[after])) {
            ++after;
        }
        if (after < text.size() && (text[after] == ':' || text[after] == '{')) {
            i = after;
        }
    }
    while (i > 0 && (is_space(text[i - 1]) || text[i - 1] == ':')) {
        --i;
    }
    const std::size_t name_end = i;
    while (i > 0 && is_word(text[i - 1])) {
        --i;
    }
    if (i == name_end) {
        return false;
    }
    out.begin = i;
    out.name = text.substr(i, name_end - i);
    std::size_t v = name_end;
    while (v < text.size() && (is_space(text[v]) || text[v] == ':')) {
        ++v;
    }
    out.value = v;
    out.end = end_of_value(text, v);
    return out.end != std::string::npos && out.end >= offset;
}

/// The parser speaks of enum and bool values after it has consumed them: finds the statement back.
bool statement_before(const std::string& text,
                      std::size_t offset,
                      const std::string& name,
                      const std::string& value,
                      Statement& out) {
    std::size_t at = std::min(offset, text.size());
    while (at > 0) {
        at = text.rfind(value, at - 1);
        if (at == std::string::npos) {
            return false;
        }
        if (statement_at(text, at, out) && out.value == at && out.name == name) {
            return true;
        }
    }
    return false;
}

bool is_digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// "x_m: 1,5": the parser takes the comma for the end of the setting, the 5 for the number of a
/// field, and stops at what follows.
bool decimal_comma(const std::string& text, std::size_t offset, Statement& out) {
    while (offset > 0 && is_space(text[offset - 1])) {
        --offset;
    }
    while (offset > 0 && is_word(text[offset - 1])) {
        --offset;
    }
    if (offset < 2 || offset >= text.size() || !is_digit(text[offset]) || text[offset - 1] != ',' ||
        !is_digit(text[offset - 2])) {
        return false;
    }
    std::size_t number = offset - 1;
    while (number > 0 && is_word(text[number - 1])) {
        --number;
    }
    if (!statement_at(text, number, out)) {
        return false;
    }
    out.end = end_of_value(text, offset);
    out.decimal =
        text.substr(number, offset - 1 - number) + "." + text.substr(offset, out.end - offset);
    return true;
}

/// The first field of that name with a choice of values, in the message and what it holds.
const FieldDescriptor* find_choice_named(const Descriptor& message,
                                         const std::string& name,
                                         std::set<const Descriptor*>& seen) {
    const FieldDescriptor* own = message.FindFieldByName(name);
    if (own != nullptr && own->enum_type() != nullptr) {
        return own;
    }
    seen.insert(&message);
    for (int i = 0; i < message.field_count(); ++i) {
        const Descriptor* inner = message.field(i)->message_type();
        if (inner != nullptr && seen.count(inner) == 0) {
            if (const FieldDescriptor* field = find_choice_named(*inner, name, seen)) {
                return field;
            }
        }
    }
    return nullptr;
}

std::string values_of(const google::protobuf::EnumDescriptor& type) {
    std::string list;
    for (int i = 0; i < type.value_count(); ++i) {
        list += (i == 0 ? "" : ", ") + type.value(i)->name();
    }
    return list;
}

}  // namespace

std::size_t offset_of(const std::string& text, int line, int column) {
    std::size_t at = 0;
    for (int l = 1; l < line; ++l) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string::npos) {
            return text.size();
        }
        at = end + 1;
    }
    int reached = 1;
    while (reached < column && at < text.size() && text[at] != '\n') {
        reached = text[at] == '\t' ? (reached - 1) / 8 * 8 + 9 : reached + 1;
        ++at;
    }
    return at;
}

void place_of(const std::string& text, std::size_t offset, int& line, int& column) {
    line = 1;
    column = 1;
    for (std::size_t i = 0; i < offset && i < text.size(); ++i) {
        if (text[i] == '\n') {
            ++line;
            column = 1;
        } else {
            column = text[i] == '\t' ? (column - 1) / 8 * 8 + 9 : column + 1;
        }
    }
}

std::string quoted(const std::string& text, int n) {
    std::size_t at = 0;
    for (int i = 0;; ++i) {
        const std::size_t open = text.find('"', at);
        const std::size_t close = open == std::string::npos ? open : text.find('"', open + 1);
        if (close == std::string::npos) {
            return {};
        }
        if (i == n) {
            return text.substr(open + 1, close - open - 1);
        }
        at = close + 1;
    }
}

bool find_culprit(const std::string& text, const Remark& remark, Statement& out) {
    const std::size_t offset = offset_of(text, remark.line, remark.column);
    if (remark.text.find("Unknown enumeration value of") == 0) {
        return statement_before(text, offset, quoted(remark.text, 1), quoted(remark.text, 0), out);
    }
    if (remark.text.find("Invalid value for boolean field") == 0) {
        return statement_before(text, offset, quoted(remark.text, 0), quoted(remark.text, 1), out);
    }
    if (remark.text.find("Expected \"{\"") == 0 && decimal_comma(text, offset, out)) {
        return true;
    }
    const bool repairable =
        remark.text.find("Expected integer") == 0 || remark.text.find("Expected double") == 0 ||
        remark.text.find("Expected string") == 0 ||
        remark.text.find("Expected identifier, got: \"") == 0 ||
        remark.text.find("Expected identifier, got: ") == 0 ||
        remark.text.find("Integer out of range") == 0 || remark.text.find("Invalid integer") == 0 ||
        remark.text.find("Non-repeated field") == 0 || remark.text.find("Field \"") == 0 ||
        remark.text.find("Expected \"{\"") == 0;
    return repairable && statement_at(text, offset, out);
}

std::string explain(const Remark& remark, const Statement& statement, const Descriptor& root) {
    const std::string& text = remark.text;
    if (!statement.decimal.empty()) {
        return "a decimal comma: write " + statement.name + ": " + statement.decimal;
    }
    if (text.find("Unknown enumeration value of") == 0) {
        std::string out = "'" + quoted(text, 0) + "' is not a value of " + statement.name;
        std::set<const Descriptor*> seen;
        const FieldDescriptor* field = find_choice_named(root, statement.name, seen);
        if (field != nullptr) {
            const std::string_view now = word_now(field->enum_type()->full_name(), quoted(text, 0));
            out += now.empty() ? "; choose one of " + values_of(*field->enum_type())
                               : "; it is called '" + std::string(now) + "' now";
        }
        return out;
    }
    if (text.find("Invalid value for boolean field") == 0) {
        return "'" + quoted(text, 1) + "' is neither true nor false";
    }
    if (text.find("Non-repeated field") == 0) {
        return statement.name + " is given twice; keep one";
    }
    if (text.find("Field \"") == 0) {
        return "only one of " + quoted(text, 0) + " and " + quoted(text, 1) + " may be given";
    }
    if (text.find("Integer out of range") == 0) {
        return text;
    }
    return "wrong type: " + text;
}

}  // namespace zoned::config
