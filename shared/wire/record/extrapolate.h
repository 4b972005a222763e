// Extrapolation: predicts a later publication from an earlier one, as columns of the field table.
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

/// The expected position of an unknown entity: the position of another one.
Columns beside(const CodedRecord& other, std::uint8_t lod, const RecordFormat& format);

}  // namespace zoned::wire::record
