#include "server/compute/stages/match_stage.h"

#include "server/compute/worker_pool.h"
#include "tests/unit/compute/device_fixture.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <limits>

namespace zoned::compute {
namespace {

constexpr std::size_t kEntities = 3001;

struct Crowd {
    ParticleColumns entities;
    std::vector<kernels::MatchViewer> viewers;
    kernels::FlockRules box{};

    Crowd() {
        core::Rng rng(23);
        entities.reserve(kEntities);
        box.high_x = box.high_z = 200.0F;
        for (std::size_t i = 0; i < kEntities; ++i) {
            // Some outside of the box, some without an aura.
            entities.column(ParticleColumns::kX)[i] = rng.range(-20.0F, 220.0F);
            entities.column(ParticleColumns::kZ)[i] = rng.range(-20.0F, 220.0F);
            entities.column(kAura)[i] = rng.range(-5.0F, 60.0F);
        }
        for (int i = 0; i < 101; ++i) {
            const float x = rng.range(-20.0F, 220.0F);
            const float z = rng.range(-20.0F, 220.0F);
            viewers.push_back({x, z, i == 0 ? 0.0F : rng.range(1.0F, 80.0F)});
        }
    }

    [[nodiscard]] std::vector<std::int32_t> brute(const kernels::MatchViewer& v) const {
        std::vector<std::int32_t> out;
        for (std::size_t i = 0; i < kEntities; ++i) {
            const float dx = entities.column(ParticleColumns::kX)[i] - v.x;
            const float dz = entities.column(ParticleColumns::kZ)[i] - v.z;
            const float r = std::min(entities.column(kAura)[i], v.nimbus);
            if (r > 0.0F && dx * dx + dz * dz <= r * r) {
                out.push_back(static_cast<std::int32_t>(i));
            }
        }
        return out;
    }
};

using MatchTest = DeviceTest;

TEST_F(MatchTest, FindsWhatAllPairsFindOnLanesThreadsDevicesAndAfterAFault) {
    const Crowd crowd;
    WorkerPool pool(3);
    Team team;
    team.join_pool(pool);
    const Team::Shift shift(team);
    MatchStage cpu;
    Matches expected;
    cpu.match(crowd.entities, kEntities, crowd.box, 15.0F, crowd.viewers, expected, team);
    std::size_t most = 0;
    for (std::size_t v = 0; v < crowd.viewers.size(); ++v) {
        std::vector<std::int32_t> found(expected.of(v).begin(), expected.of(v).end());
        std::sort(found.begin(), found.end());
        ASSERT_EQ(found, crowd.brute(crowd.viewers[v])) << v;
        most = std::max(most, found.size());
    }
    EXPECT_GT(most, 64U) << "the room never had to grow";
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        for (const int launches : {-1, 1}) {
            DeviceFaults faults;
            faults.launches = launches;
            DeviceSettings settings;
            settings.testing = &faults;
            settings.buffers = mode;
            const auto device = open(settings);
            ASSERT_NE(device, nullptr);
            MatchStage stage(device.get());
            Matches matches;
            Team alone;
            const StageRun run = stage.match(
                crowd.entities, kEntities, crowd.box, 15.0F, crowd.viewers, matches, alone);
            EXPECT_EQ(run.on_device, launches < 0) << run.fault;
            ASSERT_EQ(matches.found, expected.found);
            for (std::size_t v = 0; v < crowd.viewers.size(); ++v) {
                ASSERT_TRUE(
                    std::equal(matches.of(v).begin(), matches.of(v).end(), expected.of(v).begin()));
            }
        }
    }
}

TEST_F(MatchTest, FindsTheSameWhicheverCallFails) {
    const Crowd crowd;
    Team alone;
    MatchStage cpu;
    Matches expected;
    cpu.match(crowd.entities, kEntities, crowd.box, 15.0F, crowd.viewers, expected, alone);
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        const int faults = fail_at_every_call(mode, [&](Device& device) {
            MatchStage stage(&device);
            Matches matches;
            const bool on_device =
                stage
                    .match(
                        crowd.entities, kEntities, crowd.box, 15.0F, crowd.viewers, matches, alone)
                    .on_device;
            EXPECT_EQ(matches.found, expected.found);
            for (std::size_t v = 0; v < crowd.viewers.size(); ++v) {
                EXPECT_TRUE(
                    std::equal(matches.of(v).begin(), matches.of(v).end(), expected.of(v).begin()));
            }
            return on_device;
        });
        EXPECT_GT(faults, 24) << "eleven arguments, a launch and waits, twice";
    }
}

/// Whoever is nowhere hears nobody, and is no index into the grid.
TEST_F(MatchTest, AViewerThatIsNoNumberHearsNobody) {
    Crowd crowd;
    crowd.viewers.resize(4);
    crowd.viewers[0] = {std::numeric_limits<float>::quiet_NaN(), 10.0F, 50.0F};
    crowd.viewers[1] = {10.0F, std::numeric_limits<float>::infinity(), 50.0F};
    crowd.viewers[2] = {10.0F, 10.0F, std::numeric_limits<float>::quiet_NaN()};
    const auto device = open();
    ASSERT_NE(device, nullptr);
    Team alone;
    for (Device* const on : {static_cast<Device*>(nullptr), device.get()}) {
        MatchStage stage(on);
        Matches matches;
        const StageRun run =
            stage.match(crowd.entities, kEntities, crowd.box, 15.0F, crowd.viewers, matches, alone);
        EXPECT_EQ(run.on_device, on != nullptr) << run.fault;
        EXPECT_EQ(matches.found[0], 0);
        EXPECT_EQ(matches.found[1], 0);
        EXPECT_EQ(matches.found[2], 0);
        EXPECT_EQ(static_cast<std::size_t>(matches.found[3]), crowd.brute(crowd.viewers[3]).size());
    }
}

}  // namespace
}  // namespace zoned::compute
