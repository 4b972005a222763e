// The bits of records by field: all bits are counted, and each goes to its own field.
#include "shared/wire/traffic.h"

#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/packet.h"
#include "shared/wire/publication.h"

#include <gtest/gtest.h>

#include <numeric>

namespace zoned::wire {
namespace {

std::uint64_t traffic_sum(const RecordBits& bits) {
    return std::accumulate(bits.begin(), bits.end(), std::uint64_t{0});
}

RecordHead traffic_head(std::uint32_t entity) {
    RecordHead head;
    head.entity = EntityId(entity);
    head.keyframe = 3;
    head.tick_low = 77;
    head.type = 2;
    return head;
}

RecordBits measure(const std::vector<std::uint8_t>& bytes, const Quantization& q) {
    RecordReader reader(bytes, q);
    RecordBits bits;
    EXPECT_TRUE(reader.measure_next(bits).ok());
    EXPECT_TRUE(reader.done());
    EXPECT_EQ(reader.byte_offset(), bytes.size());
    return bits;
}

TEST(RecordBits, AddUpToAllBitsOfTheRecord) {
    core::Rng rng(5);
    const Quantization q;
    for (int i = 0; i < 4000; ++i) {
        const bool upright = rng.below(2) != 0;
        const QuantizedState state = testing::random_quantized(rng, upright, q);
        const QuantizedState keyframe = testing::random_quantized(rng, upright, q);
        std::vector<std::uint8_t> bytes;
        const RecordHead head = traffic_head(1 + rng.below(70000));
        if (rng.below(2) != 0) {
            encode_absolute(head, state, upright, q, bytes);
        } else {
            encode_delta(head, state, keyframe, upright, q, bytes);
        }
        const RecordBits bits = measure(bytes, q);
        EXPECT_EQ(traffic_sum(bits), 8 * bytes.size());
        EXPECT_LT(bits[kPaddingPart], 8U);
    }
}

TEST(RecordBits, GoToTheFieldThatChangedAlone) {
    const Quantization q;
    core::Rng rng(6);
    for (std::size_t f = 1; f < kFields.size(); ++f) {
        const Field& field = kFields[f];
        int tried = 0;
        for (int i = 0; i < 4000 && tried < 20; ++i) {
            const bool upright = field.presence == Presence::kUpright ||
                                 field.presence == Presence::kUprightMoving || rng.below(2) != 0;
            const QuantizedState keyframe = testing::random_quantized(rng, upright, q);
            Columns columns = columns_of(keyframe);
            if (!is_present(field.presence, static_cast<Motion>(columns[0]), upright) ||
                field.range == Range::kLeftOut) {
                continue;
            }
            std::int32_t& changed = columns[field.first];
            changed += changed > 0 ? -1 : 1;
            std::vector<std::uint8_t> same;
            std::vector<std::uint8_t> other;
            encode_delta(traffic_head(9), keyframe, keyframe, upright, q, same);
            encode_delta(traffic_head(9), state_of(columns), keyframe, upright, q, other);
            RecordBits before = measure(same, q);
            const RecordBits after = measure(other, q);
            EXPECT_GT(after[f], before[f]) << field.name;
            before[f] = after[f];
            before[kPaddingPart] = after[kPaddingPart];
            EXPECT_EQ(before, after) << field.name;
            ++tried;
        }
        EXPECT_GT(tried, field.range == Range::kLeftOut ? -1 : 0) << field.name;
    }
}

TEST(RecordBits, OfARemovalAreHeadAlone) {
    std::vector<std::uint8_t> bytes;
    encode_remove(EntityId(300), bytes);
    const RecordBits bits = measure(bytes, Quantization{});
    EXPECT_EQ(bits[kRecordHeadPart], 8 * bytes.size());
    EXPECT_EQ(traffic_sum(bits), 8 * bytes.size());
}

TEST(DownHeadBytes, AreThoseOfTheHeadWithoutTheOwnState) {
    for (const std::uint32_t zone : {1U, 31U, 32U, 4095U, 4096U, 65535U}) {
        for (const bool widened : {false, true}) {
            DownHead head;
            head.tick = 1000;
            head.zone = ZoneId(static_cast<std::uint16_t>(zone));
            head.has_widened = widened;
            std::vector<std::uint8_t> out;
            write_down_head(head, out);
            EXPECT_EQ(down_head_bytes(head), out.size());
        }
    }
}

TEST(TrafficText, NamesTypesReasonsAndFieldsInDescendingOrder) {
    TrafficTable table;
    RecordBits bits{};
    bits[kRecordHeadPart] = 24;
    bits[1] = 40;
    for (int i = 0; i < 10; ++i) {
        table.add_record(1, TrafficReason::kUpdate, bits);
    }
    table.add_record(0, TrafficReason::kJoin, bits);
    table.add_packet(7, 2);
    const std::vector<std::string> types{"walker", "crate"};
    EXPECT_EQ(table.bits(), 11U * 64 + 7 * 8);
    EXPECT_EQ(table.bits(TrafficReason::kUpdate), 640U);
    EXPECT_EQ(table.bits_of_part(1), 440U);
    const std::string text = traffic_text(table, types, 2.0, 62);
    EXPECT_LT(text.find("crate"), text.find("walker")) << text;
    EXPECT_LT(text.find("position_xz"), text.find("record_head")) << text;
    EXPECT_NE(text.find("news 100 %"), std::string::npos) << text;
    EXPECT_NE(text.find("seal and headers"), std::string::npos) << text;
    // 11 records of 8 bytes, a head of 7, 62 around, in two seconds.
    EXPECT_NE(text.find("78 B/s"), std::string::npos) << text;
    EXPECT_TRUE(traffic_text(TrafficTable{}, types, 2.0, 62).empty());
}

}  // namespace
}  // namespace zoned::wire
