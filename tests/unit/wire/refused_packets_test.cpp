// A decoder that refused a packet is in its earlier state, whatever base the packet named.
#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/record/record_codec.h"

#include <gtest/gtest.h>

namespace zoned::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr entropy::PacketNumber kPackets = 7;

/// A head and unrequested bits.
Bytes spoiled_packet(const entropy::KnowledgeHead& head) {
    Bytes out;
    entropy::RangeEncoder coder(out);
    entropy::write_head(coder, head);
    for (int i = 0; i < 40; ++i) {
        coder.encode_raw(0xFFFF, 16);
    }
    coder.finish();
    return out;
}

/// All at once: the head of the last one names the packet that it builds on.
template <class Encoder>
void acknowledge_all_before_the_last(Encoder& encoder, entropy::PacketNumber number) {
    for (entropy::PacketNumber n = 1; number == kPackets && n < kPackets; ++n) {
        encoder.acknowledge(n);
    }
}

/// Calls `attack` with heads that name every subset of the packets before kPackets.
template <class Attack>
void name_all_subsets(Attack&& attack) {
    for (entropy::PacketNumber gap = 1; gap < kPackets; ++gap) {
        for (std::uint64_t learned = 0; learned < 1u << (kPackets - gap - 1); ++learned) {
            attack(spoiled_packet({0, gap, learned}));
        }
    }
    attack(spoiled_packet({1, 0, 0}));
    attack(spoiled_packet({0, 0, 0}));
}

std::vector<record::CodedRecord> some_records(core::Rng& rng, Tick tick, const Quantization& q) {
    std::vector<record::CodedRecord> out;
    for (std::uint32_t e = 1; e <= 12; ++e) {
        record::CodedRecord& r = out.emplace_back();
        r.entity = EntityId(e);
        r.tick = tick;
        r.remove = rng.below(6) == 0;
        if (!r.remove) {
            r.upright = e % 2 == 0;
            r.type = static_cast<TypeIndex>(e % 2);
            r.state = testing::random_quantized(rng, r.upright, q);
        }
    }
    return out;
}

TEST(RefusedPackets, ChangeNothingOfADecoderOfRecords) {
    const record::RecordFormat format(Quantization{}, 1.0F / 30.0F);
    record::RecordEncoder encoder(format);
    record::RecordDecoder decoder(format);
    core::Rng rng(1);
    Bytes last;
    std::vector<record::CodedRecord> told;
    for (entropy::PacketNumber n = 1; n <= kPackets; ++n) {
        last.clear();
        acknowledge_all_before_the_last(encoder, n);
        told = some_records(rng, 100 + static_cast<Tick>(n), format.levels[0].quantization);
        encoder.sent(encoder.encode(n, 100 + static_cast<Tick>(n), ZoneId(1), told, last));
        if (n == kPackets) {
            break;
        }
        ASSERT_TRUE(decoder.decode(n, 100 + static_cast<Tick>(n), ZoneId(1), last));
    }
    int refused = 0;
    name_all_subsets([&](const Bytes& spoiled) {
        record::RecordDecoder victim = decoder;
        if (victim.decode(kPackets, 100 + kPackets, ZoneId(1), spoiled)) {
            return;  // then the state may differ
        }
        ++refused;
        const auto frame = victim.decode(kPackets, 100 + kPackets, ZoneId(1), last);
        ASSERT_TRUE(frame) << frame.error();
        ASSERT_EQ((*frame)->records.size(), told.size());
        for (std::size_t i = 0; i < told.size(); ++i) {
            ASSERT_TRUE((*frame)->records[i].remove == told[i].remove &&
                        (told[i].remove || (*frame)->records[i].state == told[i].state))
                << i;
        }
    });
    EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace zoned::wire
