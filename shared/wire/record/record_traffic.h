// Record traffic: adds the bytes of a packet of coded records to the traffic meter.
#pragma once

#include "shared/wire/record/coded_record.h"

#include <cstddef>
#include <numeric>

namespace zoned::wire::record {

/// Adds the records of a frame that was measured and whose code takes `bytes`; `reason_of(record)`
/// gives the reason for a record that is no removal.
template <class ReasonOf>
void add_traffic(TrafficTable& table,
                 const RecordFrame& frame,
                 std::size_t bytes,
                 const FieldSchemas& fields,
                 ReasonOf reason_of) {
    std::size_t rest = 8 * bytes;
    for (std::size_t i = 0; i < frame.records.size(); ++i) {
        const CodedRecord& record = frame.records[i];
        const RecordBits& bits = frame.bits[i];
        const auto all = std::accumulate(bits.begin(), bits.end(), std::size_t{0});
        rest -= all;
        if (record.remove) {
            table.add_removal(all);
        } else {
            table.add_record(record.type, reason_of(record), bits);
            const FieldSchema* schema = schema_of(fields, record.type);
            if (schema != nullptr) {
                table.add_declared(*schema, frame.declared_bits[record.declared - 1]);
            }
        }
    }
    table.add_code_head(rest);
}

}  // namespace zoned::wire::record
