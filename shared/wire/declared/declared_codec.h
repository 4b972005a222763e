// Declared codec: writes, reads and passes over the declared fields of one record.
#pragma once

#include "shared/core/utf8.h"
#include "shared/wire/bit_stream.h"
#include "shared/wire/declared/declared_fields.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::wire {

/// The fields that a record changes.
struct DeclaredUpdate {
    bool whole = false;  ///< the fields that it leaves out have their initial values
    FieldMask mask = 0;
    std::array<std::uint32_t, kMostFieldWords> words{};  ///< as those of an entity; of `mask` alone
};

/// Why the fields of a record were refused.
enum class DeclaredFault : std::uint8_t {
    kNone,
    kForm,   ///< fields where the type has none, none chosen, a longer form than needed
    kRange,  ///< a value beyond its range
    kCut,    ///< a text, or another value, that its part of the record does not hold
    kText,   ///< a text that is no clean UTF-8
};

inline constexpr std::size_t kDeclaredFaults = 5;
inline constexpr std::array<const char*, kDeclaredFaults> kDeclaredFaultTexts{
    "",
    "declared fields in a form that no server writes",
    "a declared field beyond its range",
    "a declared field that is cut off",
    "a declared text that is no clean UTF-8"};

/// Bits of the values of each field in one record; the rest of the part is its head.
using DeclaredBits = std::array<std::uint16_t, kMostDeclared>;

/// Length of the part in bits: one small field takes the first width.
inline constexpr VarintWidths kDeclaredLengths{5, 8, 10, 12};

/// The one walk over the values of a record that encoders and decoders share. `raw(value, bits)`
/// writes the low bits (0..16) of a value and returns them, or ignores it and returns bits read.
template <class Raw>
DeclaredFault code_declared(Raw&& raw,
                            const FieldSchema& schema,
                            FieldMask& mask,
                            std::span<std::uint32_t> words,
                            DeclaredBits* bits = nullptr) {
    const auto count = static_cast<std::uint32_t>(schema.fields().size());
    if (count == 1) {
        mask = 1;
    } else if (raw(std::popcount(mask) > 1 ? 1 : 0, 1) == 0) {
        const auto field = raw(static_cast<std::uint32_t>(std::countr_zero(mask)),
                               static_cast<int>(std::bit_width(count - 1)));
        mask = FieldMask{1} << field;
        if (field >= count) {
            return DeclaredFault::kForm;
        }
    } else {
        const FieldMask chosen = mask;
        mask = 0;
        for (std::uint32_t from = 0; from < count; from += 16) {
            const auto part = raw(static_cast<std::uint32_t>(chosen >> from & 0xFFFFU),
                                  static_cast<int>(std::min(count - from, 16U)));
            mask |= FieldMask{part} << from;
        }
        if (std::popcount(mask) < 2) {
            return DeclaredFault::kForm;
        }
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((mask >> i & 1U) == 0) {
            continue;
        }
        const DeclaredField& field = schema.fields()[i];
        const std::span<std::uint32_t> at = words_of(field, words);
        std::uint16_t taken = field.bits;
        if (field.kind == DeclaredKind::kText) {
            auto* bytes = reinterpret_cast<unsigned char*>(at.data());
            const std::uint32_t length = raw(bytes[0], 5);
            taken = static_cast<std::uint16_t>(5 + 8 * length);
            bytes[0] = static_cast<unsigned char>(length);
            for (std::uint32_t k = 1; k <= length; ++k) {
                bytes[k] = static_cast<unsigned char>(raw(bytes[k], 8));
            }
            std::fill(bytes + 1 + length, bytes + 4 * kTextWords, static_cast<unsigned char>(0));
            if (!core::is_clean_utf8({reinterpret_cast<const char*>(bytes) + 1, length})) {
                return DeclaredFault::kText;
            }
        } else {
            const int low = std::min<int>(field.bits, 16);
            const std::uint32_t code = at[0];
            std::uint32_t read = raw(code, low);
            if (field.bits > low) {
                read |= raw(code >> 16U, field.bits - low) << 16U;
            }
            at[0] = read;
            if (read > field.most) {
                return DeclaredFault::kRange;
            }
        }
        if (bits != nullptr) {
            (*bits)[i] = taken;
        }
    }
    return DeclaredFault::kNone;
}

/// Bits that the fields of `mask`, which is not 0, take, without what says how many these are.
[[nodiscard]] std::uint32_t declared_bits(const FieldSchema& schema,
                                          FieldMask mask,
                                          std::span<const std::uint32_t> words);

/// Writes the part of a shared record: its length, then the fields of `mask`, which is not 0.
void write_declared(BitWriter& writer,
                    const FieldSchema& schema,
                    FieldMask mask,
                    std::span<const std::uint32_t> words);

/// Reads what write_declared wrote. Only canonical parts are accepted. `whole`: the fields that are
/// left out have their initial values, so none that is there has.
DeclaredFault read_declared(BitReader& reader,
                            const FieldSchema& schema,
                            bool whole,
                            DeclaredUpdate& update,
                            DeclaredBits* bits = nullptr);

/// Moves the reader behind the part; false where its length is not canonical.
bool skip_declared(BitReader& reader);

/// Fields of `words` that differ from their initial values.
[[nodiscard]] FieldMask changed_from_initial(const FieldSchema& schema,
                                             std::span<const std::uint32_t> words);

/// The fields of `mask` that have their initial values: none in what a server writes.
[[nodiscard]] inline bool is_whole(const FieldSchema& schema, const DeclaredUpdate& update) {
    const std::span<const std::uint32_t> words(update.words);
    return (changed_from_initial(schema, words) & update.mask) == update.mask;
}

/// Brings the words of an entity up to date; they are made where there are none.
void apply_declared(const FieldSchema& schema,
                    const DeclaredUpdate& update,
                    std::vector<std::uint32_t>& words);

}  // namespace zoned::wire
