// Fuzzing of snapshots: any bytes are refused with a reason, or loaded; what was loaded can be
// saved and loaded again.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/config/settings.h"
#include "server/recording/recording_format.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace zoned::fuzz {

namespace {

/// Of one edit: four bytes of place, one that changes the byte there.
constexpr std::size_t kEditBytes = 5;
constexpr std::size_t kMostEdits = 8;

const config::Settings& settings() {
    static const config::Settings all = [] {
        config::Settings read;
        std::vector<config::ConfigError> errors;
        const bool ok =
            config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", {}, read, errors);
        ZONED_ASSERT(ok, "the smallest world is a valid one");
        return read;
    }();
    return all;
}

/// A world with two players after a second.
struct Original {
    Bytes bytes;
    std::size_t body = 0;  ///< behind the head and its checksum

    Original() {
        app::World world(settings(), 1);
        std::vector<mailbox::OutboxItem> out;
        std::vector<mailbox::InboxItem> items = {
            mailbox::Join{ClientId(1), "ann", "red", 3, {0.0, 0.0, 0.0}, "", false},
            mailbox::Join{ClientId(2), "bob", "blue", 3, {0.0, 0.0, 0.0}, "", false}};
        for (int i = 0; i < 30; ++i) {
            world.tick(items, out);
            items.clear();
        }
        std::vector<core::ArchiveSection> parts;
        ZONED_ASSERT(world.save(bytes, &parts).empty(), "the smallest world has a saved form");
        body = parts.front().begin - sizeof(std::uint64_t);
    }
};

const Original& original() {
    static const Original one;
    return one;
}

void run(const Bytes& bytes) {
    app::World world(settings(), 1);
    if (!world.load(bytes).empty()) {
        return;
    }
    Bytes again;
    ZONED_ASSERT(world.save(again).empty(), "what was loaded can be saved");
    app::World other(settings(), 1);
    ZONED_ASSERT(other.load(again).empty(), "and loaded again");
}

/// Makes the checksum fit, so that what lies behind it is reached.
void seal(Bytes& bytes) {
    const std::size_t body = original().body;
    if (bytes.size() < body) {
        return;
    }
    const std::uint64_t sum = recording::checksum_of(
        std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).substr(body));
    for (std::size_t b = 0; b < sizeof(sum); ++b) {
        bytes[body - sizeof(sum) + b] = static_cast<std::uint8_t>(sum >> (8U * b));
    }
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all = {{}};
    const std::size_t size = original().bytes.size();
    for (std::size_t i = 0; i < 64; ++i) {
        const std::size_t place = size * i / 64;
        all.push_back({static_cast<std::uint8_t>(place),
                       static_cast<std::uint8_t>(place >> 8U),
                       static_cast<std::uint8_t>(place >> 16U),
                       static_cast<std::uint8_t>(place >> 24U),
                       static_cast<std::uint8_t>(0xFFU >> (i % 8))});
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    fuzz::Bytes bytes = fuzz::original().bytes;
    const std::size_t edits = std::min(size / fuzz::kEditBytes, fuzz::kMostEdits);
    for (std::size_t i = 0; i < edits; ++i) {
        const std::uint8_t* edit = data + i * fuzz::kEditBytes;
        std::size_t place = 0;
        for (std::size_t b = 0; b < 4; ++b) {
            place |= static_cast<std::size_t>(edit[b]) << (8U * b);
        }
        bytes[place % bytes.size()] ^= edit[4];
    }
    if (size % fuzz::kEditBytes == 3) {
        bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), data[size - 1] * 64U));
    }
    fuzz::run(bytes);
    fuzz::seal(bytes);
    fuzz::run(bytes);
    return 0;
}
