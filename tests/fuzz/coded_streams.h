// Coded streams: entropy-coded packets for their fuzzer, with entities and valid inputs.
#pragma once

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/wire_input.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/core/assert.h"
#include "shared/wire/record/record_codec.h"

#include <map>
#include <memory>
#include <utility>

namespace zoned::wire::fuzz {

/// The targets that the first byte of an input chooses, by its lowest bit.
enum CodedInput : std::uint8_t {
    kRecordPackets,
    kRecordStream,
};

inline constexpr Tick kFirstTick = 5000;  // of packet 0: publications may be old

inline record::RecordFormat record_format(bool coarse) {
    return record::RecordFormat(quantization_for(coarse ? 1 : 0), 1.0F / 30.0F);
}

inline bool same_records(const std::vector<record::CodedRecord>& a,
                         const std::vector<record::CodedRecord>& b) {
    return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
        return x.entity == y.entity && x.remove == y.remove &&
               (x.remove || (x.lod == y.lod && x.type == y.type && x.upright == y.upright &&
                             x.tick == y.tick && x.state == y.state));
    });
}

/// Walkers, balls and entities that jump about, sent by an encoder packet by packet.
class RecordStream {
  public:
    struct Packet {
        entropy::PacketNumber number = 0;
        std::vector<record::CodedRecord> records;
        Bytes code;
    };

    RecordStream(const record::RecordFormat& format, std::uint64_t seed)
        : format_(format),
          encoder_(format),
          rng_(seed) {}

    [[nodiscard]] ZoneId zone() const { return ZoneId(1); }

    /// Sends records of up to `most` entities.
    Packet next(std::uint32_t most) {
        Packet packet;
        packet.number = ++number_;
        const Tick tick = kFirstTick + static_cast<Tick>(number_);
        std::map<EntityId, record::CodedRecord> chosen;
        for (std::uint32_t n = 0; n < std::min(most, 24u); ++n) {
            const EntityId entity(1 + rng_.below(30) + (rng_.below(20) == 0 ? 0xFFFFF000u : 0u));
            chosen[entity] = tell(entity, tick);
        }
        for (const auto& [entity, r] : chosen) {
            packet.records.push_back(r);
        }
        encoder_.sent(encoder_.encode(packet.number, tick, zone(), packet.records, packet.code));
        return packet;
    }

    void acknowledge(entropy::PacketNumber number) { encoder_.acknowledge(number); }

  private:
    record::CodedRecord tell(EntityId entity, Tick tick) {
        record::CodedRecord r;
        r.entity = entity;
        r.remove = rng_.below(12) == 0;
        if (r.remove) {
            return r;
        }
        r.type = static_cast<TypeIndex>(entity.value % 4);
        r.upright = r.type < 2;
        r.lod = static_cast<std::uint8_t>(rng_.below(8) == 0 ? rng_.below(kLods) : 0);
        r.tick = tick - static_cast<Tick>(rng_.below(6) == 0 ? rng_.below(4000) : rng_.below(2));
        const Quantization& q = format_.levels[r.lod].quantization;
        if (r.type % 2 == 0) {
            r.state = testing::random_quantized(rng_, r.upright, q);
            return r;
        }
        // Moves every entity on with its motion unchanged.
        const float at_s = static_cast<float>(r.tick - kFirstTick) / 30.0F;
        motion::KinematicState s;
        s.velocity = Vec3(2.0F, 0.0F, -1.0F);
        s.angular_velocity = Vec3(0.0F, 0.5F, 0.0F);
        s.position = Vec3(static_cast<float>(entity.value % 64), 2.0F, 5.0F) + at_s * s.velocity;
        s.orientation = Quat(1.0F, 0.0F, 0.25F * at_s, 0.0F).normalized();
        // Tumbling ones are sent without their velocity.
        const auto order =
            r.upright ? motion::PredictorOrder::kLinear : motion::PredictorOrder::kStatic;
        r.state = quantize(s, order, r.upright, false, 3, q);
        return r;
    }

    const record::RecordFormat& format_;
    record::RecordEncoder encoder_;
    core::Rng rng_;
    entropy::PacketNumber number_ = 0;
};

/// A valid input of the kind that `first` chooses.
inline Bytes coded_input(std::uint8_t first, core::Rng& rng) {
    using zoned::fuzz::Actions;
    Bytes out{first};
    if (first % 2 == kRecordPackets) {
        const record::RecordFormat format = record_format((first & 4) != 0);
        RecordStream stream(format, rng.next());
        for (int n = 0; n < 12; ++n) {
            const RecordStream::Packet packet = stream.next(1 + rng.below(10));
            // Of zone 1, each numbered behind the one before.
            Actions::add(0, packet.code, out);
            stream.acknowledge(packet.number);
        }
    } else {
        for (int n = 0; n < 30; ++n) {
            Bytes over;
            for (std::uint32_t i = rng.below(8); i > 0; --i) {
                over.push_back(static_cast<std::uint8_t>(rng.below(256)));
            }
            Actions::add(static_cast<std::uint8_t>(rng.below(256)), over, out);
        }
        Actions::add(4 * 8, Bytes(), out);
    }
    return out;
}

}  // namespace zoned::wire::fuzz
