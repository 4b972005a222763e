// Recorder: every message survives a file, and a damaged file differs from a complete one.
#include "server/recording/recorder.h"

#include "server/recording/record_items.h"

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
    return {mailbox::Join{
                ClientId(7), "n\xC3\xA4me", std::string("\0x", 2), 0xFFFFFFFFu, {-1.5, 2.25, 1e6}},
            mailbox::Join{},
            mailbox::Leave{ClientId(8), mailbox::LeaveReason::kShutdown},
            mailbox::Input{ClientId(9), {low, high}},
            mailbox::Input{ClientId(9), {}},
            mailbox::Acks{ClientId(1), UINT64_MAX, 0x80000001u, 12345, 67890},
            mailbox::Command{ClientId(2), 65535, {0, 255, 10}},
            mailbox::Command{ClientId(2), 0, {}},
            mailbox::Confirm{ClientId(3), EventId((UINT64_C(1) << 50) | 4)},
            mailbox::ViewReset{ClientId(4)},
            mailbox::Freeze{true},
            mailbox::Freeze{false},
            mailbox::AuditRequest{ClientId(0xFFFFFFFFu)},
            mailbox::CodecPrice{0xFFFFFFFFu, 7},
            mailbox::NewBrains{std::make_shared<const std::string>("brain {}\n\xff"), nullptr},
            mailbox::SpawnOrder{9, 65535, {-1.5, 2e6, 3.25}, 40000},
            mailbox::MoveOrder{0xFFFFFFFFFFFFFFFFu, EntityId(7), {0.1, -0.2, 1e-9}}};
}

struct Equal {
    bool operator()(const mailbox::Join& a, const mailbox::Join& b) const {
        return a.client == b.client && a.name == b.name && a.team == b.team &&
               a.rights == b.rights && std::equal(a.spawn, a.spawn + 3, b.spawn);
    }

    bool operator()(const mailbox::Leave& a, const mailbox::Leave& b) const {
        return a.client == b.client && a.reason == b.reason;
    }

    bool operator()(const mailbox::Input& a, const mailbox::Input& b) const {
        return a.client == b.client && a.commands == b.commands;
    }

    bool operator()(const mailbox::Acks& a, const mailbox::Acks& b) const {
        return a.client == b.client && a.newest == b.newest && a.bits == b.bits &&
               a.rtt_us == b.rtt_us && a.rate_bytes_per_s == b.rate_bytes_per_s;
    }

    bool operator()(const mailbox::Command& a, const mailbox::Command& b) const {
        return a.client == b.client && a.kind == b.kind && a.payload == b.payload;
    }

    bool operator()(const mailbox::Confirm& a, const mailbox::Confirm& b) const {
        return a.client == b.client && a.event == b.event;
    }

    bool operator()(const mailbox::ViewReset& a, const mailbox::ViewReset& b) const {
        return a.client == b.client;
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

/// A recording of three ticks in two zones; the middle tick is empty.
std::string make_recording(const std::string& file, const RecordingHeader& h = header()) {
    RecordingWriter writer;
    EXPECT_TRUE(writer.open(file, h).ok());
    const std::vector<ZoneTick> first = {{ZoneId(1), every_item(), 0x1234567890ABCDEFull},
                                         {ZoneId(2), {}, 5}};
    writer.add_tick(1, first);
    writer.add_tick(2, {});
    const std::vector<ZoneTick> third = {{ZoneId(65535), {mailbox::Freeze{true}}, 0}};
    writer.add_tick(9, third);
    EXPECT_TRUE(writer.close().ok());
    const std::string bytes = read(file);
    EXPECT_EQ(bytes.size(), writer.bytes());
    return bytes;
}

/// Reads all: number of ticks, or -1 and the reason.
int read_all(const std::string& file, std::string& reason) {
    RecordingReader reader;
    const auto opened = reader.open(file);
    if (!opened.ok()) {
        reason = opened.error();
        return -1;
    }
    TickRecord record;
    for (int ticks = 0;; ++ticks) {
        const auto more = reader.next(record);
        if (!more.ok()) {
            reason = more.error();
            return -1;
        }
        if (!more.value()) {
            return ticks;
        }
    }
}

TEST(Recorder, BringsEveryMessageBack) {
    static_assert(std::variant_size_v<InboxItem> == 13, "a new message belongs into these tests");
    const std::string file = temporary("recording");
    make_recording(file);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(file).ok());
    EXPECT_EQ(reader.header().config_text, header().config_text);
    EXPECT_EQ(reader.header().config_digest, "abc");
    EXPECT_EQ(reader.header().seed, UINT64_MAX);
    EXPECT_EQ(reader.header().compiler, header().compiler);
    TickRecord record;
    ASSERT_TRUE(reader.next(record).value());
    EXPECT_EQ(record.tick, 1);
    ASSERT_EQ(record.zones.size(), 2u);
    EXPECT_EQ(record.zones[0].zone, ZoneId(1));
    EXPECT_EQ(record.zones[0].hash, 0x1234567890ABCDEFull);
    expect_equal(record.zones[0].inbox, every_item());
    EXPECT_TRUE(record.zones[1].inbox.empty());
    ASSERT_TRUE(reader.next(record).value());
    EXPECT_EQ(record.tick, 2);
    EXPECT_TRUE(record.zones.empty());
    ASSERT_TRUE(reader.next(record).value());
    EXPECT_EQ(record.tick, 9);
    EXPECT_EQ(record.zones[0].zone, ZoneId(65535));
    EXPECT_FALSE(reader.next(record).value());
    EXPECT_FALSE(reader.next(record).value()) << "the end stays the end";
    std::remove(file.c_str());
}

TEST(Recorder, TellsTruncationAtEveryByteFromAGoodEnd) {
    const std::string file = temporary("recording");
    const std::string bytes = make_recording(file);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        write(file, bytes.substr(0, size));
        std::string reason;
        EXPECT_EQ(read_all(file, reason), -1) << "cut at " << size;
        EXPECT_NE(reason.find(file), std::string::npos);
    }
    std::remove(file.c_str());
}

