// build: computes
#include "tests/unit/allocation_count.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/core/rng.h"
#include "shared/wire/record/record_codec.h"
#include "shared/wire/record/record_traffic.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace zoned::wire::record {
namespace {

using testing::quantizations;
using testing::random_quantized;

constexpr ZoneId kZone(1);

bool same(const CodedRecord& a, const CodedRecord& b) {
    return a.entity == b.entity && a.remove == b.remove &&
           (a.remove || (a.lod == b.lod && a.type == b.type && a.upright == b.upright &&
                         a.tick == b.tick && a.state == b.state));
}

/// Publications of unpredictable entities: every field anew each time.
class Chaos {
  public:
    Chaos(const RecordFormat& format, std::uint64_t seed) : format_(format), rng_(seed) {}

    std::vector<CodedRecord> records(Tick tick, std::uint32_t most) {
        std::map<std::uint32_t, CodedRecord> chosen;
        for (std::uint32_t count = rng_.below(most + 1); count > 0; --count) {
            CodedRecord r;
            const bool far = rng_.below(20) == 0;
            r.entity = EntityId(1 + (far ? 0xFFFFFF00u : 0u) + rng_.below(80));
            r.remove = rng_.below(10) == 0;
            if (!r.remove) {
                r.lod = static_cast<std::uint8_t>(rng_.below(kLods));
                // A type may change: then nothing that is known helps.
                r.type = static_cast<TypeIndex>(r.entity.value % 5 + (rng_.below(50) == 0 ? 5 : 0));
                r.upright = r.type % 2 == 0;
                r.tick = tick - static_cast<Tick>(rng_.below(4) == 0 ? rng_.below(60) : 0);
                r.state = random_quantized(rng_, r.upright, format_.levels[r.lod].quantization);
            }
            chosen[r.entity.value] = r;
        }
        std::vector<CodedRecord> out;
        for (const auto& [entity, record] : chosen) {
            out.push_back(record);
        }
        return out;
    }

  private:
    const RecordFormat& format_;
    core::Rng rng_;
};

TEST(RecordCodec, ReturnsEveryRecordWhateverIsLostOrLate) {
    core::Rng rng(1);
    for (const Quantization& q : quantizations()) {
        const RecordFormat format(q, 1.0F / 30.0F);
        Chaos chaos(format, 2);
        RecordEncoder encoder(format);
        RecordDecoder decoder(format);
        std::map<entropy::PacketNumber, std::vector<CodedRecord>> truth;
        std::multimap<Tick, std::pair<entropy::PacketNumber, std::vector<std::uint8_t>>> down;
        std::multimap<Tick, std::set<entropy::PacketNumber>> up;
        std::set<entropy::PacketNumber> received;
        int decoded = 0;
        for (Tick tick = 100; tick < 900; ++tick) {
            for (; !up.empty() && up.begin()->first <= tick; up.erase(up.begin())) {
                for (const entropy::PacketNumber n : up.begin()->second) {
                    encoder.acknowledge(n);
                }
            }
            const auto number = static_cast<entropy::PacketNumber>(tick - 99);
            truth[number] = chaos.records(tick, 25);
            std::vector<std::uint8_t> bytes;
            encoder.sent(encoder.encode(number, tick, kZone, truth[number], bytes));
            if (rng.below(10) != 0) {
                down.emplace(tick + 2 + rng.below(5), std::pair(number, bytes));
            }
            for (; !down.empty() && down.begin()->first <= tick; down.erase(down.begin())) {
                const auto& [n, code] = down.begin()->second;
                const auto frame = decoder.decode(n, 99 + static_cast<Tick>(n), kZone, code);
                ASSERT_TRUE(frame) << frame.error() << " packet " << n;
                ASSERT_EQ((*frame)->records.size(), truth[n].size());
                for (std::size_t i = 0; i < truth[n].size(); ++i) {
                    ASSERT_TRUE(same((*frame)->records[i], truth[n][i])) << n << " " << i;
                }
                received.insert(n);
                ++decoded;
            }
            while (received.size() > 32) {
                received.erase(received.begin());
            }
            if (rng.below(10) != 0) {
                up.emplace(tick + 2 + rng.below(5), received);
            }
        }
        EXPECT_GT(decoded, 650);
    }
}

TEST(RecordCodec, TellsWhatGoesOnAsBeforeInAFewBits) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    std::size_t last = 0;
    for (Tick tick = 1; tick < 400; ++tick) {
        std::vector<CodedRecord> records;
        for (std::uint32_t e = 1; e <= 40; ++e) {
            CodedRecord r;
            r.entity = EntityId(e);
            r.tick = tick;
            r.upright = true;
            r.state.order = motion::PredictorOrder::kLinear;
            // 1.875 m/s are 120 steps of velocity and 6.25 steps of position a tick.
            r.state.velocity = {120, 0, 0};
            r.state.position = {
                static_cast<std::int32_t>((tick * 25) / 4) + static_cast<std::int32_t>(e) * 100,
                90,
                -500};
            r.state.orientation = {static_cast<std::int32_t>(e), 0, 0};
            records.push_back(r);
        }
        std::vector<std::uint8_t> bytes;
        encoder.sent(
            encoder.encode(static_cast<entropy::PacketNumber>(tick), tick, kZone, records, bytes));
        ASSERT_TRUE(decoder.decode(static_cast<entropy::PacketNumber>(tick), tick, kZone, bytes));
        encoder.acknowledge(static_cast<entropy::PacketNumber>(tick));
        last = bytes.size();
    }
    // A record has 9 decisions: kind, entity, age, level, motion, 2 x position, 2 velocities, yaw
    // and its rate, appearance. They are nearly sure but for the rounding of one position: below 3
    // bits. An absolute record takes 17 bytes.
    EXPECT_LT(last, 40u * 3u / 8u + 4u);
}

