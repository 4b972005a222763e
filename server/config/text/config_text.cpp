#include "server/config/text/config_text.h"

#include "server/config/text/brace_check.h"
#include "server/config/text/renamed_words.h"
#include "server/config/text/text_repair.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <vector>

namespace zoned::config {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

constexpr int kMaxRepairs = 200;  // mistakes that stop the parser and are repaired, per file

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

void report_unknown(const std::string& text, const Remark& remark, Diagnostics& diagnostics) {
    // 'Message type "zoned.proto.config.World" has no field named "tickrate".'
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
        what += " in " + (message->name() == "Config" ? "the config" : message->name());
        what += advice_on(*message, name);
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

std::string advice_on(const Descriptor& message, const std::string& name) {
    const std::string_view now = word_now(message.full_name(), name);
    if (!now.empty()) {
        return "; it is called '" + std::string(now) + "' now";
    }
    const std::string similar = similar_field(message, name);
    return similar.empty() ? "" : "; did you mean '" + similar + "'?";
}

bool parse_config_text(const std::string& text,
                       google::protobuf::Message& config,
                       Diagnostics& diagnostics) {
    if (const auto mistake = find_brace_mistake(text)) {
        // Without its nesting the text says nothing that could be checked.
        diagnostics.add_at(mistake->line, mistake->column, "", "syntax: " + mistake->text);
        return false;
    }
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
        diagnostics.add_at(line,
                           column,
                           culprit.name,
                           explain(collector.errors.front(), culprit, *config.GetDescriptor()));
        for (std::size_t i = culprit.begin; i < culprit.end; ++i) {
            if (remaining[i] != '\n') {
                remaining[i] = ' ';
            }
        }
    }
}

}  // namespace zoned::config
