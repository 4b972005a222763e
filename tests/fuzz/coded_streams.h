// Coded streams: entropy-coded packets for their fuzzer, with entities and valid inputs.
#pragma once

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/wire_input.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/core/assert.h"
#include "shared/wire/record/record_codec.h"
#include "shared/wire/snapshot/orientation_coder.h"
#include "shared/wire/snapshot/snapshot_codec.h"

#include <map>
#include <memory>
#include <utility>

namespace zoned::wire::fuzz {

/// The targets that the first byte of an input chooses, by its two lowest bits.
enum CodedInput : std::uint8_t {
    kRecordPackets,
    kRecordStream,
    kSnapshots,
    kOrientations,
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
        r.state = quantize(s, motion::PredictorOrder::kLinear, r.upright, false, 3, q);
        return r;
    }

    const record::RecordFormat& format_;
    record::RecordEncoder encoder_;
    core::Rng rng_;
    entropy::PacketNumber number_ = 0;
};

inline snapshot::SnapshotFormat snapshot_format() {
    snapshot::SnapshotFormat format;
    format.bodies = 12;
    format.orientation_bits = 9;
    format.minimum = {-5000, -5000, 0};
    format.maximum = {5000, 5000, 3000};
    return format;
}

inline void check_sample(const snapshot::BodySample& body, const snapshot::SnapshotFormat& format) {
    ZONED_ASSERT(body.left_out < 4 && body.mark < 2, "within the format");
    for (std::size_t i = 0; i < 3; ++i) {
        ZONED_ASSERT(body.orientation[i] >= 0 && body.orientation[i] < 1 << format.orientation_bits,
                     "within the format");
        ZONED_ASSERT(body.position[i] >= format.minimum[i] && body.position[i] <= format.maximum[i],
                     "within the format");
    }
}

inline snapshot::BodySample random_sample(core::Rng& rng, const snapshot::SnapshotFormat& format) {
    snapshot::BodySample body;
    const Quat q = testing::random_rotation(rng);
    const snapshot::Rotation rotation{q.w(), q.x(), q.y(), q.z()};
    body.left_out = static_cast<std::uint8_t>(snapshot::greatest_component(rotation));
    body.orientation =
        snapshot::quantize_rotation(rotation, body.left_out, format.orientation_bits);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto range = static_cast<std::uint32_t>(format.maximum[i] - format.minimum[i] + 1);
        body.position[i] = format.minimum[i] + static_cast<std::int32_t>(rng.below(range));
    }
    body.mark = static_cast<std::uint8_t>(rng.below(2));
    return body;
}

/// Bodies that drift, some of which jump now and then.
inline void move_bodies(snapshot::Snapshot& bodies,
                        core::Rng& rng,
                        const snapshot::SnapshotFormat& format) {
    for (snapshot::BodySample& body : bodies) {
        if (rng.below(10) == 0) {
            body = random_sample(rng, format);
        } else if (rng.below(2) == 0) {
            body.position[0] = std::min(body.position[0] + 7, format.maximum[0]);
            body.position[2] = std::max(body.position[2] - 3, format.minimum[2]);
            body.mark = 1;
        }
    }
}

/// A valid input of the kind that `first` chooses.
inline Bytes coded_input(std::uint8_t first, core::Rng& rng) {
    using zoned::fuzz::Actions;
    Bytes out{first};
    if (first % 4 == kRecordPackets) {
        const record::RecordFormat format = record_format((first & 4) != 0);
        RecordStream stream(format, rng.next());
        for (int n = 0; n < 12; ++n) {
            const RecordStream::Packet packet = stream.next(1 + rng.below(10));
            // Of zone 1, each numbered behind the one before.
            Actions::add(0, packet.code, out);
            stream.acknowledge(packet.number);
        }
    } else if (first % 4 == kRecordStream) {
        for (int n = 0; n < 30; ++n) {
            Bytes over;
            for (std::uint32_t i = rng.below(8); i > 0; --i) {
                over.push_back(static_cast<std::uint8_t>(rng.below(256)));
            }
            Actions::add(static_cast<std::uint8_t>(rng.below(256)), over, out);
        }
        Actions::add(4 * 8, Bytes(), out);
    } else if (first % 4 == kSnapshots) {
        const snapshot::SnapshotFormat format = snapshot_format();
        snapshot::SnapshotEncoder encoder(format);
        snapshot::Snapshot bodies;
        for (std::uint32_t i = 0; i < format.bodies; ++i) {
            bodies.push_back(random_sample(rng, format));
        }
        for (snapshot::FrameNumber number = 1; number <= 12; ++number) {
            Bytes code;
            encoder.encode(number, bodies, code);
            Actions::add(0, code, out);
            encoder.acknowledge(number);
            move_bodies(bodies, rng, format);
        }
    } else {
        snapshot::SnapshotFormat format;
        const std::uint32_t choice = rng.below(14);
        format.orientation_bits = 2 + static_cast<int>(choice);
        out.push_back(static_cast<std::uint8_t>(choice));
        snapshot::OrientationCoder coder(format.orientation_bits);
        entropy::RangeEncoder writer(out);
        snapshot::BodySample base;
        for (int n = 0; n < 40; ++n) {
            const snapshot::BodySample next = rng.below(3) == 0 ? random_sample(rng, format) : base;
            coder.encode(writer, base, next);
            base = next;
        }
        writer.finish();
    }
    return out;
}

}  // namespace zoned::wire::fuzz