TEST(RecordCodec, StaysWholeWhateverBytesCome) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    Chaos chaos(format, 3);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    core::Rng rng(4);
    int refused = 0;
    for (Tick tick = 100; tick < 500; ++tick) {
        const auto number = static_cast<entropy::PacketNumber>(tick);
        std::vector<std::uint8_t> bytes;
        encoder.sent(encoder.encode(number, tick, kZone, chaos.records(tick, 20), bytes));
        for (int i = 0; i < 4; ++i) {
            RecordDecoder victim = decoder;
            const std::vector<std::uint8_t> changed = testing::spoiled(bytes, i, rng);
            const auto frame = victim.decode(number, tick, kZone, changed);
            refused += frame ? 0 : 1;
            if (frame) {
                for (const CodedRecord& r : (*frame)->records) {
                    ASSERT_TRUE(r.entity);
                    ASSERT_LE(r.tick, tick);
                    ASSERT_GE(r.tick, tick - kOldestTicks);
                    if (!r.remove) {
                        // Any output of quantize() survives being dequantised.
                        const Quantization& q = format.levels[r.lod].quantization;
                        ASSERT_EQ(quantize(dequantize(r.state, r.upright, q),
                                           r.state.order,
                                           r.upright,
                                           r.state.at_rest,
                                           r.state.appearance,
                                           q),
                                  r.state);
                    }
                }
            }
        }
        ASSERT_TRUE(decoder.decode(number, tick, kZone, bytes));
        encoder.acknowledge(number);
    }
    EXPECT_GT(refused, 800);
}

/// A few entities, sent anew in each packet, so that every state of knowledge has other bases.
std::vector<CodedRecord> walkers(const RecordFormat& format, core::Rng& rng, Tick tick) {
    std::vector<CodedRecord> records;
    for (std::uint32_t e = 1; e <= 6; ++e) {
        CodedRecord& r = records.emplace_back();
        r.entity = EntityId(e);
        r.tick = tick;
        r.state = random_quantized(rng, false, format.levels[0].quantization);
    }
    return records;
}

TEST(RecordCodec, FindsTheBasesOfPacketsThatAreLateByManyAcknowledgements) {
    // Acknowledgements come in lumps of five packets, so that packets which are late by a few
    // states of knowledge are late by many learned packets.
    constexpr entropy::PacketNumber kLump = 5;
    // The decoder keeps sixteen states of knowledge: so late a packet refers to the oldest of them.
    constexpr entropy::PacketNumber kLatest = 15 * kLump;
    for (entropy::PacketNumber late_by = 1; late_by <= kLatest + kLump + 1; ++late_by) {
        const RecordFormat format(Quantization{}, 1.0F / 60.0F);
        RecordEncoder encoder(format);
        RecordDecoder decoder(format);
        core::Rng rng(6);
        const entropy::PacketNumber late = 40;
        std::vector<std::uint8_t> late_bytes;
        std::vector<CodedRecord> late_records;
        for (entropy::PacketNumber n = 1; n <= late + late_by; ++n) {
            const auto tick = static_cast<Tick>(n);
            std::vector<CodedRecord> records = walkers(format, rng, tick);
            std::vector<std::uint8_t> bytes;
            encoder.sent(encoder.encode(n, tick, kZone, records, bytes));
            if (n == late) {
                late_bytes = bytes;
                late_records = records;
            } else {
                ASSERT_TRUE(decoder.decode(n, tick, kZone, bytes));
            }
            for (entropy::PacketNumber a = n - kLump + 1; n % kLump == 0 && a <= n; ++a) {
                if (a != late) {
                    encoder.acknowledge(a);
                }
            }
        }
        const auto frame = decoder.decode(late, static_cast<Tick>(late), kZone, late_bytes);
        if (late_by > kLatest) {
            EXPECT_FALSE(frame) << "late by " << late_by;
            continue;
        }
        ASSERT_TRUE(frame) << frame.error() << ", late by " << late_by;
        ASSERT_EQ((*frame)->records.size(), late_records.size());
        for (std::size_t i = 0; i < late_records.size(); ++i) {
            ASSERT_TRUE(same((*frame)->records[i], late_records[i])) << "late by " << late_by;
        }
    }
}

