// build: computes
#include "tests/unit/allocation_count.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"
#include "shared/wire/record/record_codec.h"
#include "shared/wire/record/rotation.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace zoned::wire::record {
namespace {

constexpr ZoneId kCourseZone(1);

RecordFormat small_format() {
    Quantization q;
    q.position_step_m = 1.0F / 512.0F;
    q.orientation_bits = 9;
    q.horizontal_extent_m = 32.0F;
    q.vertical_extent_m = 16.0F;
    return RecordFormat(q, 1.0F / 60.0F);
}

/// Balls that bounce in a box and spin, some of which rest at any time. No predictor knows this
/// motion.
class Bouncing {
  public:
    Bouncing(const RecordFormat& format, std::uint32_t count, std::uint64_t seed)
        : format_(format),
          rng_(seed) {
        for (std::uint32_t i = 0; i < count; ++i) {
            Ball& ball = balls_.emplace_back();
            ball.place = {range(-16.0, 16.0), range(0.0, 8.0), range(-16.0, 16.0)};
            ball.axis = Eigen::Vector3d(range(-1.0, 1.0), 1.0, range(-1.0, 1.0)).normalized();
            push(ball);
        }
    }

    /// The records of those whose state is another one than a tick before; at first of all.
    std::vector<CodedRecord> step(Tick tick, bool pushed = true) {
        std::vector<CodedRecord> records;
        std::uint32_t entity = 0;
        for (Ball& ball : balls_) {
            move(ball, pushed);
            CodedRecord record;
            record.entity = EntityId(++entity);
            record.tick = tick;
            record.state = state_of(ball);
            if (!ball.told || !(*ball.told == record.state)) {
                records.push_back(record);
                ball.told = record.state;
            }
        }
        return records;
    }

  private:
    struct Ball {
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m a tick
        Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
        double turn = 0.0;
        double spin = 0.0;  // rad a tick
        bool rests = false;
        std::optional<QuantizedState> told;
    };

    double range(double a, double b) { return a + (b - a) * static_cast<double>(rng_.unit()); }

    void push(Ball& ball) {
        ball.velocity = {range(-0.12, 0.12), range(-0.12, 0.12), range(-0.12, 0.12)};
        ball.spin = range(-0.2, 0.2);
    }

    void move(Ball& ball, bool pushed) {
        if (pushed && rng_.below(100) == 0) {
            ball.rests = !ball.rests;
            push(ball);
        }
        if (!ball.rests) {
            ball.place += ball.velocity;
            ball.turn += ball.spin;
        }
        for (int axis = 0; axis < 3; ++axis) {
            const double low = axis == 1 ? 0.0 : -18.0;
            if (ball.place[axis] < low || ball.place[axis] > 15.5) {
                ball.velocity[axis] = -ball.velocity[axis];
                ball.place[axis] = std::clamp(ball.place[axis], low, 15.5);
            }
        }
    }

    [[nodiscard]] QuantizedState state_of(const Ball& ball) const {
        motion::KinematicState state;
        state.position = ball.place.cast<float>();
        state.orientation =
            Quat(Eigen::Quaterniond(Eigen::AngleAxisd(ball.turn, ball.axis)).cast<float>());
        return quantize(state,
                        motion::PredictorOrder::kStatic,
                        false,
                        ball.rests,
                        0,
                        format_.levels[0].quantization);
    }

    const RecordFormat& format_;
    core::Rng rng_;
    std::vector<Ball> balls_;
};

Eigen::Quaterniond eigen(const Rotation& r) {
    return Eigen::Quaterniond(static_cast<double>(r.w),
                              static_cast<double>(r.x),
                              static_cast<double>(r.y),
                              static_cast<double>(r.z))
        .normalized();
}

Rotation random_rotation(core::Rng& rng) {
    const Eigen::Quaterniond q = Eigen::Quaterniond(static_cast<double>(rng.range(-1.0F, 1.0F)),
                                                    static_cast<double>(rng.range(-1.0F, 1.0F)),
                                                    static_cast<double>(rng.range(-1.0F, 1.0F)),
                                                    static_cast<double>(rng.range(-1.0F, 1.0F)))
                                     .normalized();
    return {static_cast<float>(q.w()),
            static_cast<float>(q.x()),
            static_cast<float>(q.y()),
            static_cast<float>(q.z())};
}

TEST(Turn, LeadsFromOneOrientationToAnother) {
    core::Rng rng(1);
    for (int i = 0; i < 20'000; ++i) {
        const Rotation from = random_rotation(rng);
        const Rotation to = random_rotation(rng);
        const Turn turn = turn_between(from, to);
        const double angle = std::hypot(static_cast<double>(turn[0]),
                                        static_cast<double>(turn[1]),
                                        static_cast<double>(turn[2]));
        // Floats of unit size are off by 6e-8 each. Near a half turn the arc's slope is infinite if
        // computed by the sine, so there it is computed by the cosine.
        EXPECT_NEAR(angle, eigen(from).angularDistance(eigen(to)), 3e-6);
        EXPECT_NEAR(eigen(turned(from, turn)).angularDistance(eigen(to)), 0.0, 3e-6);
    }
}

TEST(Turn, OfSmallAnglesIsAxisTimesAngle) {
    for (const double angle : {0.0, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 3.0, 3.14}) {
        const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
        const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis));
        const Rotation to{static_cast<float>(q.w()),
                          static_cast<float>(q.x()),
                          static_cast<float>(q.y()),
                          static_cast<float>(q.z())};
        const Turn turn = turn_between(Rotation{}, to);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(
                static_cast<double>(turn[static_cast<std::size_t>(i)]), angle * axis[i], 2e-6)
                << angle;
        }
    }
}

