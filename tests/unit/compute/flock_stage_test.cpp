#include "server/compute/stages/flock_stage.h"

#include "server/compute/worker_pool.h"
#include "tests/bench/plain_flock.h"
#include "tests/scenario/flock.h"
#include "tests/unit/compute/device_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

namespace zoned::compute {
namespace {

ParticleColumns flock_of(std::size_t count, const kernels::FlockRules& rules) {
    ParticleColumns columns;
    columns.reserve(count);
    scenario::scatter_flock(count, rules, [&](std::size_t i, auto... values) {
        std::size_t c = 0;
        ((columns.column(c++)[i] = values), ...);
    });
    return columns;
}

bool same_bits(const ParticleColumns& a, const ParticleColumns& b, std::size_t count) {
    for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
        if (std::memcmp(a.column(c), b.column(c), count * sizeof(float)) != 0) {
            return false;
        }
    }
    return true;
}

class FlockStageTest : public DeviceTest {};

TEST_F(FlockStageTest, GivesTheSameBitsOnADeviceAndOnAnyNumberOfThreads) {
    const std::size_t count = 5003;
    const auto rules = scenario::flock_rules(count);
    const auto device = open();
    ASSERT_NE(device, nullptr);
    ParticleColumns one = flock_of(count, rules);
    ParticleColumns three = flock_of(count, rules);
    ParticleColumns other = flock_of(count, rules);
    FlockStage on_one, on_three;
    FlockStage on_device(device.get());
    Team alone;
    WorkerPool pool(3);
    Team team;
    team.join_pool(pool);
    const Team::Shift shift(team);
    for (int step = 0; step < 40; ++step) {
        on_one.step(one, count, rules, alone);
        on_three.step(three, count, rules, team);
        const StageRun run = on_device.step(other, count, rules, alone);
        ASSERT_TRUE(run.on_device) << run.fault;
    }
    EXPECT_TRUE(same_bits(one, three, count));
    EXPECT_TRUE(same_bits(one, other, count));
}

/// Directions along circles around the middle of the box, 10 m cells.
std::vector<float> circles(kernels::FlockRules& rules) {
    rules.follow = 1.5F;
    rules.field_cells_per_m = 0.1F;
    rules.field_columns = static_cast<int>(rules.high_x * 0.1F) + 1;
    rules.field_rows = static_cast<int>(rules.high_z * 0.1F) + 1;
    std::vector<float> field;
    for (int row = 0; row < rules.field_rows; ++row) {
        for (int column = 0; column < rules.field_columns; ++column) {
            const float x = 10.0F * (static_cast<float>(column) + 0.5F) - rules.high_x / 2;
            const float z = 10.0F * (static_cast<float>(row) + 0.5F) - rules.high_z / 2;
            const float r = std::max(1.0F, std::hypot(x, z));
            field.push_back(-z / r);
            field.push_back(x / r);
        }
    }
    return field;
}

TEST_F(FlockStageTest, FollowsAFieldAlikeOnADeviceAndOnAnyNumberOfThreads) {
    const std::size_t count = 5003;
    auto rules = scenario::flock_rules(count);
    const std::vector<float> field = circles(rules);
    const auto device = open();
    ASSERT_NE(device, nullptr);
    ParticleColumns one = flock_of(count, rules);
    ParticleColumns three = flock_of(count, rules);
    ParticleColumns other = flock_of(count, rules);
    ParticleColumns tiled = flock_of(count, rules);
    FlockStage on_one, on_three;
    FlockStage on_device(device.get());
    FlockStage on_tiles(device.get(), {0, FlockKernelOptions::Tiles::kOn, 64});
    Team alone;
    WorkerPool pool(3);
    Team team;
    team.join_pool(pool);
    const Team::Shift shift(team);
    for (int step = 0; step < 120; ++step) {
        on_one.step(one, count, rules, alone, field);
        on_three.step(three, count, rules, team, field);
        ASSERT_TRUE(on_device.step(other, count, rules, alone, field).on_device);
        ASSERT_TRUE(on_tiles.step(tiled, count, rules, alone, field).on_device);
    }
    EXPECT_TRUE(same_bits(one, three, count));
    EXPECT_TRUE(same_bits(one, other, count));
    EXPECT_TRUE(same_bits(one, tiled, count));
    // In 2 s at 1.5 / s most have turned into the circles; their directions began at random.
    double along = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = static_cast<double>(one.column(0)[i] - rules.high_x / 2);
        const double z = static_cast<double>(one.column(2)[i] - rules.high_z / 2);
        const double vx = static_cast<double>(one.column(3)[i]);
        const double vz = static_cast<double>(one.column(5)[i]);
        along += (-z * vx + x * vz) / (std::hypot(x, z) * std::hypot(vx, vz));
    }
    EXPECT_GT(along / static_cast<double>(count), 0.8);
}

