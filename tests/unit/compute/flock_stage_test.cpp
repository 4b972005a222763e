#include "server/compute/stages/flock_stage.h"

#include "server/compute/worker_pool.h"
#include "tests/bench/plain_flock.h"
#include "tests/scenario/flock.h"
#include "tests/unit/compute/device_fixture.h"

#include <algorithm>
#include <cmath>
#include <cstring>

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

/// The plain loop adds in another order: about 30 terms of a few units each round by at most 30
/// times half an ulp of their sum, some 1e-5, and a step makes an h-th of it a velocity; divisions
/// for the pushes enlarge it by less than ten.
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