TEST(Turn, TakesWhateverComes) {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float x : {1e30F, infinity, std::numeric_limits<float>::quiet_NaN()}) {
        const Rotation r = turned(Rotation{}, {x, 0.0F, -x});
        EXPECT_EQ(r.w, r.w);
        for (const std::int32_t c : smallest_three(r, 0, 255)) {
            EXPECT_LE(std::abs(c), 255);
        }
    }
}

/// A network of whole frames: a packet sent at one frame comes at a later one, or not at all, or
/// twice.
template <class Message>
class Network {
  public:
    Network(double loss, int delay, int jitter, std::uint64_t seed)
        : loss_(loss),
          delay_(delay),
          jitter_(jitter),
          rng_(seed) {}

    void send(int now, const Message& message) {
        const bool twice = rng_.below(20) == 0;
        for (int copies = twice ? 2 : 1; copies > 0; --copies) {
            const int late =
                delay_ + static_cast<int>(rng_.below(static_cast<std::uint32_t>(2 * jitter_ + 1))) -
                jitter_;
            if (static_cast<double>(rng_.unit()) >= loss_) {
                under_way_.emplace(now + std::max(late, 1), message);
            }
        }
    }

    std::vector<Message> receive(int now) {
        std::vector<Message> due;
        while (!under_way_.empty() && under_way_.begin()->first <= now) {
            due.push_back(under_way_.begin()->second);
            under_way_.erase(under_way_.begin());
        }
        return due;
    }

    void set_loss(double loss) { loss_ = loss; }

  private:
    double loss_;
    int delay_;
    int jitter_;
    core::Rng rng_;
    std::multimap<int, Message> under_way_;
};

struct Packet {
    entropy::PacketNumber number = 0;
    std::vector<std::uint8_t> bytes;
};

bool same_states(std::span<const CodedRecord> a, std::span<const CodedRecord> b) {
    return std::ranges::equal(a, b, [](const CodedRecord& x, const CodedRecord& y) {
        return x.entity == y.entity && x.tick == y.tick && x.state == y.state;
    });
}

struct Outcome {
    int decoded = 0;
    int repeated = 0;
    int failed = 0;
    int wrong = 0;
    entropy::PacketNumber newest = 0;
};

/// Runs encoder and decoder over a network for so many frames; acknowledgements name everything
/// received of late, as those of datagrams do. Between two frames nothing comes at all.
Outcome play(std::uint32_t balls, int frames, double loss, int jitter, int cut_from, int cut_to) {
    const RecordFormat format = small_format();
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    Bouncing world(format, balls, 3);
    Network<Packet> down(loss, 4, jitter, 11);
    Network<std::vector<entropy::PacketNumber>> up(loss, 4, jitter, 12);
    std::map<entropy::PacketNumber, std::vector<CodedRecord>> truth;
    std::set<entropy::PacketNumber> received;
    Outcome outcome;
    for (int now = 1; now <= frames; ++now) {
        const bool cut = now >= cut_from && now < cut_to;
        down.set_loss(cut ? 1.0 : loss);
        up.set_loss(cut ? 1.0 : loss);
        for (const auto& acknowledged : up.receive(now)) {
            for (const entropy::PacketNumber number : acknowledged) {
                encoder.acknowledge(number);
            }
        }
        Packet packet;
        packet.number = static_cast<entropy::PacketNumber>(now);
        truth[packet.number] = world.step(now);
        encoder.sent(
            encoder.encode(packet.number, now, kCourseZone, truth[packet.number], packet.bytes));
        down.send(now, packet);
        for (const Packet& p : down.receive(now)) {
            const auto frame =
                decoder.decode(p.number, static_cast<Tick>(p.number), kCourseZone, p.bytes);
            if (frame) {
                ++outcome.decoded;
                outcome.wrong += same_states((*frame)->records, truth[p.number]) ? 0 : 1;
                outcome.newest = std::max(outcome.newest, p.number);
                received.insert(p.number);
            } else if (received.contains(p.number)) {
                ++outcome.repeated;
            } else {
                ++outcome.failed;
            }
        }
        while (received.size() > 32) {
            received.erase(received.begin());
        }
        up.send(now, {received.begin(), received.end()});
    }
    return outcome;
}