/// A hundred at a time come, are sent in each tick, and go. Each keeps `packets` publications.
void expect_forgotten(motion::PredictorOrder order, std::size_t packets) {
    constexpr std::uint32_t kAtATime = 100;
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    core::Rng rng(7);
    for (Tick tick = 1; tick <= 2000; ++tick) {
        const auto first = static_cast<std::uint32_t>(tick);
        std::vector<CodedRecord> records;
        for (std::uint32_t e = first; e <= first + kAtATime; ++e) {
            CodedRecord& r = records.emplace_back();
            r.entity = EntityId(e);
            r.tick = tick;
            r.remove = e == first;
            r.state = quantize(testing::random_motion(rng, format.levels[0].quantization),
                               order,
                               false,
                               false,
                               0,
                               format.levels[0].quantization);
        }
        const auto number = static_cast<entropy::PacketNumber>(tick);
        std::vector<std::uint8_t> bytes;
        encoder.sent(encoder.encode(number, tick, kZone, records, bytes));
        ASSERT_TRUE(decoder.decode(number, tick, kZone, bytes));
        encoder.acknowledge(number);
        // The encoder codes by one state of knowledge; the decoder keeps sixteen, which here
        // differ by one packet each.
        ASSERT_LE(encoder.known(), packets * kAtATime);
        ASSERT_LE(decoder.known(), (packets + 15) * (kAtATime + 1));
    }
}

TEST(RecordCodec, ForgetsWhatNoPacketCanReferTo) {
    expect_forgotten(motion::PredictorOrder::kLinear, 1);
}

TEST(RecordCodec, ForgetsPlacesFromWhichNoCourseIsFollowed) {
    expect_forgotten(motion::PredictorOrder::kStatic, CourseKnowledge::kPackets);
}

TEST(RecordCodec, AllocatesNothingOnceItIsWarm) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    core::Rng rng(9);
    std::vector<std::uint8_t> bytes;
    std::uint64_t warm = 0;
    for (entropy::PacketNumber n = 1; n <= 400; ++n) {
        const auto tick = static_cast<Tick>(n);
        std::vector<CodedRecord> records = walkers(format, rng, tick);
        // Others come and go.
        CodedRecord& passing = records.emplace_back();
        passing.entity = EntityId(100 + n % 7);
        passing.remove = n % 3 == 0;
        passing.tick = tick;
        // A frame's first record on a course takes memory: see Course.AllocatesNothingOnceItIsWarm.
        for (CodedRecord& r : records) {
            r.state.at_rest = r.state.at_rest || moves(r);
        }
        bytes.clear();
        const std::uint64_t before = allocation_count();
        encoder.sent(encoder.encode(n, tick, kZone, records, bytes));
        if (n > 8) {
            encoder.acknowledge(n - 8);
        }
        // Ten times as many packets as are ever in flight.
        warm += n > 80 ? allocation_count() - before : 0;
    }
    EXPECT_EQ(warm, 0u);
}

TEST(RecordCodec, TellsWhatEachRecordTookAlikeOnBothSides) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    Chaos chaos(format, 10);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    for (Tick tick = 100; tick < 300; ++tick) {
        const auto number = static_cast<entropy::PacketNumber>(tick - 99);
        std::vector<std::uint8_t> bytes;
        const std::vector<CodedRecord> records = chaos.records(tick, 25);
        const auto sent = encoder.encode(number, tick, kZone, records, bytes, true);
        encoder.sent(sent);
        const auto came = decoder.decode(number, tick, kZone, bytes, true);
        ASSERT_TRUE(came);
        encoder.acknowledge(number);
        ASSERT_EQ(sent->bits, (*came)->bits);
        ASSERT_EQ(sent->bits.size(), records.size());
        TrafficTable table;
        add_traffic(table, *sent, bytes.size(), format.fields, [](const CodedRecord& record) {
            EXPECT_FALSE(record.remove);
            return TrafficReason::kUpdate;
        });
        EXPECT_EQ(table.bits(), 8 * bytes.size());
        EXPECT_GT(table.bits_of_part(kCodeHeadPart), 0U);
    }
}

