// Recording: every message survives a file, and a damaged file differs from a complete one.
#include "server/recording/frequent_records.h"
#include "server/recording/record_items.h"
#include "server/recording/recording_file.h"
#include "server/recording/recording_reader.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <type_traits>

namespace zoned::recording {
namespace {

using mailbox::InboxItem;

std::string temporary(const std::string& name) {
    return testing::TempDir() + "zoned_" + name + "_" +
           testing::UnitTest::GetInstance()->current_test_info()->name();
}

std::string read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

void write(const std::string& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

/// One of each message, with values at the ends of their ranges.
std::vector<InboxItem> every_item() {
    motion::InputCommand low;
    low.tick = -5;
    low.move_x = -127;
    low.move_z = 127;
    low.yaw = 65535;
    low.pitch = -16384;
    low.buttons = 0xFFFF;
    motion::InputCommand high;
    high.tick = INT64_C(1) << 60;
    high.pitch = 16384;
    return {mailbox::Join{ClientId(7),
                          "n\xC3\xA4me",
                          std::string("\0x", 2),
                          0xFFFFFFFFu,
                          {-1.5, 2.25, 1e6},
                          "account",
                          true},
            mailbox::Join{},
            mailbox::Leave{ClientId(8), mailbox::LeaveReason::kShutdown},
            mailbox::Input{ClientId(9), {low, high}},
            mailbox::Input{ClientId(9), {}},
            mailbox::Acks{ClientId(1), UINT64_MAX, 0x80000001u, 12345, 67890, 1357},
            mailbox::Command{ClientId(2), 65535, {0, 255, 10}, 0xFFFFFFFFFFFFFFFFu},
            mailbox::Command{ClientId(2), 0, {}, 0},
            mailbox::Notice{ClientId(5), "a\nb \xC3\xA4"},
            mailbox::Notice{},
            mailbox::SessionBegun{
                ClientId(7), {0, 255, 1}, "account", "n\xC3\xA4me", "red", 0x80000001u, true},
            mailbox::SessionBegun{},
            mailbox::SessionProgress{ClientId(8), 0xFFFFFFFFFFFFFFFFu, 1},
            mailbox::StoreKept{INT64_C(1) << 60},
            mailbox::Confirm{ClientId(3), EventId((UINT64_C(1) << 50) | 4)},
            mailbox::ViewReset{ClientId(4)},
            mailbox::Reach{ClientId(9), true},
            mailbox::Reach{ClientId(9), false},
            mailbox::Freeze{true},
            mailbox::Freeze{false},
            mailbox::AuditRequest{ClientId(0xFFFFFFFFu)},
            mailbox::CodecPrice{0xFFFFFFFFu, 7},
            mailbox::NewBrains{std::make_shared<const std::string>("brain {}\n\xff"), nullptr},
            mailbox::SpawnOrder{9, 65535, {-1.5, 2e6, 3.25}, 40000},
            mailbox::MoveOrder{0xFFFFFFFFFFFFFFFFu, EntityId(7), {0.1, -0.2, 1e-9}},
            mailbox::StoreAnswer{},
            mailbox::StoreAnswer{0xFFFFFFFFFFFFFFFFu,
                                 mailbox::StoreAct::kEvent,
                                 mailbox::StoreStatus::kRefused,
                                 ZoneId(65535),
                                 EntityId(9),
                                 {mailbox::StoreScope::kCharacter, "ann", "h\xC3\xA4ro", "bag"},
                                 {0, 255, 10}}};
}

struct Equal {
    bool operator()(const mailbox::Join& a, const mailbox::Join& b) const {
        return a.client == b.client && a.name == b.name && a.team == b.team &&
               a.rights == b.rights && std::equal(a.spawn, a.spawn + 3, b.spawn) &&
               a.account == b.account && a.placed == b.placed;
    }

    bool operator()(const mailbox::Leave& a, const mailbox::Leave& b) const {
        return a.client == b.client && a.reason == b.reason;
    }

    bool operator()(const mailbox::Input& a, const mailbox::Input& b) const {
        return a.client == b.client && a.commands == b.commands;
    }

    bool operator()(const mailbox::Acks& a, const mailbox::Acks& b) const {
        return a.client == b.client && a.newest == b.newest && a.bits == b.bits &&
               a.rtt_us == b.rtt_us && a.rate_bytes_per_s == b.rate_bytes_per_s &&
               a.rtt_variation_us == b.rtt_variation_us;
    }

    bool operator()(const mailbox::Command& a, const mailbox::Command& b) const {
        return a.client == b.client && a.kind == b.kind && a.payload == b.payload &&
               a.number == b.number;
    }

    bool operator()(const mailbox::Notice& a, const mailbox::Notice& b) const {
        return a.client == b.client && a.text == b.text;
    }

    bool operator()(const mailbox::SessionBegun& a, const mailbox::SessionBegun& b) const {
        return a.client == b.client && a.token_digest == b.token_digest && a.account == b.account &&
               a.name == b.name && a.team == b.team && a.rights == b.rights &&
               a.ticketed == b.ticketed;
    }

    bool operator()(const mailbox::StoreKept& a, const mailbox::StoreKept& b) const {
        return a.tick == b.tick;
    }

    bool operator()(const mailbox::SessionProgress& a, const mailbox::SessionProgress& b) const {
        return a.client == b.client && a.commands == b.commands && a.events == b.events;
    }

    bool operator()(const mailbox::Confirm& a, const mailbox::Confirm& b) const {
        return a.client == b.client && a.event == b.event;
    }

    bool operator()(const mailbox::ViewReset& a, const mailbox::ViewReset& b) const {
        return a.client == b.client;
    }

    bool operator()(const mailbox::Reach& a, const mailbox::Reach& b) const {
        return a.client == b.client && a.on == b.on;
    }

    bool operator()(const mailbox::Freeze& a, const mailbox::Freeze& b) const {
        return a.on == b.on;
    }

    bool operator()(const mailbox::AuditRequest& a, const mailbox::AuditRequest& b) const {
        return a.client == b.client;
    }

    bool operator()(const mailbox::CodecPrice& a, const mailbox::CodecPrice& b) const {
        return a.record_ns == b.record_ns && a.packet_ns == b.packet_ns;
    }

    bool operator()(const mailbox::NewBrains& a, const mailbox::NewBrains& b) const {
        return *a.config == *b.config;
    }

    bool operator()(const mailbox::StoreAnswer& a, const mailbox::StoreAnswer& b) const {
        return a.number == b.number && a.act == b.act && a.status == b.status && a.zone == b.zone &&
               a.target == b.target && a.key == b.key && a.value == b.value;
    }

    bool operator()(const mailbox::SpawnOrder& a, const mailbox::SpawnOrder& b) const {
        return a.number == b.number && a.type == b.type && a.yaw == b.yaw &&
               std::equal(a.position, a.position + 3, b.position);
    }

    bool operator()(const mailbox::MoveOrder& a, const mailbox::MoveOrder& b) const {
        return a.number == b.number && a.entity == b.entity &&
               std::equal(a.position, a.position + 3, b.position);
    }

    template <class A, class B>
        requires(!std::is_same_v<A, B>)

    bool operator()(const A& /*a*/, const B& /*b*/) const { return false; }
};

void expect_equal(const std::vector<InboxItem>& a, const std::vector<InboxItem>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_TRUE(std::visit(Equal{}, a[i], b[i])) << "item " << i;
    }
}

RecordingHeader header() {
    RecordingHeader h = RecordingHeader::of_this_build();
    h.config_text = "world { name: \"x\" }\n";
    h.config_digest = "abc";
    h.seed = UINT64_MAX;
    return h;
}

/// Three ticks; the middle one has no messages.
std::vector<TickRecord> three_ticks() {
    return {{1, every_item(), {0x1234567890ABCDEFULL, 5}},
            {2, {}, {7, 8}},
            {9, {mailbox::Freeze{true}}, {0, 1}}};
}

std::string make_recording(const std::string& file, const RecordingHeader& h = header()) {
    RecordingFile writer;
    EXPECT_TRUE(writer.open(file, h).ok());
    for (const TickRecord& record : three_ticks()) {
        writer.add_tick(record);
    }
    EXPECT_TRUE(writer.close().ok());
    const std::string bytes = read(file);
    EXPECT_EQ(bytes.size(), writer.bytes());
    return bytes;
}

/// What a reader gave before it came to the end, or failed with a reason.
struct Outcome {
    std::vector<TickRecord> ticks;
    std::string reason;  ///< empty: the end in good order
};

Outcome read_all(const std::string& file) {
    Outcome outcome;
    RecordingReader reader;
    const auto opened = reader.open(file);
    if (!opened.ok()) {
        outcome.reason = opened.error();
        return outcome;
    }
    for (TickRecord record;;) {
        const auto more = reader.next(record);
        if (!more.ok()) {
            outcome.reason = more.error();
            EXPECT_FALSE(reader.next(record).ok()) << "a damage stays one";
        }
        if (!more.ok() || !*more) {
            return outcome;
        }
        outcome.ticks.push_back(record);
    }
}

/// A number of any length.
std::uint64_t any_number(core::Rng& rng) {
    const std::uint64_t high = rng.below(0xFFFFFFFFU);
    return (high << 32U | rng.below(0xFFFFFFFFU)) >> rng.below(64);
}

InboxItem any_frequent_item(core::Rng& rng) {
    const ClientId client(static_cast<std::uint32_t>(any_number(rng)));
    switch (rng.below(3)) {
        case 0: {
            mailbox::Input input{client, {}};
            for (std::uint32_t n = rng.below(6); n > 0; --n) {
                motion::InputCommand command;
                command.tick = static_cast<Tick>(any_number(rng)) - 1000;
                command.move_x = static_cast<std::int8_t>(any_number(rng));
                command.move_z = static_cast<std::int8_t>(any_number(rng));
                command.yaw = static_cast<std::uint16_t>(any_number(rng));
                command.pitch = static_cast<std::int16_t>(any_number(rng));
                command.buttons = static_cast<std::uint16_t>(any_number(rng));
                input.commands.push_back(command);
            }
            return input;
        }
        case 1: {
            mailbox::Acks acks;
            acks.client = client;
            acks.newest = any_number(rng);
            acks.bits = static_cast<std::uint32_t>(any_number(rng));
            acks.rtt_us = static_cast<std::uint32_t>(any_number(rng));
            acks.rate_bytes_per_s = static_cast<std::uint32_t>(any_number(rng));
            acks.rtt_variation_us = static_cast<std::uint32_t>(any_number(rng));
            return acks;
        }
        default:
            return mailbox::SessionProgress{client, any_number(rng), any_number(rng)};
    }
}

TEST(FrequentRecords, AreTheBytesThatProtobufWrites) {
    std::vector<InboxItem> items = every_item();
    core::Rng rng(3);
    for (int i = 0; i < 3000; ++i) {
        items.push_back(any_frequent_item(rng));
    }
    FrameEncoder encoder;
    proto::RecordedInputs all;
    std::size_t frequent = 0;
    for (const InboxItem& item : items) {
        proto::RecordedInputs one;
        to_record(item, *one.add_items());
        to_record(item, *all.add_items());
        std::string bytes = "before";
        if (append_frequent_record(item, bytes)) {
            ++frequent;
            ASSERT_EQ(bytes, "before" + one.SerializeAsString()) << one.DebugString();
        } else {
            ASSERT_EQ(bytes, "before");
        }
    }
    EXPECT_GT(frequent, 3000U);
    EXPECT_EQ(encoder.inputs(9, items).substr(kFrameHeadBytes), all.SerializeAsString());
}

TEST(Recording, BringsEveryMessageBack) {
    static_assert(std::variant_size_v<InboxItem> == 19, "a new message belongs into these tests");
    const std::string file = temporary("recording");
    make_recording(file);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(file).ok());
    EXPECT_TRUE(reader.check_build().ok());
    EXPECT_EQ(reader.header().config_text, header().config_text);
    EXPECT_EQ(reader.header().config_digest, "abc");
    EXPECT_EQ(reader.header().seed, UINT64_MAX);
    EXPECT_EQ(reader.header().compiler, header().compiler);
    EXPECT_EQ(reader.header().program, header().program);
    TickRecord record;
    for (const TickRecord& written : three_ticks()) {
        ASSERT_TRUE(reader.next(record).value());
        EXPECT_EQ(record.tick, written.tick);
        EXPECT_EQ(record.hashes, written.hashes);
        expect_equal(record.items, written.items);
    }
    EXPECT_FALSE(reader.next(record).value());
    EXPECT_FALSE(reader.next(record).value()) << "the end stays the end";
    std::remove(file.c_str());
}

TEST(Recording, GoesOnToATickByHeadsAlone) {
    const std::string file = temporary("recording");
    std::string bytes = make_recording(file);
    const auto first_payload = bytes.find("n\xC3\xA4me");
    ASSERT_NE(first_payload, std::string::npos);
    bytes[first_payload] ^= 1;  // within tick 1, which nobody asks for
    write(file, bytes);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(file).ok());
    ASSERT_TRUE(reader.seek(3).value());
    TickRecord record;
    ASSERT_TRUE(reader.next(record).value());
    EXPECT_EQ(record.tick, 9);
    EXPECT_FALSE(reader.next(record).value());
    ASSERT_TRUE(reader.open(file).ok());
    EXPECT_FALSE(reader.seek(10).value());
    std::remove(file.c_str());
}