TEST(Course, IsExactOverAPerfectNetwork) {
    const Outcome outcome = play(100, 600, 0.0, 0, 0, 0);
    EXPECT_EQ(outcome.wrong, 0);
    EXPECT_EQ(outcome.failed, 0);
    EXPECT_GE(outcome.decoded, 590);
}

TEST(Course, IsExactWhateverIsLostDoubledOrLate) {
    for (const double loss : {0.0, 0.05, 0.3}) {
        for (const int jitter : {0, 2, 3}) {
            const Outcome outcome = play(60, 900, loss, jitter, 0, 0);
            EXPECT_EQ(outcome.wrong, 0) << loss << " " << jitter;
            // A packet that is late by less than the kept states of knowledge is decoded.
            EXPECT_EQ(outcome.failed, 0) << loss << " " << jitter;
            EXPECT_GE(outcome.decoded, static_cast<int>((1.0 - loss) * 840.0))
                << loss << " " << jitter;
        }
    }
}

TEST(Course, GoesOnAfterOutagesOfAnyLength) {
    for (const int length : {10, 70, 130, 300, 600}) {
        const Outcome outcome = play(40, length + 600, 0.05, 1, 200, 200 + length);
        EXPECT_EQ(outcome.wrong, 0) << length;
        EXPECT_GE(outcome.newest, static_cast<entropy::PacketNumber>(length + 590)) << length;
        // Packets in flight when the encoder started over may be of no use any more.
        EXPECT_LE(outcome.failed, 12) << length;
    }
}

/// Bits of a record, of packets that are acknowledged six ticks later, from the 200th on.
template <class Step>
double bits_of_a_record(const RecordFormat& format, int packets, Step step) {
    RecordEncoder encoder(format);
    std::size_t bytes = 0;
    std::size_t records = 0;
    std::vector<std::uint8_t> code;
    for (Tick tick = 1; tick <= packets; ++tick) {
        const auto number = static_cast<entropy::PacketNumber>(tick);
        if (number > 6) {
            encoder.acknowledge(number - 6);
        }
        const std::vector<CodedRecord> moved = step(tick);
        code.clear();
        encoder.sent(encoder.encode(number, tick, kCourseZone, moved, code));
        if (tick > 200) {
            bytes += code.size();
            records += moved.size();
        }
    }
    return 8.0 * static_cast<double>(bytes) /
           static_cast<double>(std::max<std::size_t>(records, 1));
}

TEST(Course, OfWhatMovesOnTakesItsRoundingAlone) {
    const RecordFormat format = small_format();
    Bouncing world(format, 200, 4);
    const double bits =
        bits_of_a_record(format, 400, [&](Tick tick) { return world.step(tick, false); });
    // A place rounds by half a step. It follows from the newest one known, six packets ago, and six
    // times its difference to the one before, or to older ones: at most 0.5 + 13 * 0.5 = 7 steps
    // off, which with their sign are 15 values: under 4 bits for each of three coordinates and
    // three components, and 3 for the rest. Where it was 0.7 m before takes 9 bits and a sign each.
    EXPECT_LT(bits, 27.0);
}

TEST(Course, TakesNoMoreThanPlainBitsWhereEverythingJumps) {
    // As Fiedler packs bits: of each cube one for whether it moved, of those that did the
    // coordinates whole, two for the component left out, and nine for each of the others.
    constexpr std::uint32_t kCubes = 300;
    const RecordFormat format = small_format();
    const FieldLayout& layout = format.levels[0].layout;
    const int whole =
        2 * layout[Range::kHorizontal].full_bits + layout[Range::kVertical].full_bits + 2 + 27;
    for (const std::uint32_t one_in : {1U, 10U, 100U}) {
        core::Rng rng(9);
        double plain = 0.0;
        std::size_t count = 0;
        const double bits = bits_of_a_record(format, 500, [&](Tick tick) {
            std::vector<CodedRecord> moved;
            for (std::uint32_t cube = 1; cube <= kCubes; ++cube) {
                if (tick > 1 && rng.below(one_in) != 0) {
                    continue;
                }
                CodedRecord& record = moved.emplace_back();
                record.entity = EntityId(cube);
                record.tick = tick;
                motion::KinematicState state;
                state.position = {
                    rng.range(-32.0F, 32.0F), rng.range(0.0F, 16.0F), rng.range(-32.0F, 32.0F)};
                state.orientation = testing::random_rotation(rng);
                record.state = quantize(state,
                                        motion::PredictorOrder::kStatic,
                                        false,
                                        false,
                                        0,
                                        format.levels[0].quantization);
            }
            if (tick > 200) {
                plain += kCubes + static_cast<double>(moved.size()) * whole;
                count += moved.size();
            }
            return moved;
        });
        EXPECT_LE(bits, 1.05 * plain / static_cast<double>(count)) << "one in " << one_in;
    }
}

