#include "server/compute/stages/particle_stage.h"

#include "server/compute/worker_pool.h"
#include "tests/unit/compute/device_fixture.h"
#include "shared/core/rng.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace zoned::compute {
namespace {

using kernels::ParticleWorld;

/// Scenes of every kind: with and without air, gusts, and all obstacles.
struct World {
    ParticleScene scene;
    std::vector<float> gusts;
    std::vector<float> heights;

    World(int air, bool collides) {
        ParticleWorld& w = scene.world;
        w.h = 1.0F / 60.0F;
        w.gy = -9.81F;
        w.restitution = 0.4F;
        w.friction = 0.3F;
        w.radius = 0.02F;
        core::Rng rng(11);
        if (air != kernels::ZK_AIR_NONE) {
            w.linear_drag = 0.4F;
            w.quadratic_drag = 0.02F;
            w.wind_x = 3.0F;
            w.wind_z = -1.0F;
        }
        if (air == kernels::ZK_AIR_GUSTS) {
            w.gust_cells_per_m = 0.21F;
            w.gust_x = -3.7F;
            for (int i = 0; i < 3 * kernels::ZK_GUST_CORNERS; ++i) {
                gusts.push_back(rng.range(-4.0F, 4.0F));
            }
            scene.gusts = gusts;
        }
        if (collides) {
            w.planes = 2;
            w.plane[0] = {0.0F, 1.0F, 0.0F, 0.0F};
            w.plane[1] = {0.6F, 0.8F, 0.0F, -12.0F};
            w.spheres = 2;
            w.sphere[0] = {2.0F, 1.0F, 0.0F, 1.5F};
            w.sphere[1] = {-4.0F, 2.0F, 3.0F, 0.7F};
            w.field = {9, 7, -8.0F, 0.5F, -6.0F, 2.0F, 2.0F, -10.0F};
            for (int i = 0; i < 9 * 7; ++i) {
                heights.push_back(rng.range(-1.0F, 1.5F));
            }
            scene.heights = heights;
        }
    }
};

ParticleColumns scattered(std::size_t count) {
    ParticleColumns columns;
    columns.reserve(count);
    core::Rng rng(5);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
            columns.column(c)[i] =
                c == ParticleColumns::kY ? rng.range(0.0F, 6.0F) : rng.range(-10.0F, 10.0F);
        }
    }
    return columns;
}

std::size_t differing_bits(const ParticleColumns& a, const ParticleColumns& b, std::size_t count) {
    std::size_t differing = 0;
    for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
        for (std::size_t i = 0; i < count; ++i) {
            differing += std::memcmp(a.column(c) + i, b.column(c) + i, sizeof(float)) != 0 ? 1 : 0;
        }
    }
    return differing;
}

constexpr std::size_t kCount = 10'007;  // no multiple of anything

class ParticleKernel : public DeviceTest, public ::testing::WithParamInterface<int> {};

TEST_F(DeviceTest, GivesTheSameBitsAsTheLanesInEveryKindOfScene) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    Team alone;
    for (int air = 0; air <= kernels::ZK_AIR_GUSTS; ++air) {
        for (const bool collides : {false, true}) {
            const World world(air, collides);
            ParticleColumns host = scattered(kCount);
            ParticleColumns other = scattered(kCount);
            ParticleStage stage(device.get());
            for (int step = 0; step < 60; ++step) {
                step_particles(host, kCount, world.scene, alone);
                const StageRun run = stage.step(other, kCount, world.scene, alone);
                ASSERT_TRUE(run.on_device) << run.fault;
            }
            EXPECT_EQ(differing_bits(host, other, kCount), 0U) << "air " << air << " " << collides;
        }
    }
}

/// A speed beyond floats makes a place that is no number: it must not become an index into the
/// field, nor touch others.
TEST_F(DeviceTest, AParticleThatIsNoNumberHarmsNobody) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    Team alone;
    const World world(kernels::ZK_AIR_GUSTS, true);
    ParticleColumns good = scattered(kCount);
    ParticleColumns host = scattered(kCount);
    ParticleColumns other = scattered(kCount);
    constexpr std::size_t kBad = 1234;
    for (ParticleColumns* columns : {&host, &other}) {
        columns->column(ParticleColumns::kX)[kBad] = std::numeric_limits<float>::quiet_NaN();
        columns->column(ParticleColumns::kZ)[kBad + 1] = std::numeric_limits<float>::infinity();
        columns->column(ParticleColumns::kVz)[kBad + 2] = 3e38F;
    }
    ParticleStage stage(device.get());
    for (int step = 0; step < 20; ++step) {
        step_particles(good, kCount, world.scene, alone);
        step_particles(host, kCount, world.scene, alone);
        ASSERT_TRUE(stage.step(other, kCount, world.scene, alone).on_device);
    }
    EXPECT_FALSE(std::isfinite(host.column(ParticleColumns::kX)[kBad]));
    for (std::size_t i = 0; i < kCount; ++i) {
        for (std::size_t c = 0; c < ParticleColumns::kColumns && (i < kBad || i > kBad + 2); ++c) {
            ASSERT_EQ(std::memcmp(host.column(c) + i, good.column(c) + i, 4), 0) << i;
            ASSERT_EQ(std::memcmp(other.column(c) + i, good.column(c) + i, 4), 0) << i;
        }
    }
}

}  // namespace
}  // namespace zoned::compute