TEST(Recorder, FindsAFlippedBitInEveryByte) {
    const std::string file = temporary("recording");
    const std::string bytes = make_recording(file);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
        write(file, damaged);
        std::string reason;
        EXPECT_EQ(read_all(file, reason), -1) << "flipped at " << at;
    }
    std::remove(file.c_str());
}

TEST(Recorder, RefusesWhatFollowsTheEnd) {
    const std::string file = temporary("recording");
    write(file, make_recording(file) + "x");
    std::string reason;
    EXPECT_EQ(read_all(file, reason), -1);
    EXPECT_NE(reason.find("follows its end mark"), std::string::npos) << reason;
    std::remove(file.c_str());
}

TEST(Recorder, RefusesOtherFilesTargetsAndGenerationsWithAReason) {
    const std::string file = temporary("recording");
    std::string reason;
    write(file, "PNG....................");
    EXPECT_EQ(read_all(file, reason), -1);
    EXPECT_NE(reason.find("is no recording"), std::string::npos) << reason;
    EXPECT_EQ(read_all("/nonexistent/file", reason), -1);
    EXPECT_NE(reason.find("No such file"), std::string::npos) << reason;

    RecordingHeader other = header();
    other.target = "sparc";
    make_recording(file, other);
    EXPECT_EQ(read_all(file, reason), -1);
    EXPECT_NE(reason.find("target 'sparc'"), std::string::npos) << reason;

    other = header();
    other.generation = kSimulationGeneration + 1;
    make_recording(file, other);
    EXPECT_EQ(read_all(file, reason), -1);
    EXPECT_NE(reason.find("generation"), std::string::npos) << reason;

    other = header();
    other.compiler = "another compiler";
    make_recording(file, other);
    EXPECT_EQ(read_all(file, reason), 3) << "compilers are expected to agree: " << reason;
    std::remove(file.c_str());
}

TEST(Recorder, EndsWithoutEndMarkWhenItsWriterDied) {
    const std::string file = temporary("recording");
    {
        RecordingWriter writer;
        ASSERT_TRUE(writer.open(file, header()).ok());
        writer.add_tick(1, {});
    }
    RecordingReader reader;
    ASSERT_TRUE(reader.open(file).ok());
    TickRecord record;
    EXPECT_TRUE(reader.next(record).value()) << "what was written can be replayed";
    const auto end = reader.next(record);
    ASSERT_FALSE(end.ok());
    EXPECT_NE(end.error().find("without an end mark"), std::string::npos);
    std::remove(file.c_str());
}

TEST(Recorder, SaysWhyItCannotWrite) {
    RecordingWriter writer;
    EXPECT_FALSE(writer.open("/nonexistent/folder/file", header()).ok());
    // A device that is always full: the buffer delays the failure, so close() must report it.
    if (std::FILE* full = std::fopen("/dev/full", "wb")) {
        std::fclose(full);
        ASSERT_TRUE(writer.open("/dev/full", header()).ok());
        writer.add_tick(1, {});
        const auto closed = writer.close();
        ASSERT_FALSE(closed.ok());
        EXPECT_NE(closed.error().find("No space left"), std::string::npos) << closed.error();
    }
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
}

}  // namespace
}  // namespace zoned::recording
