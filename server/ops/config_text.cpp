#include "server/ops/config_text.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace zoned::ops {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

constexpr int kMaxRepairs = 200;  // mistakes that stop the parser and are repaired, per file

struct Remark {
    int line = 0;    // from 1
    int column = 0;  // from 1
    std::string text;
};

class Collector : public google::protobuf::io::ErrorCollector {
  public:
    void AddError(int line,
                  google::protobuf::io::ColumnNumber column,
                  const std::string& text) override {
        errors.push_back({line + 1, column + 1, text});
    }

    void AddWarning(int line,
                    google::protobuf::io::ColumnNumber column,
                    const std::string& text) override {
        warnings.push_back({line + 1, column + 1, text});
    }

    std::vector<Remark> errors;
    std::vector<Remark> warnings;
};

std::size_t offset_of(const std::string& text, int line, int column) {
    std::size_t at = 0;
    for (int l = 1; l < line; ++l) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string::npos) {
            return text.size();
        }
        at = end + 1;
    }
    // The tokenizer counts a tab as an advance to the next multiple of eight.
    int reached = 1;
    while (reached < column && at < text.size() && text[at] != '\n') {
        reached = text[at] == '\t' ? (reached - 1) / 8 * 8 + 9 : reached + 1;
        ++at;
    }
    return at;
}

