#include "shared/wire/packet.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace zoned::wire {
namespace {

using motion::InputCommand;
using Bytes = std::vector<std::uint8_t>;

TEST(DatagramHeader, IsSixLittleEndianBytes) {
    Bytes bytes(kDatagramHeaderBytes + kSealTagBytes);
    write_datagram_header({0x04030201u, 0x0605}, bytes.data());
    for (std::uint8_t i = 0; i < 6; ++i) {
        EXPECT_EQ(bytes[i], i + 1);
    }
    const auto header = read_datagram_header(bytes);
    ASSERT_TRUE(header.ok());
    EXPECT_EQ(header->connection, 0x04030201u);
    EXPECT_EQ(header->sequence_low, 0x0605);
}

TEST(DatagramHeader, IsRefusedWhenTheDatagramIsTooShortOrTooLong) {
    EXPECT_FALSE(read_datagram_header(Bytes{}).ok());
    EXPECT_FALSE(read_datagram_header(Bytes(21)).ok());
    EXPECT_TRUE(read_datagram_header(Bytes(22)).ok());
    EXPECT_TRUE(read_datagram_header(Bytes(1200)).ok());
    EXPECT_FALSE(read_datagram_header(Bytes(1201)).ok());
}

TEST(ExpandSequence, FindsTheNearestSequence) {
    // The example of RFC 9000, appendix A.3: 0x9b32 after 0xa82f30ea is 0xa82f9b32.
    EXPECT_EQ(expand_sequence(0x9B32, 0xA82F30EAull + 1), 0xA82F9B32ull);
    core::Rng rng(1);
    for (int i = 0; i < 100'000; ++i) {
        const std::uint64_t expected =
            (static_cast<std::uint64_t>(rng.next()) << rng.below(20)) + 40'000;
        const std::uint64_t sequence = expected + rng.below(65'535) - 32'767;
        ASSERT_EQ(expand_sequence(static_cast<std::uint16_t>(sequence), expected), sequence);
    }
    EXPECT_EQ(expand_sequence(0xFFFF, 1), 0xFFFFull) << "nothing lies before zero";
    EXPECT_EQ(expand_sequence(1, 1), 1u);
}

TEST(Transport, GivesBackItsFields) {
    Bytes down(kDownTransportBytes);
    write_transport(DownTransport{0xDEADBEEF, 0x1234, 0xA5A5F00F, 0x8001}, down.data());
    const auto d = read_down_transport(down);
    ASSERT_TRUE(d.ok());
    EXPECT_EQ(d->send_time_us, 0xDEADBEEF);
    EXPECT_EQ(d->ack_low, 0x1234);
    EXPECT_EQ(d->ack_bits, 0xA5A5F00F);
    EXPECT_EQ(d->ack_delay_10us, 0x8001);
    EXPECT_FALSE(read_down_transport(std::span(down).first(11)).ok());
    Bytes up(kUpTransportBytes);
    write_transport(UpTransport{0x1234, 0xA5A5F00F, 0x8001, 0x7FFE}, up.data());
    const auto u = read_up_transport(up);
    ASSERT_TRUE(u.ok());
    EXPECT_EQ(u->ack_low, 0x1234);
    EXPECT_EQ(u->ack_bits, 0xA5A5F00F);
    EXPECT_EQ(u->ack_delay_10us, 0x8001);
    EXPECT_EQ(u->one_way_128us, 0x7FFE);
    EXPECT_FALSE(read_up_transport(std::span(up).first(9)).ok());
}

TEST(Transport, CountsOneWayDelaysAcrossTheWrapOfBothClocks) {
    // 1 ms is 7.8 units; sent just before the clock of the server wraps.
    EXPECT_EQ(one_way_128us(500, 0xFFFFFFFF - 499), 7);
    // For any zero of the clocks, 12.8 ms more are 100 units more.
    for (const std::uint32_t offset : {0U, 77U, 0x12345678U, 0xFFFFFF00U}) {
        const std::uint16_t before = one_way_128us(offset + 1280, 0);
        const std::uint16_t after = one_way_128us(offset + 1280 + 12800, 0);
        EXPECT_EQ(static_cast<std::uint16_t>(after - before), 100);
    }
}

TEST(AckTracker, AgreesWithASetOfAllThatWasReceived) {
    core::Rng rng(2);
    for (int round = 0; round < 50; ++round) {
        AckTracker tracker;
        std::set<std::uint64_t> received;
        std::uint64_t front = 1;
        EXPECT_FALSE(tracker.on_received(0));
        for (int i = 0; i < 1'000; ++i) {
            front += rng.below(20) == 0 ? rng.below(80) : rng.below(3);
            const std::uint64_t sequence =
                front - std::min<std::uint64_t>(rng.below(40), front - 1);
            const std::uint64_t newest = received.empty() ? 0 : *received.rbegin();
            const bool expected =
                !received.contains(sequence) && (sequence > newest || newest - sequence <= 32);
            ASSERT_EQ(tracker.on_received(sequence), expected);
            if (expected) {
                received.insert(sequence);
            }
            ASSERT_EQ(tracker.newest(), *received.rbegin());
            for (std::uint64_t b = 0; b < 32; ++b) {
                const bool bit = (tracker.bits() >> b & 1u) != 0;
                const std::uint64_t named = tracker.newest() - 1 - b;
                ASSERT_EQ(bit, tracker.newest() > b + 1 && received.contains(named));
            }
        }
    }
}

DownHead sample_head() {
    DownHead head;
    head.tick = 123'456;
    head.zone = ZoneId(3);
    head.has_own = true;
    head.own.avatar = EntityId(2'501);
    head.own.input_tick = head.tick;
    head.own.input_missing = true;
    head.own.input_lead = -3;
    head.own.state.position = Vec3(1.25F, -2.5F, 1e-30F);
    head.own.state.velocity = Vec3(-0.0F, 3.0F, -4.0F);
    head.own.state.yaw = 54'321;
    head.own.state.grounded = true;
    return head;
}

TEST(DownHead, GivesBackTheOwnStateToTheBit) {
    const DownHead head = sample_head();
    Bytes bytes;
    write_down_head(head, bytes);
    EXPECT_EQ(bytes.size(), 4u + 1 + 2 + 1 + 28);
    bytes.push_back(0x5A);  // The first byte of a record.
    const auto parsed = read_down_head(bytes);
    ASSERT_TRUE(parsed.ok()) << parsed.error();
    EXPECT_EQ(parsed->records_offset, bytes.size() - 1);
    EXPECT_EQ(parsed->head.tick, head.tick);
    EXPECT_EQ(parsed->head.zone, head.zone);
    ASSERT_TRUE(parsed->head.has_own);
    const OwnState& own = parsed->head.own;
    EXPECT_EQ(own.avatar, head.own.avatar);
    EXPECT_EQ(own.input_tick, head.tick);
    EXPECT_TRUE(own.input_missing);
    EXPECT_EQ(own.input_lead, -3);
    EXPECT_EQ(own.state.position, head.own.state.position);
    EXPECT_EQ(own.state.velocity, head.own.state.velocity);
    EXPECT_TRUE(std::signbit(own.state.velocity.x()));
    EXPECT_EQ(own.state.yaw, 54'321);
    EXPECT_TRUE(own.state.grounded);
}

TEST(DownHead, WithoutOwnStateIsFiveBytes) {
    DownHead head;
    head.tick = 0xFFFFFFFF;
    head.zone = ZoneId(4);
    Bytes bytes;
    write_down_head(head, bytes);
    EXPECT_EQ(bytes.size(), 5u);
    const auto parsed = read_down_head(bytes);
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(parsed->head.tick, 0xFFFFFFFF);
    EXPECT_EQ(parsed->head.zone, ZoneId(4));
    EXPECT_FALSE(parsed->head.has_own);
    EXPECT_EQ(parsed->records_offset, 5u);
}

TEST(DownHead, IsRefusedWhenCutOffOrNotFinite) {
    Bytes bytes;
    write_down_head(sample_head(), bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_FALSE(read_down_head(std::span(bytes).first(size)).ok()) << size;
    }
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        DownHead head = sample_head();
        head.own.state.velocity.z() = bad;
        Bytes odd;
        write_down_head(head, odd);
        EXPECT_FALSE(read_down_head(odd).ok());
    }
}

std::vector<InputCommand> random_commands(core::Rng& rng) {
    std::vector<InputCommand> commands(1 + rng.below(kMaxCommandsPerPacket));
    InputCommand c;
    c.tick = rng.next();
    for (InputCommand& out : commands) {
        if (rng.below(2) != 0) {
            c.move_x = static_cast<std::int8_t>(static_cast<int>(rng.below(255)) - 127);
        }
        if (rng.below(2) != 0) {
            c.move_z = static_cast<std::int8_t>(static_cast<int>(rng.below(255)) - 127);
        }
        if (rng.below(2) != 0) {
            c.yaw = static_cast<std::uint16_t>(c.yaw + (rng.next() >> (16 + rng.below(16))));
        }
        if (rng.below(3) == 0) {
            c.pitch = static_cast<std::int16_t>(static_cast<int>(rng.below(32'769)) - 16'384);
        }
        if (rng.below(3) == 0) {
            c.buttons = static_cast<std::uint16_t>(rng.next() >> (16 + rng.below(16)));
        }
        out = c;
        ++c.tick;
    }
    return commands;
}

TEST(Commands, GiveBackRandomLists) {
    core::Rng rng(3);
    std::vector<InputCommand> back;
    for (int i = 0; i < 50'000; ++i) {
        const auto commands = random_commands(rng);
        Bytes bytes;
        write_commands(commands, bytes);
        const auto count = read_commands(bytes, back);
        ASSERT_TRUE(count.ok()) << count.error();
        ASSERT_EQ(*count, commands.size());
        ASSERT_EQ(back, commands);
    }
}

TEST(Commands, CostABitForEachThatIsLikeTheOneBefore) {
    std::vector<InputCommand> commands(1);
    commands[0] = {1'000, 90, -90, 40'000, -500, motion::kButtonSprint};
    Bytes one;
    write_commands(commands, one);
    EXPECT_LE(one.size(), 12u);
    for (int i = 0; i < 3; ++i) {
        commands.push_back(commands.back());
        ++commands.back().tick;
    }
    Bytes four;
    write_commands(commands, four);
    EXPECT_LE(four.size(), one.size() + 1);
}

TEST(Commands, MayBeNone) {
    Bytes bytes;
    write_commands({}, bytes);
    EXPECT_TRUE(bytes.empty());
    std::vector<InputCommand> back(3);
    const auto count = read_commands(bytes, back);
    ASSERT_TRUE(count.ok());
    EXPECT_EQ(*count, 0u);
    EXPECT_TRUE(back.empty());
}

TEST(Commands, AreRefusedWhenCutOffOrFollowedByMore) {
    core::Rng rng(4);
    std::vector<InputCommand> back;
    for (int i = 0; i < 200; ++i) {
        Bytes bytes;
        write_commands(random_commands(rng), bytes);
        for (std::size_t size = 1; size < bytes.size(); ++size) {
            EXPECT_FALSE(read_commands(std::span(bytes).first(size), back).ok());
            EXPECT_TRUE(back.empty());
        }
        bytes.push_back(0);
        EXPECT_FALSE(read_commands(bytes, back).ok());
    }
}

}  // namespace
}  // namespace zoned::wire
