#include "server/admin/spectator/spectator_hub.h"

#include "server/admin/spectator/spectator_layers.h"
#include "server/world/entities.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

namespace zoned::admin {
namespace {

constexpr float kTick_s = 0.05F;

float float_of(std::uint16_t half) {
    return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(half));
}

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
        rows_told = u32(12);
        ASSERT_EQ(bytes.size(),
                  SpectatorHub::kHeadBytes + 4 * removed + SpectatorHub::kRowBytes * rows_told);
        if (u32(0) == 1) {
            rows.clear();
        }
        tick = u32(4);
        std::size_t at = SpectatorHub::kHeadBytes;
        for (std::uint32_t i = 0; i < removed; ++i, at += 4) {
            EXPECT_EQ(rows.erase(u32(at)), 1U);
        }
        for (std::uint32_t i = 0; i < rows_told; ++i, at += SpectatorHub::kRowBytes) {
            std::memcpy(&rows[u32(at)], bytes.data() + at + 4, sizeof(SpectatorRow));
        }
    }

    /// Where it shows an entity, by its number; NaN when it knows none.
    [[nodiscard]] Vec3 shown(std::uint32_t id) const {
        for (const auto& [slot, row] : rows) {
            if (row.id == id) {
                const float elapsed = kTick_s * static_cast<float>(tick - row.tick);
                return {row.position[0] + elapsed * float_of(row.velocity[0]),
                        row.position[1] + elapsed * float_of(row.velocity[1]),
                        row.position[2] + elapsed * float_of(row.velocity[2])};
            }
        }
        return Vec3::Constant(std::nanf(""));
    }

    std::map<std::uint32_t, SpectatorRow> rows;  ///< by slot
    std::uint32_t tick = 0;
    std::uint32_t rows_told = 0;
};

void add(SpectatorSample& sample,
         std::uint32_t id,
         const Vec3& at,
         const Vec3& velocity = Vec3::Zero(),
         std::uint8_t flags = 0) {
    if (sample.zones.empty()) {
        sample.tick_s = kTick_s;
        sample.zones.emplace_back().number = 4;
        sample.zones.back().origin = Vec3d(1000.0, 0.0, 0.0);
    }
    SpectatorZone& zone = sample.zones.back();
    zone.id.emplace_back(id);
    zone.type.push_back(300);
    zone.flags.push_back(flags);
    zone.client.emplace_back(id == 9 ? 5U : 0U);
    zone.position.push_back(at);
    zone.orientation.push_back(Quat::Identity());
    zone.velocity.push_back(velocity);
}

SpectatorSample sample_at(std::int64_t tick) {
    SpectatorSample out;
    out.tick = tick;
    return out;
}

TEST(SpectatorHub, LeadsAViewerFromSampleToSample) {
    SpectatorHub hub;
    Viewer viewer;
    SpectatorSample first = sample_at(1);
    add(first, 1, {0, 2, 3});
    add(first, 2, {0, 0, 0});
    add(first, 9, {0, 0, 0});
    viewer.take(hub.update(first, {}));
    EXPECT_EQ(viewer.rows.size(), 3U);
    SpectatorSample second = sample_at(2);
    add(second, 9, {0, 0, 0});
    add(second, 1, {5, 2, 3});
    add(second, 4, {1, 0, 0});
    viewer.take(hub.update(second, {}));
    EXPECT_EQ(viewer.rows.size(), 3U);
    EXPECT_EQ(viewer.rows_told, 2U) << "9 has not changed";
    EXPECT_TRUE(viewer.shown(1).isApprox(Vec3(1005, 2, 3)));
    EXPECT_TRUE(std::isnan(viewer.shown(2).x()));
    Viewer late;
    late.take(hub.everything());
    EXPECT_EQ(late.rows.size(), 3U);
    EXPECT_TRUE(late.shown(4).isApprox(Vec3(1001, 0, 0)));
}

TEST(SpectatorHub, TellsWhatGoesStraightOnOnce) {
    SpectatorHub hub;
    Viewer viewer;
    const Vec3 velocity(1.4F, 0.0F, -0.3F);
    for (int tick = 1; tick <= 200; ++tick) {
        SpectatorSample sample = sample_at(tick);
        const Vec3 at = Vec3(10, 1, 10) + velocity * (kTick_s * static_cast<float>(tick));
        add(sample, 1, at, velocity);
        viewer.take(hub.update(sample, {}));
        EXPECT_LE((viewer.shown(1) - at - Vec3(1000, 0, 0)).norm(),
                  SpectatorHub::kLeastError_m + 1e-3F);
    }
    EXPECT_GE(viewer.tick - viewer.rows.begin()->second.tick, 4U);
}