TEST(Course, IsTheSameToAnEncoderThatWasSaved) {
    const RecordFormat format = small_format();
    RecordEncoder encoder(format);
    Bouncing world(format, 50, 6);
    for (Tick tick = 1; tick <= 120; ++tick) {
        const auto number = static_cast<entropy::PacketNumber>(tick);
        const std::vector<CodedRecord> moved = world.step(tick);
        if (tick % 10 == 0) {
            std::vector<std::uint8_t> saved;
            core::FieldWriter writer(saved);
            writer(encoder);
            RecordEncoder again(format);
            core::FieldReader reader(saved);
            reader(again);
            ASSERT_TRUE(reader.good() && reader.left() == 0) << reader.wrong();
            std::vector<std::uint8_t> here;
            std::vector<std::uint8_t> there;
            (void)encoder.encode(number, tick, kCourseZone, moved, here);
            (void)again.encode(number, tick, kCourseZone, moved, there);
            ASSERT_EQ(here, there) << tick;
        }
        std::vector<std::uint8_t> code;
        encoder.sent(encoder.encode(number, tick, kCourseZone, moved, code));
        if (number > 6 && number % 9 != 0) {
            encoder.acknowledge(number - 6);
        }
    }
}

TEST(Course, AllocatesNothingOnceItIsWarm) {
    const RecordFormat format = small_format();
    RecordEncoder encoder(format);
    Bouncing world(format, 60, 7);
    std::vector<std::uint8_t> bytes;
    std::uint64_t warm = 0;
    for (Tick tick = 1; tick <= 600; ++tick) {
        const auto number = static_cast<entropy::PacketNumber>(tick);
        const std::vector<CodedRecord> moved = world.step(tick, false);
        bytes.clear();
        const std::uint64_t before = allocation_count();
        encoder.sent(encoder.encode(number, tick, kCourseZone, moved, bytes));
        if (number > 8) {
            encoder.acknowledge(number - 8);
        }
        warm += tick > 200 ? allocation_count() - before : 0;
    }
    EXPECT_EQ(warm, 0U);
}

TEST(Course, StaysWholeWhateverBytesCome) {
    const RecordFormat format = small_format();
    const QuantizationLimits& limits = format.levels[0].limits;
    Bouncing world(format, 50, 7);
    RecordEncoder encoder(format);
    RecordDecoder decoder(format);
    core::Rng rng(8);
    int refused = 0;
    entropy::PacketNumber hostile = 1'000'000;
    for (entropy::PacketNumber number = 1; number <= 300; ++number) {
        const auto tick = static_cast<Tick>(number);
        const std::vector<CodedRecord> moved = world.step(tick);
        std::vector<std::uint8_t> bytes;
        encoder.sent(encoder.encode(number, tick, kCourseZone, moved, bytes));
        for (int i = 0; i < 4; ++i) {
            RecordDecoder victim = decoder;
            const std::vector<std::uint8_t> changed = testing::spoiled(bytes, i, rng);
            const auto frame =
                victim.decode(i == 3 ? hostile++ : number, tick, kCourseZone, changed);
            refused += frame ? 0 : 1;
            for (const CodedRecord& record :
                 frame ? (*frame)->records : std::vector<CodedRecord>()) {
                for (std::size_t axis = 0; axis < 3 && !record.remove; ++axis) {
                    const std::int32_t most = axis == 1 ? limits.vertical : limits.horizontal;
                    ASSERT_LE(std::abs(record.state.position[axis]), most);
                    ASSERT_LE(std::abs(record.state.orientation[axis]), limits.orientation);
                }
            }
        }
        const auto frame = decoder.decode(number, tick, kCourseZone, bytes);
        ASSERT_TRUE(frame) << frame.error();
        ASSERT_TRUE(same_states((*frame)->records, moved));
        encoder.acknowledge(number);
    }
    EXPECT_GT(refused, 600);
}

}  // namespace
}  // namespace zoned::wire::record
