// Declared fields: the fields of its own that a game declares for a type of entities; their kinds,
// ranges and values.
#pragma once

#include "shared/core/ids.h"
#include "shared/core/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace zoned::wire {

enum class DeclaredKind : std::uint8_t {
    kNumber,  ///< a minimum and steps of a quantum
    kEnum,    ///< one of a list of names
    kBool,
    kText,  ///< UTF-8
};

inline constexpr std::size_t kDeclaredKinds = 4;
inline constexpr std::size_t kMostDeclared = 64;  ///< fields of one type
inline constexpr std::size_t kMostFieldNameBytes = 32;
inline constexpr std::size_t kMostTextBytes = 31;
inline constexpr std::size_t kMostEnumValues = 256;
inline constexpr std::uint32_t kMostFieldSteps = (1U << 24U) - 1U;

/// Words of 32 bits that a text takes: its length in bytes, its bytes, zeros.
inline constexpr std::size_t kTextWords = 8;
inline constexpr std::size_t kMostFieldWords = 128;  ///< of the values of one type

/// Fields of one type: bit i is field i of its schema.
using FieldMask = std::uint64_t;

/// Names a field of all types that declare one of this name.
using FieldId = StrongId<struct FieldTag>;

/// FNV-1a of the name; a config with two names of one value is refused.
constexpr FieldId field_id(std::string_view name) {
    std::uint32_t hash = 2166136261U;
    for (const char c : name) {
        hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
    }
    return FieldId(hash != 0 ? hash : 1U);
}

/// A value as rules and games see it: of a number, of a bool, of an enum (its name) or a text. The
/// text is good until the field changes.
using FieldValue = std::variant<double, bool, std::string_view>;

struct DeclaredField {
    std::string name;
    DeclaredKind kind = DeclaredKind::kNumber;
    double minimum = 0.0;             ///< of a number
    double quantum = 1.0;             ///< of a number, > 0
    std::uint32_t most = 1;           ///< greatest code: of a number its steps, else the last value
    std::vector<std::string> values;  ///< of an enum
    std::array<std::uint32_t, kTextWords> initial{};  ///< the first of them; of texts all
    Tick interval = 0;  ///< ticks between two changes that clients hear of, at least

    // Set by FieldSchema::make.
    FieldId id;
    std::uint16_t word = 0;  ///< of the first word of its value
    std::uint8_t words = 1;
    std::uint8_t bits = 1;  ///< of a code
};

// Declarations in code. A mistake in one (an initial value beyond the range, a quantum that does
// not divide it) is found by FieldSchema::make.

/// Values minimum + n * quantum up to `maximum`.
[[nodiscard]] DeclaredField number_field(std::string name,
                                         double minimum,
                                         double maximum,
                                         double quantum,
                                         double initial);
/// One of `values`.
[[nodiscard]] DeclaredField choice_field(std::string name,
                                         std::vector<std::string> values,
                                         std::string_view initial);
[[nodiscard]] DeclaredField flag_field(std::string name, bool initial);
[[nodiscard]] DeclaredField text_field(std::string name, std::string_view initial);

/// The fields of one type, in their order. Immutable.
class FieldSchema {
  public:
    /// Fails with the reason: too many fields or words, a name twice, an empty range, an initial
    /// value that the field cannot have.
    static core::Result<std::shared_ptr<const FieldSchema>> make(std::vector<DeclaredField> fields);

    [[nodiscard]] std::span<const DeclaredField> fields() const { return fields_; }

    /// Words that the values of an entity take together.
    [[nodiscard]] std::size_t words() const { return initial_.size(); }

    [[nodiscard]] std::span<const std::uint32_t> initial() const { return initial_; }

    /// nullptr: the type has none of this name.
    [[nodiscard]] const DeclaredField* find(FieldId id) const {
        for (const DeclaredField& field : fields_) {
            if (field.id == id) {
                return &field;
            }
        }
        return nullptr;
    }

    [[nodiscard]] std::size_t index_of(const DeclaredField& field) const {
        return static_cast<std::size_t>(&field - fields_.data());
    }

  private:
    std::vector<DeclaredField> fields_;
    std::vector<std::uint32_t> initial_;
};

/// By type; null for types without fields. Empty where no type of the world has any.
using FieldSchemas = std::vector<std::shared_ptr<const FieldSchema>>;

/// nullptr: the type has no fields, or there is none.
[[nodiscard]] inline const FieldSchema* schema_of(const FieldSchemas& schemas, TypeIndex type) {
    return type < schemas.size() ? schemas[type].get() : nullptr;
}

enum class FieldOutcome : std::uint8_t {
    kDone,
    kClamped,  ///< a number beyond the range: the nearest end was taken
    kRefused,  ///< another kind, no number, no such value, no clean UTF-8, too long; no such field
};

/// The value in the words of a field.
[[nodiscard]] FieldValue value_of(const DeclaredField& field, std::span<const std::uint32_t> words);

/// Writes a value into the words of a field, rounded to the quantum; nothing where it is refused.
FieldOutcome put_value(const DeclaredField& field,
                       const FieldValue& value,
                       std::span<std::uint32_t> words);

/// For people: "87.5", "true", "walking".
[[nodiscard]] std::string text_of(const DeclaredField& field, std::span<const std::uint32_t> words);

/// The words of one field among those of an entity.
template <class Word>
[[nodiscard]] std::span<Word> words_of(const DeclaredField& field, std::span<Word> all) {
    return all.subspan(field.word, field.words);
}

}  // namespace zoned::wire
