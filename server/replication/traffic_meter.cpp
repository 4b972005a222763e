#include "server/replication/traffic_meter.h"

#include "shared/core/assert.h"
#include "shared/wire/publication.h"

namespace zoned::replication {

void TrafficMeter::add_record(StreamIndex index,
                              const Stream& stream,
                              const Encoded& encoded,
                              wire::TrafficReason reason) {
    const std::size_t at = 2 * static_cast<std::size_t>(index) + (encoded.keyframe != 0 ? 1 : 0);
    if (at >= measured_.size()) {
        measured_.resize(2 * at + 2);
    }
    Measured& m = measured_[at];
    const std::uint8_t* bytes = encoded.bytes->data();
    // The tick tells a stream from one that had its place before.
    if (m.version != stream.version || m.tick != stream.tick || m.bytes != bytes ||
        m.entity != stream.entity || m.lod != stream.lod) {
        m.entity = stream.entity;
        m.lod = stream.lod;
        m.version = stream.version;
        m.tick = stream.tick;
        m.bytes = bytes;
        wire::RecordReader reader(*encoded.bytes, quantization_);
        const auto read = reader.measure_next(m.bits);
        ZONED_ASSERT(read.ok() && reader.done(), "own records can be read");
        if (read->declared) {
            m.declared = reader.measured_declared(*wire::schema_of(fields_, stream.type));
        }
    }
    table_.add_record(stream.type, reason, m.bits);
    if (m.bits[wire::kDeclaredPart] > 0) {
        table_.add_declared(*wire::schema_of(fields_, stream.type), m.declared);
    }
}

}  // namespace zoned::replication