TEST(Recording, TellsTruncationAtEveryByteFromAGoodEnd) {
    const std::string file = temporary("recording");
    const std::string bytes = make_recording(file);
    std::size_t before = 0;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        write(file, bytes.substr(0, size));
        const Outcome cut = read_all(file);
        ASSERT_FALSE(cut.reason.empty()) << "cut at " << size;
        EXPECT_NE(cut.reason.find(file), std::string::npos);
        EXPECT_GE(cut.ticks.size(), before) << "more bytes never give fewer ticks";
        before = cut.ticks.size();
    }
    EXPECT_EQ(before, 3U) << "all is read up to the damage";
    std::remove(file.c_str());
}

TEST(Recording, FindsAFlippedBitInEveryByte) {
    const std::string file = temporary("recording");
    const std::string bytes = make_recording(file);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
        write(file, damaged);
        EXPECT_FALSE(read_all(file).reason.empty()) << "flipped at " << at;
    }
    std::remove(file.c_str());
}

TEST(Recording, NamesTheByteAndTheLastWholeTickOfADamage) {
    const std::string file = temporary("recording");
    std::string bytes = make_recording(file);
    bytes[bytes.size() - 2 * kFrameHeadBytes - 20] ^= 4;  // the hashes of tick 9
    write(file, bytes);
    const Outcome outcome = read_all(file);
    EXPECT_EQ(outcome.ticks.size(), 3U);
    EXPECT_TRUE(outcome.ticks.back().hashes.empty());
    EXPECT_NE(outcome.reason.find("does not match its checksum"), std::string::npos);
    EXPECT_NE(outcome.reason.find("the last whole tick is 2"), std::string::npos) << outcome.reason;
    const auto byte = outcome.reason.find("(byte ");
    ASSERT_NE(byte, std::string::npos);
    const std::size_t at = std::stoul(outcome.reason.substr(byte + 6));
    EXPECT_LE(at, bytes.size() - 2 * kFrameHeadBytes - 20);
    EXPECT_GT(at + 64, bytes.size() - 2 * kFrameHeadBytes - 20);
    std::remove(file.c_str());
}

