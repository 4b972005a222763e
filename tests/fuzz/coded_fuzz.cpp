// Fuzzing of the entropy-coded format: records coded for one client.
//
// For all bytes: no decoder crashes or reads outside them. A decoder that refused a packet is in
// the same state as before. Decoded values are within the ranges of the format. An encoder's output
// decodes whole, whatever came in between. The first byte chooses the reader, the rest are actions.
#include "tests/fuzz/coded_streams.h"

#include <algorithm>
#include <optional>

namespace zoned::wire::fuzz {

namespace {

constexpr int kMostPackets = 48;

void check_sound(const record::RecordFrame& frame, const record::RecordFormat& format) {
    EntityId before;
    for (const record::CodedRecord& r : frame.records) {
        ZONED_ASSERT(r.entity > before, "entities ascend");
        before = r.entity;
        if (r.remove) {
            continue;
        }
        ZONED_ASSERT(r.lod < kLods, "a level of detail that there is");
        ZONED_ASSERT(r.tick <= frame.tick && frame.tick - r.tick <= record::kOldestTicks,
                     "a publication is as old as it may be");
        const Quantization& q = format.levels[r.lod].quantization;
        ZONED_ASSERT(quantize(dequantize(r.state, r.upright, q),
                              r.state.order,
                              r.upright,
                              r.state.at_rest,
                              r.state.appearance,
                              q) == r.state,
                     "an accepted state survives the way through floats");
    }
    for (const DeclaredUpdate& update : frame.declared) {
        std::vector<std::uint32_t> words;
        apply_declared(*format.fields.front(), update, words);
        for (const DeclaredField& field : format.fields.front()->fields()) {
            std::array<std::uint32_t, kTextWords> again{};
            const auto at = words_of<const std::uint32_t>(field, words);
            ZONED_ASSERT(put_value(field, value_of(field, at), again) == FieldOutcome::kDone &&
                             std::equal(at.begin(), at.end(), again.begin()),
                         "accepted fields are values that rules can set");
        }
    }
}

/// One decoder gets all packets, and its twin gets only those that the first one accepted. Any
/// change by a refused packet makes them differ, now or later.
class RecordTwins {
  public:
    explicit RecordTwins(const record::RecordFormat& format)
        : format_(format),
          all_(format),
          accepted_(format) {}

    /// Null: refused.
    std::shared_ptr<const record::RecordFrame> decode(entropy::PacketNumber number,
                                                      ZoneId zone,
                                                      Input bytes) {
        const Tick tick = kFirstTick + static_cast<Tick>(number);
        const auto frame = all_.decode(number, tick, zone, bytes);
        if (!frame) {
            return nullptr;
        }
        check_sound(**frame, format_);
        const auto twin = accepted_.decode(number, tick, zone, bytes);
        ZONED_ASSERT(twin, "a refused packet changes nothing of what can be decoded");
        ZONED_ASSERT(same_records((*frame)->records, (*twin)->records),
                     "a refused packet changes nothing of what is decoded");
        return *frame;
    }