using Tiles = FlockKernelOptions::Tiles;

/// A flock, its rules, and how its steps go on the CPU.
struct Reference {
    Reference(ParticleColumns made, std::size_t agents, const kernels::FlockRules& how)
        : before(std::move(made)),
          count(agents),
          rules(how),
          after(copy(before, count)) {
        FlockStage stage;
        Team alone;
        for (int step = 0; step < kSteps; ++step) {
            stage.step(after, count, rules, alone);
        }
    }

    static ParticleColumns copy(const ParticleColumns& from, std::size_t count) {
        ParticleColumns to;
        to.reserve(count);
        for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
            std::memcpy(to.column(c), from.column(c), count * sizeof(float));
        }
        return to;
    }

    /// Whether a device comes to the same bits.
    [[nodiscard]] bool is_met_by(Device& device, const FlockKernelOptions& options) const {
        ParticleColumns agents = copy(before, count);
        FlockStage stage(&device, options);
        Team alone;
        for (int step = 0; step < kSteps; ++step) {
            const StageRun run = stage.step(agents, count, rules, alone);
            if (!run.on_device) {
                ADD_FAILURE() << run.fault;
                return false;
            }
        }
        return same_bits(agents, after, count);
    }

    static constexpr int kSteps = 3;
    ParticleColumns before;
    std::size_t count;
    kernels::FlockRules rules;
    ParticleColumns after;
};

/// Tiles of less than a cell, of a part of a row and of more than a group needs; groups of one
/// batch, of an odd number and of more than there are.
void expect_same_bits_for_all_tiles(Device& device, const Reference& reference) {
    EXPECT_TRUE(reference.is_met_by(device, {0, Tiles::kOff, 0}));
    for (const std::size_t group : {1U, 5U, 64U}) {
        for (const std::size_t tile : {1U, 7U, 512U}) {
            EXPECT_TRUE(reference.is_met_by(device, {group, Tiles::kOn, tile}))
                << "groups of " << group << ", tiles of " << tile;
        }
    }
    // Cut to the limits of the kernel and of local memory.
    EXPECT_TRUE(reference.is_met_by(device, {SIZE_MAX, Tiles::kOn, SIZE_MAX}));
    EXPECT_TRUE(reference.is_met_by(device, {SIZE_MAX, Tiles::kOff, 0}));
}

TEST_F(FlockStageTest, TilesGiveTheSameBitsWhateverTheirSize) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    const std::size_t count = 2003;
    const auto rules = scenario::flock_rules(count);
    expect_same_bits_for_all_tiles(*device, {flock_of(count, rules), count, rules});
}

TEST_F(FlockStageTest, TilesGiveTheSameBitsWhereAllAgentsAreInOneCell) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    const std::size_t count = 301;
    auto rules = scenario::flock_rules(count);
    rules.high_x = rules.low_x + 2.0F;  // less than a cell, which is 3 m wide
    rules.high_z = rules.low_z + 2.0F;
    const Reference reference(flock_of(count, rules), count, rules);
    FlockStage probe;
    Team alone;
    ParticleColumns agents = Reference::copy(reference.before, count);
    probe.step(agents, count, rules, alone);
    ASSERT_EQ(probe.order().cell_begin().size(), 2U) << "one cell and the end";
    expect_same_bits_for_all_tiles(*device, reference);
}

