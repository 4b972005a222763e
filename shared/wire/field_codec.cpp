#include "shared/wire/field_codec.h"

#include <type_traits>

namespace zoned::wire {
namespace {

const SizeClasses& classes_of(const Field& field, Coding coding) {
    return coding == Coding::kAbsolute ? field.absolute : field.delta;
}

/// Width of size class `k`; -1 when the class is not in use because the full one is no wider.
int class_bits(const SizeClasses& classes, int k, const RangeLayout& range) {
    if (classes.bits[k] == kFull) {
        return range.full_bits;
    }
    return classes.bits[k] < range.full_bits ? classes.bits[k] : -1;
}

/// value - reference; the shorter difference where the range wraps.
std::int32_t difference(std::int32_t value, std::int32_t reference, const RangeLayout& range) {
    const auto d = static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(reference);
    return range.wraps ? sign_extend(d & low_mask(range.full_bits), range.full_bits)
                       : static_cast<std::int32_t>(d);
}

/// Bits that a signed difference needs: 0 for 0, else two's complement.
int bits_needed(std::int32_t d) {
    if (d == 0) {
        return 0;
    }
    return std::bit_width(static_cast<std::uint32_t>(d < 0 ? ~d : d)) + 1;
}

/// The first size class in use that holds differences of `needed` bits.
int first_class(const SizeClasses& classes, int needed, const RangeLayout& range) {
    int k = 0;
    while (k + 1 < classes.count && class_bits(classes, k, range) < needed) {
        ++k;
    }
    return k;
}

void write_field(BitWriter& writer,
                 const Field& field,
                 const Columns& columns,
                 const Columns& reference,
                 const SizeClasses& classes,
                 const RangeLayout& range) {
    int needed = 0;
    if (classes.count > 1) {
        for (int c = field.first; c < field.first + field.components; ++c) {
            needed = std::max(needed, bits_needed(difference(columns[c], reference[c], range)));
        }
    }
    const int k = first_class(classes, needed, range);
    const int bits = class_bits(classes, k, range);
    writer.write(static_cast<std::uint32_t>(k), classes.selector_bits());
    for (int c = field.first; c < field.first + field.components; ++c) {
        ZONED_ASSERT(columns[c] >= range.minimum && columns[c] <= range.maximum,
                     "a component outside its range");
        const std::int32_t value = classes.bits[k] == kFull
                                       ? columns[c] - range.minimum
                                       : difference(columns[c], reference[c], range);
        writer.write(static_cast<std::uint32_t>(value), bits);
    }
}

/// The value of a component from its bits; outside the range when the bits are malformed.
std::int32_t component(std::uint32_t raw,
                       int bits,
                       bool full,
                       std::int32_t reference,
                       const RangeLayout& range) {
    if (full) {
        return range.minimum + static_cast<std::int32_t>(raw);
    }
    const std::int32_t value = reference + (bits == 0 ? 0 : sign_extend(raw, bits));
    return range.wraps ? static_cast<std::int32_t>(static_cast<std::uint32_t>(value) &
                                                   low_mask(range.full_bits))
                       : value;
}

bool read_field(BitReader& reader,
                const Field& field,
                Columns& columns,
                const Columns& reference,
                const SizeClasses& classes,
                const RangeLayout& range) {
    const auto k = static_cast<int>(reader.read(classes.selector_bits()));
    const int bits = class_bits(classes, k, range);
    if (bits < 0) {
        return false;
    }
    const bool full = classes.bits[k] == kFull;
    int needed = 0;
    for (int c = field.first; c < field.first + field.components; ++c) {
        const std::int32_t value = component(reader.read(bits), bits, full, reference[c], range);
        if (value < range.minimum || value > range.maximum) {
            return false;
        }
        columns[c] = value;
        needed = std::max(needed, bits_needed(difference(value, reference[c], range)));
    }
    return classes.count == 1 || first_class(classes, needed, range) == k;
}

Motion motion_of(const Columns& columns) {
    return static_cast<Motion>(columns[kFields[0].first]);
}

/// Moves over the fields; `bits`, where given, receives the width of each.
template <typename Bits>
bool walk_fields(BitReader& reader,
                 Coding coding,
                 bool upright,
                 const FieldLayout& layout,
                 Bits& bits) {
    auto motion = Motion::kAtRest;
    for (std::size_t f = 0; f < kFields.size(); ++f) {
        const Field& field = kFields[f];
        if (!is_present(field.presence, motion, upright)) {
            continue;
        }
        const SizeClasses& classes = classes_of(field, coding);
        const auto k = static_cast<int>(reader.read(classes.selector_bits()));
        const int width = class_bits(classes, k, layout[field.range]);
        if (width < 0) {
            return false;
        }
        for (int c = 0; c < field.components; ++c) {
            const std::uint32_t raw = reader.read(width);
            if (field.range == Range::kMotion) {
                motion = static_cast<Motion>(raw);
            }
        }
        if constexpr (std::is_same_v<Bits, RecordBits>) {
            bits[f] = static_cast<std::uint16_t>(bits[f] + classes.selector_bits() +
                                                 field.components * width);
        }
    }
    return true;
}

}  // namespace

void write_fields(BitWriter& writer,
                  const Columns& columns,
                  const Columns& reference,
                  Coding coding,
                  bool upright,
                  const FieldLayout& layout) {
    const Motion motion = motion_of(columns);
    for (const Field& field : kFields) {
        if (is_present(field.presence, motion, upright)) {
            write_field(
                writer, field, columns, reference, classes_of(field, coding), layout[field.range]);
        }
    }
}

bool read_fields(BitReader& reader,
                 Columns& columns,
                 const Columns& reference,
                 Coding coding,
                 bool upright,
                 const FieldLayout& layout) {
    columns = Columns{};
    for (const Field& field : kFields) {
        // Motion is the first field, so it is known when the others ask for it.
        if (is_present(field.presence, motion_of(columns), upright) &&
            !read_field(reader,
                        field,
                        columns,
                        reference,
                        classes_of(field, coding),
                        layout[field.range])) {
            return false;
        }
    }
    return is_consistent(columns, upright, layout);
}

bool is_consistent(const Columns& columns, bool upright, const FieldLayout& layout) {
    const QuantizedState state = state_of(columns);
    if (state.floor > state.position[1] && motion_of(columns) == Motion::kBallistic) {
        return false;
    }
    return upright ||
           is_canonical_orientation(
               state.orientation_largest, state.orientation, layout[Range::kSmallestThree].maximum);
}

bool skip_fields(BitReader& reader, Coding coding, bool upright, const FieldLayout& layout) {
    const int nothing = 0;
    return walk_fields(reader, coding, upright, layout, nothing);
}

bool measure_fields(BitReader& reader,
                    Coding coding,
                    bool upright,
                    const FieldLayout& layout,
                    RecordBits& bits) {
    return walk_fields(reader, coding, upright, layout, bits);
}

}  // namespace zoned::wire