  private:
    const record::RecordFormat& format_;
    record::RecordDecoder all_;
    record::RecordDecoder accepted_;
};

/// On by one or two, or back by up to seven.
entropy::PacketNumber next_number(entropy::PacketNumber newest, std::uint8_t what) {
    return what % 4 < 2 ? newest + 1 + what % 4
                        : newest - std::min<entropy::PacketNumber>(newest, what / 32);
}

/// Packets from raw bytes: two bits give the step of the number, the rest of the action's byte
/// gives the zone. No encoder need have written any of it.
std::size_t try_record_packets(Input input, bool coarse, bool declared) {
    // All types have declared fields, or none: raw bytes seldom name one of a few.
    const record::RecordFormat format(
        quantization_for(coarse ? 1 : 0),
        1.0F / 30.0F,
        declared ? FieldSchemas(65536, testing::sample_fields()) : FieldSchemas());
    RecordTwins twins(format);
    zoned::fuzz::Actions actions(input);
    entropy::PacketNumber newest = 0;
    std::size_t accepted = 0;
    std::uint8_t what = 0;
    Input bytes;
    for (int n = 0; n < kMostPackets && actions.next(what, bytes); ++n) {
        const entropy::PacketNumber number = next_number(newest, what);
        newest = std::max(newest, number);
        const ZoneId zone(static_cast<std::uint16_t>(1 + (what / 4) % 2));
        accepted += number != 0 && twins.decode(number, zone, bytes) != nullptr ? 1 : 0;
    }
    return accepted;
}

/// The fate of an encoder's next packet.
enum Fate : std::uint8_t {
    kArrives,
    kIsLost,
    kIsDamaged,  // the action's bytes are laid over it
    kIsDelayed,  // and comes with the next one that arrives
    kFates
};

Bytes damaged(const Bytes& bytes, Input over) {
    Bytes out = bytes;
    if (over.size() < 2) {
        out.resize(out.size() / 2);
        return out;
    }
    const std::size_t at = over[0] % std::max<std::size_t>(out.size(), 1);
    if (over[1] % 4 == 0) {
        out.resize(at);
    }
    for (std::size_t i = 2; i < over.size(); ++i) {
        if (at + i - 2 >= out.size()) {
            out.push_back(over[i]);
        } else {
            out[at + i - 2] = static_cast<std::uint8_t>(out[at + i - 2] ^ over[i]);
        }
    }
    return out;
}

/// An encoder's stream, of which packets are lost, late and damaged.
std::size_t try_record_stream(Input input, bool coarse) {
    const record::RecordFormat format = record_format(coarse);
    RecordStream stream(format, input.empty() ? 0 : input[0]);
    RecordTwins twins(format);
    zoned::fuzz::Actions actions(input);
    std::optional<RecordStream::Packet> delayed;
    bool deceived = false;  // by a readable damaged packet: encoder and decoder no longer agree
    std::size_t accepted = 0;
    std::uint8_t what = 0;
    Input bytes;
    const auto arrive = [&](const RecordStream::Packet& packet, const Bytes& code, bool newest) {
        const bool whole = same_bytes(code, packet.code);
        const auto frame = twins.decode(packet.number, stream.zone(), code);
        ZONED_ASSERT(frame != nullptr || deceived || !newest || !whole,
                     "the newest packet that an encoder wrote can be decoded");
        if (frame == nullptr) {
            return;
        }
        deceived = deceived || !whole;
        ZONED_ASSERT(deceived || same_records(frame->records, packet.records),
                     "what was encoded comes out");
        ++accepted;
        stream.acknowledge(packet.number);
    };
    for (int n = 0; n < kMostPackets && actions.next(what, bytes); ++n) {
        const RecordStream::Packet packet = stream.next(what / kFates);
        switch (what % kFates) {
            case kArrives:
                arrive(packet, packet.code, true);
                if (delayed) {
                    arrive(*delayed, delayed->code, false);
                    delayed.reset();
                }
                break;
            case kIsLost:
                break;
            case kIsDamaged:
                arrive(packet, damaged(packet.code, bytes), true);
                break;
            default:
                delayed = packet;
        }
    }
    return accepted;
}

}  // namespace

std::size_t try_coded(Input input) {
    if (input.empty()) {
        return 0;
    }
    const Input rest = input.subspan(1);
    const bool coarse = (input[0] & 4) != 0;
    const bool declared = (input[0] & 8) != 0;
    return input[0] % 2 == kRecordPackets ? try_record_packets(rest, coarse, declared)
                                          : try_record_stream(rest, coarse);
}

}  // namespace zoned::wire::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    (void)zoned::wire::fuzz::try_coded({data, size});
    return 0;
}

namespace zoned::fuzz {

std::vector<Bytes> seeds() {
    core::Rng rng(1);
    std::vector<Bytes> all;
    for (int i = 0; i < 32; ++i) {
        all.push_back(wire::fuzz::coded_input(static_cast<std::uint8_t>(i % 8), rng));
    }
    for (const Bytes& seed : all) {
        ZONED_ASSERT(wire::fuzz::try_coded(seed) > 0, "of a seed something is accepted");
    }
    // Random bytes seldom hold fields that are sound: most of these are refused.
    std::size_t accepted = 0;
    for (int i = 0; i < 64; ++i) {
        all.push_back(wire::fuzz::coded_input(8, rng));
        accepted += wire::fuzz::try_coded(all.back());
    }
    ZONED_ASSERT(accepted > 0, "of seeds with declared fields something is accepted");
    return all;
}

}  // namespace zoned::fuzz
