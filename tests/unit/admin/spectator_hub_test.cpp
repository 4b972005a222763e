#include "server/admin/spectator_hub.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

namespace zoned::admin {
namespace {

/// What a viewer knows after the messages that it got.
class Viewer {
  public:
    void take(const SpectatorMessage& message) {
        ASSERT_NE(message, nullptr);
        const std::string& bytes = *message;
        ASSERT_GE(bytes.size(), SpectatorHub::kHeadBytes);
        const auto u32 = [&](std::size_t at) {
            std::uint32_t value = 0;
            std::memcpy(&value, bytes.data() + at, sizeof(value));
            return value;
        };
        const std::uint32_t removed = u32(8);
        const std::uint32_t rows_here = u32(12);
        ASSERT_EQ(bytes.size(),
                  SpectatorHub::kHeadBytes + 4 * removed + SpectatorHub::kRowBytes * rows_here);
        if (u32(0) == 1) {
            rows.clear();
        }
        std::size_t at = SpectatorHub::kHeadBytes;
        for (std::uint32_t i = 0; i < removed; ++i, at += 4) {
            EXPECT_EQ(rows.erase(u32(at)), 1U);
        }
        for (std::uint32_t i = 0; i < rows_here; ++i, at += SpectatorHub::kRowBytes) {
            SpectatorRow row;
            std::memcpy(&row.id, bytes.data() + at, 4);
            std::memcpy(row.position.data(), bytes.data() + at + 4, 12);
            std::memcpy(row.orientation.data(), bytes.data() + at + 16, 8);
            std::memcpy(&row.type, bytes.data() + at + 24, 2);
            row.flags = static_cast<std::uint8_t>(bytes[at + 26]);
            row.zone = static_cast<std::uint8_t>(bytes[at + 27]);
            rows[row.id] = row;
        }
    }

    std::map<std::uint32_t, SpectatorRow> rows;
};

SpectatorRow row(std::uint32_t id, float x) {
    SpectatorRow out;
    out.id = id;
    out.position = {x, 2.0F, 3.0F};
    out.orientation = {0, 0, -5, 32767};
    out.type = 300;
    out.flags = kSpectatorAtRest;
    out.zone = 4;
    return out;
}

TEST(SpectatorHub, LeadsAViewerFromSampleToSample) {
    SpectatorHub hub;
    Viewer viewer;
    viewer.take(hub.update({1, {row(1, 0), row(2, 0), row(3, 0)}}));
    viewer.take(hub.update({2, {row(3, 0), row(1, 5), row(4, 1)}}));
    ASSERT_EQ(viewer.rows.size(), 3U);
    EXPECT_EQ(viewer.rows.at(1), row(1, 5));
    EXPECT_EQ(viewer.rows.at(3), row(3, 0));
    EXPECT_EQ(viewer.rows.at(4), row(4, 1));
    Viewer late;
    late.take(hub.everything());
    EXPECT_EQ(late.rows, viewer.rows);
}

TEST(SpectatorHub, SaysOnlyWhatChanged) {
    SpectatorHub hub;
    SpectatorSample sample{1, {}};
    for (std::uint32_t id = 1; id <= 1000; ++id) {
        sample.rows.push_back(row(id, 0));
    }
    EXPECT_EQ(hub.update(sample)->size(),
              SpectatorHub::kHeadBytes + 1000 * SpectatorHub::kRowBytes);
    EXPECT_EQ(hub.update(sample), nullptr);
    sample.rows[7].position[0] = 1.0F;
    EXPECT_EQ(hub.update(sample)->size(), SpectatorHub::kHeadBytes + SpectatorHub::kRowBytes);
    sample.rows.clear();
    EXPECT_EQ(hub.update(sample)->size(), SpectatorHub::kHeadBytes + 4 * 1000);
    EXPECT_EQ(hub.everything()->size(), SpectatorHub::kHeadBytes);
}

TEST(SpectatorHub, BeginsAnewAfterNobodyLooked) {
    SpectatorHub hub;
    hub.update({1, {row(1, 0)}});
    hub.clear();
    EXPECT_EQ(hub.everything()->size(), SpectatorHub::kHeadBytes);
    EXPECT_EQ(hub.update({2, {row(1, 0)}})->size(),
              SpectatorHub::kHeadBytes + SpectatorHub::kRowBytes);
}

}  // namespace
}  // namespace zoned::admin
