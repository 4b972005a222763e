// TrafficMeter: counts the use of the bytes in a zone's state packets, record by record.
#pragma once

#include "server/replication/stream_table.h"
#include "shared/wire/traffic.h"

#include <utility>
#include <vector>

namespace zoned::replication {

/// A record is taken apart once for all its copies: encode once, measure once.
class TrafficMeter {
  public:
    TrafficMeter(const wire::Quantization& q, wire::FieldSchemas fields)
        : quantization_(q),
          fields_(std::move(fields)) {}

    /// A copy of the stream's newest publication goes out.
    void add_record(StreamIndex index,
                    const Stream& stream,
                    const Encoded& encoded,
                    wire::TrafficReason reason);

    [[nodiscard]] const wire::TrafficTable& table() const { return table_; }

    [[nodiscard]] wire::TrafficTable& table() { return table_; }

  private:
    /// Of a publication as last sent. Within a version its bytes stay where they are.
    struct Measured {
        EntityId entity;
        std::uint8_t lod = 0;
        std::uint32_t version = 0;
        Tick tick = -1;
        const std::uint8_t* bytes = nullptr;
        wire::RecordBits bits{};
        wire::DeclaredBits declared{};  // where `bits` has any
    };

    wire::Quantization quantization_;
    wire::FieldSchemas fields_;
    wire::TrafficTable table_;
    std::vector<Measured> measured_;  // by stream: the delta, the absolute record
};

}  // namespace zoned::replication