TEST(Recording, RefusesWhatFollowsTheEnd) {
    const std::string file = temporary("recording");
    write(file, make_recording(file) + "x");
    const std::string reason = read_all(file).reason;
    EXPECT_NE(reason.find("follows its end mark"), std::string::npos) << reason;
    std::remove(file.c_str());
}

TEST(Recording, NamesBothVersionsOfWhatItCannotTake) {
    const std::string file = temporary("recording");
    write(file, "PNG....................");
    EXPECT_NE(read_all(file).reason.find("is no recording"), std::string::npos);
    EXPECT_NE(read_all("/nonexistent/file").reason.find("No such file"), std::string::npos);
    write(file, "ZONEDREC....................");
    EXPECT_NE(read_all(file).reason.find("has format 1, this program"), std::string::npos);
    EXPECT_NE(read_all(file).reason.find("reads format 3"), std::string::npos);
    write(file, "ZREC0023....................");
    EXPECT_NE(read_all(file).reason.find("has format 23"), std::string::npos);

    const auto check = [&](const RecordingHeader& h) {
        make_recording(file, h);
        EXPECT_EQ(read_all(file).reason, "") << "its content can be shown";
        RecordingReader reader;
        EXPECT_TRUE(reader.open(file).ok());
        const auto checked = reader.check_build();
        return checked.ok() ? std::string() : checked.error();
    };
    RecordingHeader other = header();
    other.generation = kSimulationGeneration + 1;
    other.program = "9.8.7";
    const std::string text = check(other);
    for (const std::string& word : {std::string("zoned 9.8.7"),
                                    std::to_string(kSimulationGeneration + 1),
                                    "zoned " + header().program,
                                    "generation " + std::to_string(kSimulationGeneration)}) {
        EXPECT_NE(text.find(word), std::string::npos) << text;
    }
    other = header();
    other.compiler = "another compiler";
    other.target = "another processor";
    EXPECT_EQ(check(other), "") << "compilers and processors agree";
    std::remove(file.c_str());
}

