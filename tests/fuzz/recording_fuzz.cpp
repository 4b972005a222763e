// Fuzzing of recordings: any bytes are refused with a reason, or read up to their end or a damage;
// what was read can be written and read back.
#include "server/recording/recording_file.h"
#include "server/recording/recording_reader.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>

namespace zoned::fuzz {

namespace {

using recording::FrameHeadBytes;
using recording::RecordingFile;
using recording::RecordingReader;
using recording::TickRecord;

constexpr std::size_t kMaxBytes = 65536;

std::string file_named(const char* what) {
    static const std::string base = "/dev/shm/zoned_fuzz_" + std::to_string(::getpid()) + "_";
    return base + what;
}

/// Its files go with the process.
struct RemoveFiles {
    RemoveFiles() = default;
    RemoveFiles(const RemoveFiles&) = delete;
    RemoveFiles& operator=(const RemoveFiles&) = delete;

    ~RemoveFiles() {
        std::remove(file_named("in").c_str());
        std::remove(file_named("out").c_str());
    }
};

const RemoveFiles remove_files;

std::vector<TickRecord> read_all(const std::string& file, std::string& reason) {
    std::vector<TickRecord> ticks;
    RecordingReader reader;
    const auto opened = reader.open(file);
    if (!opened.ok()) {
        reason = opened.error();
        ZONED_ASSERT(!reason.empty(), "a refusal has a reason");
        return ticks;
    }
    [[maybe_unused]] const auto comparable = reader.check_build();
    for (TickRecord record;;) {
        const auto more = reader.next(record);
        if (!more.ok()) {
            reason = more.error();
            ZONED_ASSERT(!reason.empty(), "a damage has a reason");
            ZONED_ASSERT(!reader.next(record).ok(), "a damage stays one");
        }
        if (!more.ok() || !*more) {
            return ticks;
        }
        ZONED_ASSERT(ticks.empty() || ticks.back().tick < record.tick, "ticks ascend");
        ticks.push_back(record);
    }
}

void run(const std::string& bytes) {
    std::ofstream(file_named("in"), std::ios::binary | std::ios::trunc) << bytes;
    std::string reason;
    const std::vector<TickRecord> ticks = read_all(file_named("in"), reason);
    std::optional<recording::RecordedState> state;
    RecordingReader sought;
    if (sought.open(file_named("in")).ok()) {
        state = sought.state();
        TickRecord record;
        const auto found = sought.seek(2);
        if (found.ok() && *found && sought.next(record).ok()) {
            ZONED_ASSERT(record.tick >= 2, "a seek goes far enough");
        }
    }
    if (ticks.empty()) {
        return;
    }
    RecordingFile copy;
    ZONED_ASSERT(copy.open(file_named("out"),
                           recording::RecordingHeader::of_this_build(),
                           state ? &*state : nullptr)
                     .ok(),
                 "memory has room");
    for (const TickRecord& record : ticks) {
        copy.add_tick(record);
    }
    ZONED_ASSERT(copy.close().ok(), "memory has room");
    RecordingReader copied;
    ZONED_ASSERT(copied.open(file_named("out")).ok() && copied.state().has_value() == !!state &&
                     (!state || (copied.state()->tick == state->tick &&
                                 copied.state()->bytes == state->bytes)),
                 "and so can the state that it begins with");
    std::string none;
    const std::vector<TickRecord> again = read_all(file_named("out"), none);
    // A tick without hashes ends a recording.
    std::size_t whole = 0;
    while (whole < ticks.size() && !ticks[whole].hashes.empty()) {
        ++whole;
    }
    ZONED_ASSERT(again.size() >= whole && (whole < ticks.size() || none.empty()),
                 "what was read can be written and read back");
    for (std::size_t i = 0; i < whole; ++i) {
        ZONED_ASSERT(again[i].tick == ticks[i].tick && again[i].hashes == ticks[i].hashes &&
                         again[i].items.size() == ticks[i].items.size(),
                     "and is the same then");
    }
}

/// Makes checksums fit, so that what lies behind them is reached.
std::string sealed(std::string bytes) {
    std::size_t at = recording::kMagicBytes;
    while (bytes.size() >= at + recording::kFrameHeadBytes) {
        recording::FrameHead head;
        std::uint32_t kind = 0;
        std::memcpy(&head.length, bytes.data() + at, 4);
        std::memcpy(&kind, bytes.data() + at + 4, 4);
        std::memcpy(&head.tick, bytes.data() + at + 8, 8);
        head.kind = static_cast<recording::FrameKind>(kind);
        const std::size_t payload = at + recording::kFrameHeadBytes;
        head.length =
            static_cast<std::uint32_t>(std::min<std::size_t>(head.length, bytes.size() - payload));
        head.checksum =
            recording::checksum_of(std::string_view(bytes).substr(payload, head.length));
        const FrameHeadBytes fitting = recording::encode_head(head);
        std::memcpy(bytes.data() + at, fitting.data(), fitting.size());
        at = payload + head.length;
    }
    return bytes;
}

Bytes content(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

std::vector<Bytes> seeds() {
    motion::InputCommand command;
    command.tick = 3;
    command.move_x = -127;
    const std::vector<mailbox::InboxItem> items = {
        mailbox::Join{ClientId(1), "ann", "red", 3, {1.0, 2.0, 3.0}, "account", true},
        mailbox::Input{ClientId(1), {command, command}},
        mailbox::Acks{ClientId(1), 7, 0xFU, 1000, 2000},
        mailbox::Command{ClientId(1), 9, {1, 2, 3}, 4},
        mailbox::Confirm{ClientId(1), EventId(5)},
        mailbox::Freeze{true},
        mailbox::NewBrains{std::make_shared<const std::string>("brain {}"), nullptr},
        mailbox::ViewReset{ClientId(1)},
        mailbox::Reach{ClientId(1), false},
        mailbox::AuditRequest{ClientId(1)},
        mailbox::CodecPrice{100, 200},
        mailbox::SpawnOrder{1, 2, {1.0, 2.0, 3.0}, 4},
        mailbox::MoveOrder{2, EntityId(7), {1.0, 2.0, 3.0}},
        mailbox::StoreAnswer{3,
                             mailbox::StoreAct::kGet,
                             mailbox::StoreStatus::kDone,
                             ZoneId(1),
                             EntityId(7),
                             {mailbox::StoreScope::kCharacter, "ann", "hero", "bag"},
                             {1, 2, 3}},
        mailbox::Notice{ClientId(1), "noon"},
        mailbox::SessionBegun{ClientId(1), {1, 2, 3}, "account", "ann", "red", 3, true},
        mailbox::SessionProgress{ClientId(1), 9, 5},
        mailbox::StoreKept{2},
        mailbox::Leave{ClientId(1), mailbox::LeaveReason::kShutdown}};
    static_assert(std::variant_size_v<mailbox::InboxItem> == 19, "a new message is a new seed");
    std::vector<Bytes> all;
    recording::RecordingHeader header = recording::RecordingHeader::of_this_build();
    header.config_text = "world { name: \"x\" }";
    const recording::RecordedState state{40, {1, 2, 3, 4}};
    for (const bool closes : {true, false}) {
        for (const bool begins : {true, false}) {
            RecordingFile file;
            ZONED_ASSERT(file.open(file_named("out"), header, begins ? &state : nullptr).ok(),
                         "memory has room");
            const Tick before = begins ? state.tick : 0;
            file.add_tick({before + 1, items, {1, 2}});
            file.add_tick({before + 2, {}, {3, 4}});
            file.add_tick({before + 3,
                           {items[1]},
                           closes ? std::vector<std::uint64_t>{5} : std::vector<std::uint64_t>{}});
            if (closes) {
                ZONED_ASSERT(file.close().ok(), "memory has room");
            }
            file.flush();
            all.push_back(content(file_named("out")));
        }
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    const std::string bytes(reinterpret_cast<const char*>(data), std::min(size, fuzz::kMaxBytes));
    fuzz::run(bytes);
    fuzz::run(fuzz::sealed(bytes));
    return 0;
}