/// Heaps in opposite corners, in the middle and outside of the grid: most rows and cells are empty,
/// and a group's batches are of rows far apart.
TEST_F(FlockStageTest, TilesGiveTheSameBitsAcrossEmptyCellsAndAtTheRim) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    const std::size_t count = 403;
    const auto rules = scenario::flock_rules(20'000);
    const float wide = rules.high_x;
    ParticleColumns agents = flock_of(count, rules);
    const float corners[][2] = {{0.0F, 0.0F},
                                {wide - 6.0F, wide - 6.0F},
                                {0.5F * wide, 0.5F * wide},
                                {0.5F * wide, -9.0F},
                                {wide + 9.0F, 0.3F * wide}};
    for (std::size_t i = 0; i < count; ++i) {
        const auto& corner = corners[i % std::size(corners)];
        float& x = agents.column(ParticleColumns::kX)[i];
        float& z = agents.column(ParticleColumns::kZ)[i];
        x = corner[0] + 6.0F * x / wide;
        z = corner[1] + 6.0F * z / wide;
    }
    expect_same_bits_for_all_tiles(*device, {std::move(agents), count, rules});
}

TEST_F(FlockStageTest, TilesGiveTheSameBitsForOneAgent) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    const auto rules = scenario::flock_rules(1);
    const Reference reference(flock_of(1, rules), 1, rules);
    EXPECT_FALSE(same_bits(reference.before, reference.after, 1)) << "it moves";
    expect_same_bits_for_all_tiles(*device, reference);
}

TEST_F(FlockStageTest, TilesOfCopiedBuffersGiveTheSameBits) {
    DeviceSettings settings;
    settings.buffers = BufferMode::kCopied;
    const auto device = open(settings);
    ASSERT_NE(device, nullptr);
    const std::size_t count = 1001;
    const auto rules = scenario::flock_rules(count);
    const Reference reference(flock_of(count, rules), count, rules);
    EXPECT_TRUE(reference.is_met_by(*device, {0, Tiles::kOn, 0}));
    EXPECT_TRUE(reference.is_met_by(*device, {0, Tiles::kOff, 0}));
}

TEST_F(FlockStageTest, ADeviceThatDiesHalfwayLosesNothing) {
    const std::size_t count = 1203;
    const auto rules = scenario::flock_rules(count);
    const Reference reference(flock_of(count, rules), count, rules);
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        for (const Tiles tiles : {Tiles::kOff, Tiles::kOn}) {
            for (const int launches : {0, 1}) {
                DeviceFaults faults;
                faults.launches = launches;
                faults.share_run = 0.5;
                DeviceSettings settings;
                settings.testing = &faults;
                settings.buffers = mode;
                const auto device = open(settings);
                ASSERT_NE(device, nullptr);
                FlockStage stage(device.get(), {16, tiles, 0});
                ParticleColumns agents = Reference::copy(reference.before, count);
                Team alone;
                int faulty = 0;
                for (int step = 0; step < Reference::kSteps; ++step) {
                    const StageRun run = stage.step(agents, count, rules, alone);
                    EXPECT_EQ(run.on_device, step < launches) << run.fault;
                    faulty += run.fault.empty() ? 0 : 1;
                }
                EXPECT_EQ(faulty, 1) << "said once";
                EXPECT_TRUE(same_bits(agents, reference.after, count));
            }
        }
    }
}

TEST_F(FlockStageTest, WhicheverCallFailsTheStepIsDoneOnce) {
    const std::size_t count = 203;
    const auto rules = scenario::flock_rules(count);
    const Reference reference(flock_of(count, rules), count, rules);
    Team alone;
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        const int faults = fail_at_every_call(mode, [&](Device& device) {
            FlockStage stage(&device, {8, Tiles::kOn, 32});
            ParticleColumns agents = Reference::copy(reference.before, count);
            bool on_device = true;
            for (int step = 0; step < Reference::kSteps; ++step) {
                on_device = stage.step(agents, count, rules, alone).on_device;
            }
            EXPECT_TRUE(same_bits(agents, reference.after, count));
            return on_device;
        });
        EXPECT_GT(faults, 30) << "eleven arguments, a launch and a wait, three times";
    }
}