TEST(Recording, EndsWithoutEndMarkWhenItsWriterDied) {
    const std::string file = temporary("recording");
    {
        RecordingFile writer;
        ASSERT_TRUE(writer.open(file, header()).ok());
        writer.add_tick({1, {}, {3}});
        writer.add_tick({2, {mailbox::Freeze{true}}, {}});  // it died within this one
    }
    const Outcome outcome = read_all(file);
    ASSERT_EQ(outcome.ticks.size(), 2U) << "what was written can be replayed";
    EXPECT_EQ(outcome.ticks[1].items.size(), 1U);
    EXPECT_TRUE(outcome.ticks[1].hashes.empty());
    EXPECT_NE(outcome.reason.find("without an end mark"), std::string::npos);
    std::remove(file.c_str());
}

TEST(Recording, SaysWhyItCannotWrite) {
    RecordingFile writer;
    EXPECT_FALSE(writer.open("/nonexistent/folder/file", header()).ok());
    // A device that is always full.
    const auto opened = writer.open("/dev/full", header());
    ASSERT_FALSE(opened.ok());
    EXPECT_NE(opened.error().find("No space left"), std::string::npos) << opened.error();
}

TEST(RecordItems, RefuseNumbersThatDoNotFit) {
    InboxItem item;
    proto::RecordedItem record;
    EXPECT_FALSE(from_record(record, item)) << "no item at all";
    record.mutable_leave()->set_reason(4);
    EXPECT_FALSE(from_record(record, item));
    record.mutable_command()->set_kind(65536);
    EXPECT_FALSE(from_record(record, item));
    record.mutable_input()->add_commands()->set_move_x(128);
    EXPECT_FALSE(from_record(record, item));
    record.mutable_input()->mutable_commands(0)->set_move_x(-128);
    EXPECT_TRUE(from_record(record, item));
    record.mutable_input()->mutable_commands(0)->set_yaw(65536);
    EXPECT_FALSE(from_record(record, item));
    record.mutable_input()->mutable_commands(0)->set_yaw(0);
    record.mutable_input()->mutable_commands(0)->set_pitch(-32769);
    EXPECT_FALSE(from_record(record, item));
    record.mutable_input()->mutable_commands(0)->set_pitch(0);
    const std::size_t most = wire::kMaxCommandsPerPacket;
    while (record.input().commands_size() < static_cast<int>(most)) {
        record.mutable_input()->add_commands();
    }
    ASSERT_TRUE(from_record(record, item));
    EXPECT_EQ(std::get<mailbox::Input>(item).commands.size(), most);
    record.mutable_input()->add_commands();
    EXPECT_FALSE(from_record(record, item)) << "more than a packet holds";
}

}  // namespace
}  // namespace zoned::recording