/// The bound that the messages promise holds whatever entities do, for each eye.
TEST(SpectatorHub, KeepsItsBoundForTheNearestEye) {
    SpectatorHub hub;
    Viewer viewer;
    SpectatorWish far;
    far.eye = {1000.0F, 400.0F, 0.0F};
    SpectatorWish near = far;
    near.eye = {1000.0F, 20.0F, 0.0F};
    std::size_t rows_far = 0;
    std::size_t rows_near = 0;
    for (int tick = 1; tick <= 400; ++tick) {
        const bool close = tick > 200;
        SpectatorSample sample = sample_at(tick);
        const float turn = 0.1F * static_cast<float>(tick);
        const Vec3 at(2.0F * std::cos(turn), 1.0F, 2.0F * std::sin(turn));
        add(sample, 1, at, Vec3(-4.0F * std::sin(turn), 0.0F, 4.0F * std::cos(turn)));
        const std::vector<SpectatorWish> wishes = close ? std::vector{far, near} : std::vector{far};
        viewer.take(hub.update(sample, wishes));
        const float distance =
            (at + Vec3(1000, 0, 0) - Vec3(wishes.back().eye[0], wishes.back().eye[1], 0.0F)).norm();
        const float bound =
            std::max(SpectatorHub::kLeastError_m, SpectatorHub::kErrorPerMetre * distance);
        EXPECT_LE((viewer.shown(1) - at - Vec3(1000, 0, 0)).norm(), bound + 1e-3F) << tick;
        (close ? rows_near : rows_far) += viewer.rows_told;
    }
    EXPECT_LT(2 * rows_far, rows_near) << "a far eye costs as much as a near one";
}

TEST(SpectatorHub, SaysOnlyWhatChanged) {
    SpectatorHub hub;
    SpectatorSample sample = sample_at(1);
    for (std::uint32_t id = 1; id <= 1000; ++id) {
        add(sample, id, {static_cast<float>(id), 0, 0}, Vec3::Zero(), world::kAtRest);
    }
    EXPECT_EQ(hub.update(sample, {})->size(),
              SpectatorHub::kHeadBytes + 1000 * SpectatorHub::kRowBytes);
    EXPECT_EQ(hub.update(sample, {})->size(), SpectatorHub::kHeadBytes);
    sample.zones[0].position[7].x() += 1.0F;
    EXPECT_EQ(hub.update(sample, {})->size(), SpectatorHub::kHeadBytes + SpectatorHub::kRowBytes);
    sample.zones[0].orientation[3] = Quat(Eigen::AngleAxisf(0.1F, Vec3::UnitY()));
    EXPECT_EQ(hub.update(sample, {})->size(), SpectatorHub::kHeadBytes + SpectatorHub::kRowBytes);
    sample.zones.clear();
    EXPECT_EQ(hub.update(sample, {})->size(), SpectatorHub::kHeadBytes + 4 * 1000);
    EXPECT_EQ(hub.everything()->size(), SpectatorHub::kHeadBytes);
}

TEST(SpectatorHub, ShowsNeitherGhostsNorWhatIsHidden) {
    SpectatorHub hub;
    Viewer viewer;
    SpectatorSample sample = sample_at(1);
    add(sample, 1, {0, 0, 0}, Vec3::Zero(), world::kGhost);
    add(sample, 2, {0, 0, 0}, Vec3::Zero(), world::kHidden);
    add(sample, 9, {0, 0, 0});
    viewer.take(hub.update(sample, {}));
    ASSERT_EQ(viewer.rows.size(), 1U);
    EXPECT_EQ(viewer.rows.begin()->second.flags, kSpectatorAvatar);
    EXPECT_EQ(viewer.rows.begin()->second.zone, 4);
}

/// The columns of a suspended agent are those of its last event; the walker tells where it is.
TEST(SpectatorHub, FollowsAgentsOffScreen) {
    SpectatorHub hub;
    Viewer viewer;
    SpectatorSample sample = sample_at(1);
    add(sample, 1, {10, 1, 10}, Vec3(7, 0, 0), world::kDozing);
    viewer.take(hub.update(sample, {}));
    EXPECT_TRUE(viewer.shown(1).isApprox(Vec3(1010, 1, 10)));
    sample.tick = 21;
    sample.walkers.push_back({0, 0, Vec2(12, 10), Vec2(2, 0)});
    viewer.take(hub.update(sample, {}));
    EXPECT_TRUE(viewer.shown(1).isApprox(Vec3(1012, 1, 10)));
    sample.tick = 31;
    sample.walkers.clear();
    viewer.take(hub.update(sample, {}));
    EXPECT_EQ(viewer.rows_told, 0U) << "its turn has not come";
    EXPECT_TRUE(viewer.shown(1).isApprox(Vec3(1013, 1, 10)));
}

TEST(SpectatorHub, BeginsAnewAfterNobodyLooked) {
    SpectatorHub hub;
    SpectatorSample sample = sample_at(1);
    add(sample, 1, {0, 0, 0});
    hub.update(sample, {});
    hub.clear();
    EXPECT_EQ(hub.everything()->size(), SpectatorHub::kHeadBytes);
    EXPECT_EQ(hub.update(sample, {})->size(), SpectatorHub::kHeadBytes + SpectatorHub::kRowBytes);
}