TEST(FlockOrder, HasAtMostSoManyCellsWhateverTheBox) {
    FlockOrder order;
    Team alone;
    ParticleColumns agents;
    agents.reserve(3);
    for (const auto& [width, depth] : {std::pair{100.0F, 80.0F},
                                       std::pair{1e9F, 1.0F},
                                       std::pair{1.0F, 1e12F},
                                       std::pair{1e25F, 1e25F},
                                       std::pair{3e38F, 0.0F},
                                       std::pair{-5.0F, -5.0F}}) {
        kernels::FlockRules rules{};
        rules.high_x = width;
        rules.high_z = depth;
        agents.column(ParticleColumns::kX)[0] = width;
        agents.column(ParticleColumns::kZ)[0] = depth;
        agents.column(ParticleColumns::kX)[1] = -1e30F;
        agents.column(ParticleColumns::kZ)[2] = std::numeric_limits<float>::quiet_NaN();
        order.sort(agents, 3, rules, 3.0F, alone);
        EXPECT_GE(order.grid().columns, 1);
        EXPECT_GE(order.grid().rows, 1);
        EXPECT_LE(order.cell_begin().size(), FlockOrder::kMostCells + 1) << width << " " << depth;
        EXPECT_EQ(order.cell_begin().back(), 3);
    }
}

TEST(ChooseTile, IsOfTheDevicesOwnLocalMemoryUnlessAskedForOtherwise) {
    DeviceInfo gpu;
    gpu.own_local_memory = true;
    gpu.local_bytes = 48U << 10U;
    DeviceInfo cpu;
    cpu.local_bytes = 512U << 10U;
    EXPECT_EQ(choose_tile(gpu, {}), 512U);
    EXPECT_EQ(choose_tile(gpu, {0, Tiles::kOff, 64}), 0U);
    EXPECT_EQ(choose_tile(gpu, {0, Tiles::kOn, SIZE_MAX}), 1024U) << "half of it, 24 bytes each";
    EXPECT_EQ(choose_tile(cpu, {}), 0U);
    EXPECT_EQ(choose_tile(cpu, {0, Tiles::kOn, 64}), 64U);
    EXPECT_EQ(choose_tile({}, {0, Tiles::kOn, 64}), 0U) << "there is no local memory at all";
}

/// The plain loop adds in another order. About 30 terms of a few units each round by at most 30
/// times half an ulp of their sum, some 1e-5. A step makes an h-th of it a velocity; divisions for
/// the pushes enlarge it by less than ten.
TEST(Flock, MovesAsThePlainLoopDoes) {
    const std::size_t count = 4000;
    bench::PlainFlock plain;
    plain.rules = scenario::flock_rules(count);
    ParticleColumns columns = flock_of(count, plain.rules);
    plain.agents.resize(count);
    scenario::scatter_flock(
        count, plain.rules, [&](std::size_t i, auto... values) { plain.agents[i] = {values...}; });
    FlockStage stage;
    Team alone;
    stage.step(columns, count, plain.rules, alone);
    plain.step();
    float worst = 0.0F;
    for (std::size_t i = 0; i < count; ++i) {
        worst = std::max(worst, std::abs(columns.column(0)[i] - plain.agents[i].x));
        worst = std::max(worst, std::abs(columns.column(3)[i] - plain.agents[i].vx));
        worst = std::max(worst, std::abs(columns.column(5)[i] - plain.agents[i].vz));
    }
    EXPECT_LT(worst, 1e-4F);
    EXPECT_GT(plain.tested, 30 * count);
}

TEST(Flock, AlignsWhoIsNear) {
    const std::size_t count = 3000;
    auto rules = scenario::flock_rules(count);
    ParticleColumns columns = flock_of(count, rules);
    const auto disorder = [&] {
        double sum = 0.0;
        for (std::size_t i = 0; i + 1 < count; ++i) {
            const double dx = columns.column(3)[i] - columns.column(3)[i + 1];
            sum += dx * dx;
        }
        return sum;
    };
    FlockStage stage;
    Team alone;
    rules.separation = 0.0F;
    rules.cohesion = 0.0F;
    rules.alignment = 4.0F;
    rules.least_speed = 0.0F;
    const double before = disorder();
    for (int step = 0; step < 60; ++step) {
        stage.step(columns, count, rules, alone);
    }
    EXPECT_LT(disorder(), 0.5 * before);
}

}  // namespace
}  // namespace zoned::compute
