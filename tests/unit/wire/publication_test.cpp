#include "shared/wire/publication.h"

#include "tests/unit/wire/wire_samples.h"

#include <gtest/gtest.h>

namespace zoned::wire {
namespace {

using testing::quantizations;
using testing::random_quantized;
using Bytes = std::vector<std::uint8_t>;

RecordHead random_head(core::Rng& rng) {
    RecordHead head;
    head.entity = EntityId(std::max(1u, rng.next() >> rng.below(32)));
    head.lod = static_cast<std::uint8_t>(rng.below(kLods));
    head.keyframe = static_cast<std::uint8_t>(rng.below(kKeyframeNumbers));
    head.tick_low = static_cast<std::uint8_t>(rng.below(256));
    head.type = static_cast<TypeIndex>((rng.next() >> 16) >> rng.below(17));
    return head;
}

void expect_same_head(const RecordHead& a, const RecordHead& b, RecordKind kind) {
    ASSERT_EQ(a.kind, kind);
    ASSERT_EQ(a.entity, b.entity);
    ASSERT_EQ(a.lod, b.lod);
    ASSERT_EQ(a.keyframe, b.keyframe);
    ASSERT_EQ(a.tick_low, b.tick_low);
    ASSERT_EQ(a.type, kind == RecordKind::kAbsolute ? b.type : 0);
}

TEST(Records, GiveBackRandomStatesOneAfterAnother) {
    core::Rng rng(1);
    for (const Quantization& q : quantizations()) {
        for (int packet = 0; packet < 2'000; ++packet) {
            struct Written {
                RecordKind kind;
                RecordHead head;
                QuantizedState state;
                QuantizedState keyframe;
                bool upright;
            };

            std::vector<Written> written;
            Bytes bytes;
            for (int i = 0; i < 12; ++i) {
                const bool upright = rng.below(2) != 0;
                Written w{static_cast<RecordKind>(rng.below(3)),
                          random_head(rng),
                          random_quantized(rng, upright, q),
                          random_quantized(rng, upright, q),
                          upright};
                const std::size_t before = bytes.size();
                if (w.kind == RecordKind::kAbsolute) {
                    encode_absolute(w.head, w.state, upright, q, bytes);
                } else if (w.kind == RecordKind::kDelta) {
                    encode_delta(w.head, w.state, w.keyframe, upright, q, bytes);
                } else {
                    encode_remove(w.head.entity, bytes);
                }
                ASSERT_LE(bytes.size() - before, kMaxRecordBytes);
                written.push_back(w);
            }
            RecordReader reader(bytes, q);
            for (const Written& w : written) {
                ASSERT_FALSE(reader.done());
                const auto head = reader.next_head();
                ASSERT_TRUE(head.ok()) << head.error();
                if (w.kind == RecordKind::kRemove) {
                    ASSERT_EQ(head->kind, RecordKind::kRemove);
                    ASSERT_EQ(head->entity, w.head.entity);
                    continue;
                }
                expect_same_head(*head, w.head, w.kind);
                ASSERT_EQ(head->upright, w.upright);
                if (w.kind == RecordKind::kDelta && rng.below(2) != 0) {
                    ASSERT_TRUE(reader.skip_delta(w.upright).ok());
                    continue;
                }
                const auto state = w.kind == RecordKind::kAbsolute
                                       ? reader.read_absolute(w.upright)
                                       : reader.read_delta(w.keyframe, w.upright);
                ASSERT_TRUE(state.ok()) << state.error();
                ASSERT_EQ(*state, w.state);
            }
            EXPECT_TRUE(reader.done());
        }
    }
}

TEST(Records, StayBelowTheLargestSizeAtTheEndsOfTheFinestRanges) {
    Quantization q = quantizations()[2];
    RecordHead head;
    head.entity = EntityId(0xFFFFFFFFu);
    head.type = 0xFFFF;
    motion::KinematicState fast;
    fast.position = fast.velocity = fast.acceleration = fast.angular_velocity = fast.turn =
        Vec3::Constant(1e9F);
    fast.orientation = Quat(-0.6F, 0.5F, 0.4F, 0.3F);
    motion::KinematicState back = fast;
    back.position = back.velocity = back.acceleration = back.angular_velocity = back.turn =
        Vec3::Constant(-1e9F);
    back.orientation = Quat(0.3F, 0.5F, -0.4F, -0.6F);
    const auto order = motion::PredictorOrder::kTurning;
    const auto a = quantize(fast, order, false, false, 0xFFFF, q);
    const auto b = quantize(back, order, false, false, 1, q);
    Bytes absolute;
    encode_absolute(head, a, false, q, absolute);
    EXPECT_LE(absolute.size(), kMaxRecordBytes);
    Bytes delta;
    encode_delta(head, a, b, false, q, delta);
    EXPECT_LE(delta.size(), kMaxRecordBytes);
}

TEST(Records, OfAFartherLevelAreWrittenInItsOwnSteps) {
    Quantization q;
    q.lod_shift[2] = lod_shift(0.05F, 0.1F, 0.5F, 0.3F);
    EXPECT_EQ(q.lod_shift[2], (LodShift{3, 1}));  // ten times and three times the bound
    const Quantization far = at_lod(q, 2);
    EXPECT_EQ(far.position_step_m, 8.0F * q.position_step_m);
    EXPECT_EQ(far.angular_velocity_step_rps, 2.0F * q.angular_velocity_step_rps);
    EXPECT_EQ(far.orientation_bits, q.orientation_bits - 1);
    EXPECT_LT(limits_of(far).horizontal, limits_of(q).horizontal);
    core::Rng rng(11);
    for (int i = 0; i < 500; ++i) {
        const bool upright = rng.below(2) != 0;
        RecordHead head;
        head.entity = EntityId(1 + rng.below(1000));
        head.lod = 2;
        const QuantizedState state = random_quantized(rng, upright, far);
        const QuantizedState keyframe = random_quantized(rng, upright, far);
        Bytes bytes;
        encode_absolute(head, state, upright, q, bytes);
        encode_delta(head, state, keyframe, upright, q, bytes);
        RecordReader reader(bytes, q);
        ASSERT_TRUE(reader.next_head().ok());
        const auto absolute = reader.read_absolute(upright);
        ASSERT_TRUE(absolute.ok());
        EXPECT_TRUE(*absolute == state);
        ASSERT_TRUE(reader.next_head().ok());
        const auto delta = reader.read_delta(keyframe, upright);
        ASSERT_TRUE(delta.ok());
        EXPECT_TRUE(*delta == state);
        EXPECT_TRUE(reader.done());
    }
}

TEST(Records, OfTypicalEntitiesAreSmall) {
    const Quantization q;
    RecordHead head;
    head.entity = EntityId(2345);
    head.type = 6;

    motion::KinematicState walking;
    walking.position = Vec3(312.37F, 0.9F, -187.21F);
    walking.velocity = Vec3(3.0F, 0.0F, 4.0F);
    walking.orientation = Quat(Eigen::AngleAxisf(0.6435F, Vec3::UnitY()));
    const auto linear = motion::PredictorOrder::kLinear;
    const auto keyframe = quantize(walking, linear, true, false, 0, q);
    Bytes absolute;
    encode_absolute(head, keyframe, true, q, absolute);
    EXPECT_LE(absolute.size(), 17u);

    // A second later it has gone five metres and turned by ten degrees.
    walking.position += Vec3(2.7F, 0.0F, 4.2F);
    walking.velocity = Vec3(2.26F, 0.0F, 4.46F);
    walking.orientation = Quat(Eigen::AngleAxisf(0.469F, Vec3::UnitY()));
    Bytes delta;
    encode_delta(head, quantize(walking, linear, true, false, 0, q), keyframe, true, q, delta);
    EXPECT_LE(delta.size(), 13u);

    motion::KinematicState resting;
    resting.position = Vec3(-412.37F, 3.7F, 87.21F);
    resting.orientation = Quat(0.1F, 0.7F, -0.2F, 0.67F).normalized();
    Bytes prop;
    encode_absolute(head,
                    quantize(resting, motion::PredictorOrder::kStatic, false, true, 0, q),
                    false,
                    q,
                    prop);
    EXPECT_LE(prop.size(), 16u);

    Bytes remove;
    encode_remove(head.entity, remove);
    EXPECT_EQ(remove.size(), 2u);
}

/// A delta record of a moving tumbling body, to be damaged.
Bytes sample_delta(const Quantization& q, QuantizedState& keyframe) {
    core::Rng rng(7);
    motion::KinematicState s = testing::random_motion(rng, q);
    const auto order = motion::PredictorOrder::kLinear;
    keyframe = quantize(s, order, false, false, 3, q);
    s.position += Vec3(1.0F, 2.0F, 3.0F);
    s.velocity += Vec3(0.5F, 0.0F, -0.5F);
    RecordHead head;
    head.entity = EntityId(77);
    head.keyframe = 9;
    Bytes bytes;
    encode_delta(head, quantize(s, order, false, false, 4, q), keyframe, false, q, bytes);
    return bytes;
}

TEST(RecordReader, RefusesEveryRecordThatIsCutOff) {
    const Quantization q;
    QuantizedState keyframe;
    const Bytes bytes = sample_delta(q, keyframe);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        RecordReader reader{std::span(bytes).first(size), q};
        EXPECT_EQ(reader.done(), size == 0);
        const auto head = reader.next_head();
        if (head.ok()) {
            EXPECT_FALSE(reader.read_delta(keyframe, false).ok());
        }
        EXPECT_TRUE(reader.done());
        EXPECT_FALSE(reader.next_head().ok());
    }
}

TEST(RecordReader, RefusesARecordThatContradictsTheTypeTable) {
    const Quantization q;
    QuantizedState keyframe;
    const Bytes bytes = sample_delta(q, keyframe);
    RecordReader reader(bytes, q);
    ASSERT_TRUE(reader.next_head().ok());
    EXPECT_FALSE(reader.read_delta(keyframe, true).ok());
    EXPECT_TRUE(reader.done());
    RecordReader skipping(bytes, q);
    ASSERT_TRUE(skipping.next_head().ok());
    EXPECT_FALSE(skipping.skip_delta(true).ok());
}

TEST(RecordReader, RefusesADeltaThatLeavesTheRange) {
    const Quantization q;
    motion::KinematicState s;
    s.position = Vec3(100.0F, 0.0F, 0.0F);
    const auto order = motion::PredictorOrder::kStatic;
    const auto near = quantize(s, order, true, false, 0, q);
    s.position.x() += 1.0F;
    Bytes bytes;
    RecordHead head;
    head.entity = EntityId(5);
    encode_delta(head, quantize(s, order, true, false, 0, q), near, true, q, bytes);
    s.position.x() = q.horizontal_extent_m - 0.5F;
    const auto rim = quantize(s, order, true, false, 0, q);
    RecordReader reader(bytes, q);
    ASSERT_TRUE(reader.next_head().ok());
    EXPECT_FALSE(reader.read_delta(rim, true).ok());
}

TEST(RecordReader, RefusesHeadsOfNoEntityOrNoKind) {
    const Quantization q;
    for (const Bytes& bytes : {Bytes{0x02, 0x00}, Bytes{0x03, 0x10}, Bytes{0x12, 0x10, 0x00}}) {
        RecordReader reader(bytes, q);
        EXPECT_FALSE(reader.next_head().ok());
        EXPECT_TRUE(reader.done());
    }
}

TEST(ExpandTick, GivesTheNewestTickThatIsNotAfterThePacket) {
    EXPECT_EQ(expand_tick(0x10, 0x1210), 0x1210);
    EXPECT_EQ(expand_tick(0x0F, 0x1210), 0x120F);
    EXPECT_EQ(expand_tick(0x11, 0x1210), 0x1111);
    for (Tick packet = 1'000; packet < 1'600; ++packet) {
        for (Tick age = 0; age < 256; ++age) {
            const Tick tick = packet - age;
            ASSERT_EQ(expand_tick(static_cast<std::uint8_t>(tick & 0xFF), packet), tick);
        }
    }
}

}  // namespace
}  // namespace zoned::wire
