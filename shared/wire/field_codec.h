// Field codec: writes, reads and skips the fields of one record as the field table says.
#pragma once

#include "shared/wire/bit_stream.h"
#include "shared/wire/field_table.h"
#include "shared/wire/traffic.h"

namespace zoned::wire {

/// Which of the two lists of size classes a record uses.
enum class Coding : std::uint8_t {
    kAbsolute,
    kDelta,
};

/// Writes the fields of `columns` as differences to `reference` (all zeros under kAbsolute).
void write_fields(BitWriter& writer,
                  const Columns& columns,
                  const Columns& reference,
                  Coding coding,
                  bool upright,
                  const FieldLayout& layout);

/// Reads what write_fields wrote. False when a value is outside its range, an orientation is not
/// canonical, or a size class is not the first that would have done: equal states have equal bytes.
/// Whether the reader ran out is the reader's own flag.
bool read_fields(BitReader& reader,
                 Columns& columns,
                 const Columns& reference,
                 Coding coding,
                 bool upright,
                 const FieldLayout& layout);

/// Whether columns, each within its range, form a state that quantize() can give: canonical
/// orientations, and no floor above a falling entity.
bool is_consistent(const Columns& columns, bool upright, const FieldLayout& layout);

/// Moves the reader behind the fields; the length does not depend on any reference. False when a
/// size class is not in use; values are not checked.
bool skip_fields(BitReader& reader, Coding coding, bool upright, const FieldLayout& layout);

/// As skip_fields; adds the bits of each field to `bits`.
bool measure_fields(BitReader& reader,
                    Coding coding,
                    bool upright,
                    const FieldLayout& layout,
                    RecordBits& bits);

}  // namespace zoned::wire