TEST(RecordCodec, GivesBitsToTheFieldsThatCannotBeExpected) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    core::Rng rng(11);
    std::vector<std::uint8_t> bytes;
    std::array<int, kRecordParts> sum{};
    for (entropy::PacketNumber n = 1; n <= 200; ++n) {
        CodedRecord r;
        r.entity = EntityId(5);
        r.tick = static_cast<Tick>(n);
        r.upright = true;
        r.state.orientation = {static_cast<std::int32_t>(rng.below(256)), 0, 0};
        bytes.clear();
        const auto frame = encoder.encode(n, r.tick, kZone, std::span(&r, 1), bytes, true);
        encoder.sent(frame);
        encoder.acknowledge(n);
        for (std::size_t part = 0; n > 100 && part < sum.size(); ++part) {
            sum[part] += frame->bits[0][part];
        }
    }
    // A yaw of 8 random bits takes no less in each of the last hundred packets (apart from chance),
    // and less than two more while its model still learns. The unchanged fields are five decisions
    // (motion, three coordinates, appearance). Each has a probability of 1 - 15/16 (127/128)^n at
    // least after n packets, 0.71 on average: half a bit.
    int others = 0;
    for (std::size_t f = 0; f < kFields.size(); ++f) {
        if (kFields[f].range == Range::kYaw) {
            EXPECT_GT(sum[f], 780);
            EXPECT_LT(sum[f], 1000);
        } else {
            others += sum[f];
        }
    }
    EXPECT_LT(others, 250);
}

TEST(RecordCodec, KeepsCopiesOfADecoderApart) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    core::Rng rng(8);
    std::vector<std::uint8_t> bytes;
    const auto tell = [&](entropy::PacketNumber n) {
        bytes.clear();
        const auto tick = static_cast<Tick>(n);
        encoder.sent(encoder.encode(n, tick, kZone, walkers(format, rng, tick), bytes));
        encoder.acknowledge(n);
    };
    tell(1);
    ASSERT_TRUE(decoder.decode(1, 1, kZone, bytes));
    tell(2);
    const std::vector<std::uint8_t> second = bytes;
    RecordDecoder ahead = decoder;
    ASSERT_TRUE(ahead.decode(2, 2, kZone, second));
    for (entropy::PacketNumber n = 3; n < 100; ++n) {
        tell(n);
        ASSERT_TRUE(ahead.decode(n, static_cast<Tick>(n), kZone, bytes));
    }
    EXPECT_TRUE(decoder.decode(2, 2, kZone, second));
}

TEST(RecordCodec, LearnsWhereItBeginsInTheMiddleOfAStreamAndAcknowledgementsAreLate) {
    // A client that is coded for from its thousandth packet on; each is acknowledged six later.
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    core::Rng rng(12);
    for (entropy::PacketNumber n = 1000; n < 1200; ++n) {
        const auto tick = static_cast<Tick>(n);
        std::vector<std::uint8_t> bytes;
        encoder.sent(encoder.encode(n, tick, kZone, walkers(format, rng, tick), bytes));
        ASSERT_TRUE(decoder.decode(n, tick, kZone, bytes)) << n;
        ASSERT_EQ(encoder.epoch(), 0) << "at packet " << n << " it forgot what it had learned";
        if (n >= 1006) {
            encoder.acknowledge(n - 6);
        }
    }
    EXPECT_GT(encoder.known(), 0U);
}

TEST(RecordCodec, RefusesWhatBuildsOnPacketsThatNeverCame) {
    const RecordFormat format(Quantization{}, 1.0F / 30.0F);
    Chaos chaos(format, 5);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    std::vector<std::uint8_t> bytes;
    encoder.sent(encoder.encode(1, 101, kZone, chaos.records(101, 20), bytes));
    encoder.acknowledge(1);  // a mistake of the network code: it was lost
    bytes.clear();
    encoder.sent(encoder.encode(2, 102, kZone, chaos.records(102, 20), bytes));
    EXPECT_FALSE(decoder.decode(2, 102, kZone, bytes));
}

}  // namespace
}  // namespace zoned::wire::record