void place_of(const std::string& text, std::size_t offset, int& line, int& column) {
    line = 1 + static_cast<int>(std::count(
                   text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
    const std::size_t start = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
    column = 1 + static_cast<int>(start == std::string::npos ? offset : offset - start - 1);
}

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

/// The statement `name: value` or `name { ... }` whose name, colon or value stands at `offset`.
struct Statement {
    std::size_t begin = 0;
    std::size_t value = 0;
    std::size_t end = 0;
    std::string name;
};

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

/// Text between the n-th pair of double quotes, counted from 0.
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

/// Finds the statement that stopped the parser. `wish` says what would have been right.
bool find_culprit(const std::string& text, const Remark& remark, Statement& out) {
    const std::size_t offset = offset_of(text, remark.line, remark.column);
    if (remark.text.find("Unknown enumeration value of") == 0) {
        return statement_before(text, offset, quoted(remark.text, 1), quoted(remark.text, 0), out);
    }
    if (remark.text.find("Invalid value for boolean field") == 0) {
        return statement_before(text, offset, quoted(remark.text, 0), quoted(remark.text, 1), out);
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

const FieldDescriptor* find_field_named(const Descriptor& message, const std::string& name) {
    if (const FieldDescriptor* field = message.FindFieldByName(name)) {
        return field;
    }
    for (int i = 0; i < message.nested_type_count(); ++i) {
        if (const FieldDescriptor* field = find_field_named(*message.nested_type(i), name)) {
            return field;
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

/// The parser's words, in the words of this project.
std::string explain(const Remark& remark, const Statement& statement) {
    const std::string& text = remark.text;
    if (text.find("Unknown enumeration value of") == 0) {
        std::string out = "'" + quoted(text, 0) + "' is not a value of " + statement.name;
        const FieldDescriptor* field =
            find_field_named(*proto::Config::descriptor(), statement.name);
        if (field != nullptr && field->enum_type() != nullptr) {
            out += "; choose one of " + values_of(*field->enum_type());
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

void report_unknown(const std::string& text, const Remark& remark, Diagnostics& diagnostics) {
    // 'Message type "zoned.proto.Config.World" has no field named "tickrate".'
    const std::string type = quoted(remark.text, 0);
    const std::string name = quoted(remark.text, 1);
    if (remark.text.find("has no field named") == std::string::npos) {
        diagnostics.add_at(remark.line, remark.column, "", remark.text);
        return;
    }
    int line = remark.line;
    int column = remark.column;
    // The parser has consumed the name already; it stands right before the place it reports.
    const std::size_t offset = offset_of(text, line, column);
    const std::size_t at = offset == 0 ? std::string::npos : text.rfind(name, offset - 1);
    if (at != std::string::npos) {
        place_of(text, at, line, column);
    }
    const Descriptor* message =
        google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(type);
    std::string what = "unknown setting";
    if (message != nullptr) {
        const std::string similar = similar_field(*message, name);
        what += " in " + (message == proto::Config::descriptor() ? "the config" : message->name());
        what += similar.empty() ? "" : "; did you mean '" + similar + "'?";
    }
    diagnostics.add_at(line, column, name, what);
}

void record_places(const Message& message,
                   const TextFormat::ParseInfoTree* tree,
                   const std::string& path,
                   Diagnostics& diagnostics) {
    if (tree == nullptr) {
        return;
    }
    std::vector<const FieldDescriptor*> fields;
    message.GetReflection()->ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
        const bool repeated = field->is_repeated();
        const int count = repeated ? message.GetReflection()->FieldSize(message, field) : 1;
        for (int i = 0; i < count; ++i) {
            const int index = repeated ? i : -1;
            const std::string here = join_path(path, field->name(), index);
            const auto location = tree->GetLocation(field, index);
            if (location.line >= 0) {
                diagnostics.set_place(here, location.line + 1, location.column + 1);
            }
            if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
                const Message& child =
                    repeated ? message.GetReflection()->GetRepeatedMessage(message, field, i)
                             : message.GetReflection()->GetMessage(message, field);
                record_places(child, tree->GetTreeForNested(field, index), here, diagnostics);
            }
        }
    }
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
    // Wagner, Fischer, "The string-to-string correction problem", JACM 21 (1974).
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) {
        row[j] = j;
    }
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row[b.size()];
}

std::string without_underscores(std::string name) {
    name.erase(std::remove(name.begin(), name.end(), '_'), name.end());
    return name;
}

}  // namespace

std::string similar_field(const Descriptor& message, const std::string& name) {
    std::string best;
    if (name.size() > 64) {
        return best;
    }
    const std::string plain = without_underscores(name);
    std::size_t best_distance = name.size() / 3 + 1;
    for (int i = 0; i < message.field_count(); ++i) {
        const std::string& candidate = message.field(i)->name();
        // A forgotten unit is the commonest slip: "radius" for "radius_m", "tickrate" for
        // "tick_rate_hz".
        const bool prefix = plain.size() >= 4 && without_underscores(candidate).find(plain) == 0;
        const std::size_t distance = prefix ? 1 : edit_distance(name, candidate);
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

bool parse_config_text(const std::string& text, proto::Config& config, Diagnostics& diagnostics) {
    std::string remaining = text;
    for (int repair = 0;; ++repair) {
        Collector collector;
        TextFormat::ParseInfoTree tree;
        TextFormat::Parser parser;
        parser.RecordErrorsTo(&collector);
        parser.WriteLocationsTo(&tree);
        parser.AllowUnknownField(true);
        parser.SetRecursionLimit(64);
        const bool complete = parser.ParseFromString(remaining, &config);
        Statement culprit;
        const bool repaired = !complete && !collector.errors.empty() && repair < kMaxRepairs &&
                              find_culprit(remaining, collector.errors.front(), culprit);
        if (!repaired) {
            for (const Remark& remark : collector.warnings) {
                report_unknown(remaining, remark, diagnostics);
            }
            for (const Remark& remark : collector.errors) {
                diagnostics.add_at(remark.line, remark.column, "", "syntax: " + remark.text);
            }
            record_places(config, &tree, "", diagnostics);
            return complete;
        }
        int line = 0;
        int column = 0;
        place_of(remaining, culprit.begin, line, column);
        diagnostics.add_at(line, column, culprit.name, explain(collector.errors.front(), culprit));
        for (std::size_t i = culprit.begin; i < culprit.end; ++i) {
            if (remaining[i] != '\n') {
                remaining[i] = ' ';
            }
        }
    }
}

}  // namespace zoned::ops
