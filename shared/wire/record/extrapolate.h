// Extrapolation: what a publication lets expect of a later one, as columns of the field table.
#pragma once

#include "shared/wire/record/coded_record.h"

namespace zoned::wire::record {

/// The columns that `base` leads to at `tick`, by the quantisation of level `lod`: position and
/// orientation moved on, rates as they were; motion and appearance those of the base. Sums,
/// products and roots alone, so that both sides expect the same to the last bit: an acceleration
/// that turns is taken for a constant one.
Columns extrapolate(const CodedRecord& base,
                    Tick tick,
                    std::uint8_t lod,
                    const RecordFormat& format);

/// Where an entity is expected of which nothing is known: where another one is.
Columns beside(const CodedRecord& other, std::uint8_t lod, const RecordFormat& format);

}  // namespace zoned::wire::record