/// A page that is left open costs the server as much in the evening as in the morning, whatever
/// came and went meanwhile.
TEST(SpectatorHub, HoldsNoMoreAfterADay) {
    constexpr std::uint32_t kDay = 24 * 3600 * 20;
    SpectatorHub hub;
    SpectatorLayers layers;
    SpectatorSample sample = sample_at(0);
    sample.layers = kLayerSofts;
    for (std::uint32_t id = 1; id <= 4; ++id) {
        add(sample, id, {static_cast<float>(id), 0, 0});
    }
    sample.softs.push_back({EntityId(1), Vec3d::Zero(), {{0, 0, 0}}, {{{0, 0, 0}}}, {}});
    std::uint32_t largest_slot = 0;
    std::size_t longest = 0;
    std::size_t held = 0;
    for (std::uint32_t tick = 1; tick <= kDay; ++tick) {
        sample.tick = tick;
        sample.zones[0].id[tick % 4] = EntityId(4 + tick);  // one goes and one comes
        sample.softs[0].entity = sample.zones[0].id[tick % 4];
        const SpectatorMessage message = hub.update(sample, {});
        for (const SpectatorLayers::Message& layer : layers.update(sample, false)) {
            longest = std::max(longest, layer.bytes->size());
        }
        longest = std::max(longest, message->size());
        std::uint32_t slot = 0;  // of the row, behind the slot that was removed
        if (tick > 1) {
            std::memcpy(&slot, message->data() + SpectatorHub::kHeadBytes + 4, sizeof(slot));
        }
        largest_slot = std::max(largest_slot, slot);
        if (tick == kDay / 100) {
            held = ::mallinfo2().uordblks;
        }
    }
    EXPECT_EQ(hub.size(), 4U);
    EXPECT_LE(largest_slot, 4U);
    EXPECT_LE(longest, SpectatorHub::kHeadBytes + 4 * (4 + SpectatorHub::kRowBytes));
    EXPECT_LE(::mallinfo2().uordblks, held + 4096U);
}

TEST(SpectatorLayers, TellsFacesOnceAndPlacesAlways) {
    SpectatorLayers layers;
    SpectatorSample sample = sample_at(7);
    sample.layers = kLayerSofts | kLayerJoints;
    sample.softs.push_back(
        {EntityId(3), Vec3d(1000, 0, 0), {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, {{{0, 1, 2}}}, {}});
    sample.joints.push_back({Vec3d(1, 2, 3), Vec3d(4, 5, 6), Vec3d(7, 8, 9)});
    const auto first = layers.update(sample, false);
    ASSERT_EQ(first.size(), 2U);
    EXPECT_EQ(first[0].bytes->size(), 16U + 36U);
    EXPECT_EQ(first[1].bytes->size(), 16U + 16U + 36U + 12U);
    EXPECT_EQ(layers.update(sample, false)[1].bytes->size(), 16U + 16U + 36U);
    EXPECT_EQ(layers.update(sample, true)[1].bytes->size(), 16U + 16U + 36U + 12U);
    sample.softs[0].faces.push_back({{0, 2, 1}});  // torn or mended
    EXPECT_EQ(layers.update(sample, false)[1].bytes->size(), 16U + 16U + 36U + 24U);
}

TEST(SpectatorLayers, TellsHowRulesHaveMovedDoorsAndPlatforms) {
    SpectatorLayers layers;
    SpectatorSample sample = sample_at(7);
    sample.layers = kLayerMoved;
    sample.moved_doors = {0, 1};
    sample.moved_platforms = {-3, 40, 900};
    const auto messages = layers.update(sample, false);
    ASSERT_EQ(messages.size(), 1U);
    std::array<std::int32_t, 9> words{};
    ASSERT_EQ(messages[0].bytes->size(), sizeof(words));
    std::memcpy(words.data(), messages[0].bytes->data(), sizeof(words));
    EXPECT_EQ(words, (std::array<std::int32_t, 9>{7, 7, 2, 0, 0, 1, -3, 40, 900}));
}

TEST(SpectatorLayers, TellsOnceHowDrawnVerticesHangOnNodes) {
    SpectatorLayers layers;
    SpectatorSample sample = sample_at(7);
    sample.layers = kLayerSofts;
    const physics::soft::SoftVertex middle{{0, 1, 2, 0}, {0.25F, 0.25F, 0.5F, 0.0F}, 0.125F};
    sample.softs.push_back({EntityId(3),
                            Vec3d::Zero(),
                            {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                            {{{0, 1, 2}}},
                            {middle, middle, middle}});
    const SpectatorMessage first = layers.update(sample, false)[0].bytes;
    ASSERT_EQ(first->size(), 16U + 16U + 36U + 12U + 3U * 36U);
    physics::soft::SoftVertex last;
    std::memcpy(&last, first->data() + first->size() - sizeof(last), sizeof(last));
    EXPECT_EQ(last, middle);
    EXPECT_EQ(layers.update(sample, false)[0].bytes->size(), 16U + 16U + 36U);
    sample.softs[0].hung[1].offset = 0.25F;  // another body in its place
    EXPECT_EQ(layers.update(sample, false)[0].bytes->size(), first->size());
}

}  // namespace
}  // namespace zoned::admin
