#include "shared/wire/declared/declared_fields.h"

#include "shared/core/utf8.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

namespace zoned::wire {
namespace {

// A text lies in its words as its bytes do on the wire.
static_assert(std::endian::native == std::endian::little);

std::string_view text_in(std::span<const std::uint32_t> words) {
    const auto* bytes = reinterpret_cast<const char*>(words.data());
    return {bytes + 1, std::min<std::size_t>(static_cast<unsigned char>(*bytes), kMostTextBytes)};
}

bool put_text(std::string_view text, std::span<std::uint32_t> words) {
    if (text.size() > kMostTextBytes || !core::is_clean_utf8(text)) {
        return false;
    }
    std::array<char, kTextWords * 4> bytes{};
    bytes[0] = static_cast<char>(text.size());
    std::copy(text.begin(), text.end(), bytes.begin() + 1);
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return true;
}

FieldOutcome put_number(const DeclaredField& field, double value, std::uint32_t& code) {
    if (!std::isfinite(value)) {
        return FieldOutcome::kRefused;
    }
    const double steps = std::floor((value - field.minimum) / field.quantum + 0.5);
    const auto most = static_cast<double>(field.most);
    code = static_cast<std::uint32_t>(std::clamp(steps, 0.0, most));
    // Half a step beyond an end still rounds to that end.
    return steps < 0.0 || steps > most ? FieldOutcome::kClamped : FieldOutcome::kDone;
}

/// Empty: nothing is wrong.
std::string wrong_with(const DeclaredField& field) {
    if (field.name.empty() || field.name.size() > kMostFieldNameBytes ||
        !core::is_clean_utf8(field.name)) {
        return "a name is 1..32 bytes of UTF-8";
    }
    switch (field.kind) {
        case DeclaredKind::kNumber:
            if (!std::isfinite(field.minimum) || !(field.quantum > 0.0) ||
                !std::isfinite(field.minimum + field.quantum * field.most)) {
                return "a range is of finite numbers, a quantum above 0";
            }
            if (field.most < 1 || field.most > kMostFieldSteps) {
                return "a range has 1..16777215 whole steps of its quantum";
            }
            break;
        case DeclaredKind::kEnum:
            if (field.values.size() < 2 || field.values.size() > kMostEnumValues) {
                return "an enum has 2..256 values";
            }
            for (std::size_t i = 0; i < field.values.size(); ++i) {
                const auto before = field.values.begin() + static_cast<std::ptrdiff_t>(i);
                if (field.values[i].empty() || field.values[i].size() > kMostFieldNameBytes ||
                    !core::is_clean_utf8(field.values[i])) {
                    return "the name of a value is 1..32 bytes of UTF-8";
                }
                if (std::find(field.values.begin(), before, field.values[i]) != before) {
                    return "a value comes twice";
                }
            }
            break;
        case DeclaredKind::kBool:
            break;
        case DeclaredKind::kText: {
            std::array<std::uint32_t, kTextWords> again{};
            if (!put_text(text_in(field.initial), again) || again != field.initial) {
                return "a text is at most 31 bytes of UTF-8";
            }
            return {};
        }
    }
    return field.initial[0] > field.most ? "the initial value is beyond the range" : "";
}

}  // namespace

DeclaredField number_field(std::string name,
                           double minimum,
                           double maximum,
                           double quantum,
                           double initial) {
    DeclaredField field;
    field.name = std::move(name);
    field.minimum = minimum;
    field.quantum = quantum;
    const double steps = (maximum - minimum) / quantum;
    // Rounding errors of decimal fractions are no part of a step.
    const bool whole = std::abs(steps - std::round(steps)) < 1e-6 * std::max(1.0, std::abs(steps));
    field.most = whole && steps >= 0.5 && steps <= kMostFieldSteps
                     ? static_cast<std::uint32_t>(std::round(steps))
                     : 0;  // refused
    if (put_number(field, initial, field.initial[0]) != FieldOutcome::kDone) {
        field.initial[0] = field.most + 1;
    }
    return field;
}

DeclaredField choice_field(std::string name,
                           std::vector<std::string> values,
                           std::string_view initial) {
    DeclaredField field;
    field.name = std::move(name);
    field.kind = DeclaredKind::kEnum;
    field.values = std::move(values);
    const auto at = std::ranges::find(field.values, initial);
    field.initial[0] = static_cast<std::uint32_t>(at - field.values.begin());
    return field;
}

DeclaredField flag_field(std::string name, bool initial) {
    DeclaredField field;
    field.name = std::move(name);
    field.kind = DeclaredKind::kBool;
    field.initial[0] = initial ? 1 : 0;
    return field;
}

DeclaredField text_field(std::string name, std::string_view initial) {
    DeclaredField field;
    field.name = std::move(name);
    field.kind = DeclaredKind::kText;
    if (!put_text(initial, field.initial)) {
        field.initial.fill(~0U);
    }
    return field;
}

core::Result<std::shared_ptr<const FieldSchema>> FieldSchema::make(
    std::vector<DeclaredField> fields) {
    using Made = core::Result<std::shared_ptr<const FieldSchema>>;
    if (fields.empty() || fields.size() > kMostDeclared) {
        return Made::failure("a type declares 1..64 fields");
    }
    auto schema = std::make_shared<FieldSchema>();
    for (DeclaredField& field : fields) {
        if (field.kind == DeclaredKind::kEnum) {
            field.most =
                static_cast<std::uint32_t>(std::max<std::size_t>(field.values.size(), 1)) - 1U;
        } else if (field.kind == DeclaredKind::kBool) {
            field.most = 1;
        }
        if (const std::string wrong = wrong_with(field); !wrong.empty()) {
            return Made::failure("field '" + field.name + "': " + wrong);
        }
        field.id = field_id(field.name);
        if (schema->find(field.id) != nullptr) {
            return Made::failure("field '" + field.name + "' is declared twice");
        }
        field.word = static_cast<std::uint16_t>(schema->initial_.size());
        field.words = field.kind == DeclaredKind::kText ? kTextWords : 1;
        field.bits = static_cast<std::uint8_t>(std::bit_width(field.most));
        schema->initial_.insert(
            schema->initial_.end(), field.initial.begin(), field.initial.begin() + field.words);
        schema->fields_.push_back(std::move(field));
    }
    if (schema->words() > kMostFieldWords) {
        return Made::failure(
            "the fields of a type have at most 128 words: 8 of a text, 1 of others");
    }
    return std::shared_ptr<const FieldSchema>(std::move(schema));
}

FieldValue value_of(const DeclaredField& field, std::span<const std::uint32_t> words) {
    switch (field.kind) {
        case DeclaredKind::kNumber:
            break;
        case DeclaredKind::kEnum:
            return std::string_view(field.values[std::min(words[0], field.most)]);
        case DeclaredKind::kBool:
            return words[0] != 0;
        case DeclaredKind::kText:
            return text_in(words);
    }
    return field.minimum + field.quantum * static_cast<double>(words[0]);
}

FieldOutcome put_value(const DeclaredField& field,
                       const FieldValue& value,
                       std::span<std::uint32_t> words) {
    const auto* text = std::get_if<std::string_view>(&value);
    switch (field.kind) {
        case DeclaredKind::kNumber: {
            const auto* number = std::get_if<double>(&value);
            return number != nullptr ? put_number(field, *number, words[0])
                                     : FieldOutcome::kRefused;
        }
        case DeclaredKind::kEnum: {
            const auto at =
                text != nullptr ? std::ranges::find(field.values, *text) : field.values.end();
            if (at == field.values.end()) {
                return FieldOutcome::kRefused;
            }
            words[0] = static_cast<std::uint32_t>(at - field.values.begin());
            return FieldOutcome::kDone;
        }
        case DeclaredKind::kBool: {
            const auto* truth = std::get_if<bool>(&value);
            if (truth == nullptr) {
                return FieldOutcome::kRefused;
            }
            words[0] = *truth ? 1 : 0;
            return FieldOutcome::kDone;
        }
        case DeclaredKind::kText:
            break;
    }
    return text != nullptr && put_text(*text, words) ? FieldOutcome::kDone : FieldOutcome::kRefused;
}

std::string text_of(const DeclaredField& field, std::span<const std::uint32_t> words) {
    const FieldValue value = value_of(field, words);
    if (const auto* number = std::get_if<double>(&value)) {
        char text[40];
        std::snprintf(text, sizeof(text), "%.10g", *number);
        return text;
    }
    if (const auto* truth = std::get_if<bool>(&value)) {
        return *truth ? "true" : "false";
    }
    return std::string(std::get<std::string_view>(value));
}

}  // namespace zoned::wire
