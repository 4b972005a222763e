#include "server/compute/stages/constraint_stage.h"

#include "server/compute/worker_pool.h"
#include "tests/unit/compute/device_fixture.h"

#include <cmath>
#include <cstring>
#include <set>

namespace zoned::compute {
namespace {

constexpr int kSide = 33;

/// A cloth of links along, across and diagonal, stretched by a tenth.
std::vector<kernels::DistanceLink> cloth_links(float compliance) {
    std::vector<kernels::DistanceLink> links;
    for (int k = 0; k < kSide; ++k) {
        for (int i = 0; i < kSide; ++i) {
            const int at = k * kSide + i;
            if (i + 1 < kSide) {
                links.push_back({at, at + 1, 1.0F, compliance});
            }
            if (k + 1 < kSide) {
                links.push_back({at, at + kSide, 1.0F, compliance});
            }
            if (i + 1 < kSide && k + 1 < kSide) {
                links.push_back({at, at + kSide + 1, std::sqrt(2.0F), compliance});
                links.push_back({at + 1, at + kSide, std::sqrt(2.0F), compliance});
            }
        }
    }
    return links;
}

ParticleColumns stretched_cloth(float bumps = 0.05F, float stretch = 1.1F) {
    ParticleColumns nodes;
    nodes.reserve(kSide * kSide);
    for (std::size_t i = 0; i < kSide * kSide; ++i) {
        nodes.column(0)[i] = stretch * static_cast<float>(i % kSide);
        nodes.column(1)[i] = bumps * static_cast<float>(i % 7);
        nodes.column(2)[i] = stretch * static_cast<float>(i / kSide);
        nodes.column(kInverseMass)[i] = i == 0 ? 0.0F : 2.0F;
    }
    return nodes;
}

bool same_positions(const ParticleColumns& a, const ParticleColumns& b) {
    for (std::size_t c = 0; c < 3; ++c) {
        if (std::memcmp(a.column(c), b.column(c), kSide * kSide * sizeof(float)) != 0) {
            return false;
        }
    }
    return true;
}

using ConstraintTest = DeviceTest;

TEST_F(ConstraintTest, GiveTheSameBitsOnThreadsOnADeviceAndAfterItDied) {
    const auto links = *ColouredLinks::make(cloth_links(1e-4F), kSide * kSide);
    Team alone;
    ParticleColumns one = stretched_cloth();
    const ParticleColumns start = stretched_cloth();
    ConstraintStage cpu;
    cpu.solve(one, kSide * kSide, links, 0.01F, 5, alone);
    EXPECT_FALSE(same_positions(one, start));

    WorkerPool pool(3);
    Team team;
    team.join_pool(pool);
    const Team::Shift shift(team);
    ParticleColumns three = stretched_cloth();
    cpu.solve(three, kSide * kSide, links, 0.01F, 5, team);
    EXPECT_TRUE(same_positions(one, three));

    for (const int launches : {-1, 7}) {
        DeviceFaults faults;
        faults.launches = launches;
        DeviceSettings settings;
        settings.testing = &faults;
        const auto device = open(settings);
        ASSERT_NE(device, nullptr);
        ConstraintStage stage(device.get());
        ParticleColumns other = stretched_cloth();
        const StageRun run = stage.solve(other, kSide * kSide, links, 0.01F, 5, alone);
        EXPECT_EQ(run.on_device, launches < 0) << run.fault;
        EXPECT_TRUE(same_positions(one, other)) << launches;
        if (launches < 0) {
            other = stretched_cloth();
            stage.solve(other, kSide * kSide, links, 0.01F, 5, alone);
            EXPECT_TRUE(same_positions(one, other)) << "lambdas of the step before";
        }
    }
}

TEST_F(ConstraintTest, AreSolvedOnceWhicheverCallFails) {
    const auto links = *ColouredLinks::make(cloth_links(1e-4F), kSide * kSide);
    Team alone;
    ParticleColumns expected = stretched_cloth();
    ConstraintStage cpu;
    cpu.solve(expected, kSide * kSide, links, 0.01F, 1, alone);
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        const int faults = fail_at_every_call(mode, [&](Device& device) {
            ConstraintStage stage(&device);
            ParticleColumns nodes = stretched_cloth();
            const bool on_device =
                stage.solve(nodes, kSide * kSide, links, 0.01F, 1, alone).on_device;
            EXPECT_TRUE(same_positions(expected, nodes));
            return on_device;
        });
        EXPECT_GT(faults, static_cast<int>(3 * links.colours())) << "two arguments and a launch";
    }
}

TEST(Constraints, PullLinksToTheirRestLengths) {
    const auto made = ColouredLinks::make(cloth_links(0.0F), kSide * kSide);
    ASSERT_TRUE(made.ok());
    ParticleColumns nodes = stretched_cloth(0.0F, 1.02F);  // flat: it can neither wrinkle nor fold
    const auto worst = [&] {
        double most = 0.0;
        for (const auto& link : made->links()) {
            double d2 = 0.0;
            for (std::size_t c = 0; c < 3; ++c) {
                const double d =
                    static_cast<double>(nodes.column(c)[link.a] - nodes.column(c)[link.b]);
                d2 += d * d;
            }
            most = std::max(most, std::abs(std::sqrt(d2) / static_cast<double>(link.rest) - 1.0));
        }
        return most;
    };
    EXPECT_GT(worst(), 0.019);
    ConstraintStage stage;
    Team alone;
    // The slowest mode of 33 nodes loses two thirds in 2,000 passes.
    stage.solve(nodes, kSide * kSide, *made, 0.01F, 14000, alone);
    EXPECT_LT(worst(), 0.002);
    EXPECT_EQ(nodes.column(0)[0], 0.0F) << "a held node moved";
}

/// Two masses on a spring: one solve of a single link is exact, C = -softness lambda afterwards.
TEST(Constraints, LeaveAStretchInProportionToCompliance) {
    const kernels::DistanceLink link{0, 1, 1.0F, 2e-3F};
    const auto links = *ColouredLinks::make(std::span(&link, 1), 2);
    ParticleColumns nodes;
    nodes.reserve(2);
    nodes.column(0)[1] = 2.0F;
    nodes.column(kInverseMass)[0] = nodes.column(kInverseMass)[1] = 1.0F;
    ConstraintStage stage;
    Team alone;
    stage.solve(nodes, 2, links, 0.1F, 1, alone);
    // softness 0.2: of the stretch of 1 m, 0.2 / (2 + 0.2) stays.
    EXPECT_NEAR(nodes.column(0)[1] - nodes.column(0)[0], 1.0F + 0.2F / 2.2F, 1e-6F);
}

TEST(ColouredLinks, ShareNoNodeWithinAColour) {
    const auto links = *ColouredLinks::make(cloth_links(0.0F), kSide * kSide);
    EXPECT_EQ(links.links().size(), cloth_links(0.0F).size());
    EXPECT_LE(links.colours(), 15U);  // eight links at a node: 2 x 8 - 1
    for (std::size_t c = 0; c < links.colours(); ++c) {
        std::set<int> seen;
        for (std::size_t i = links.colour_begin()[c]; i < links.colour_begin()[c + 1]; ++i) {
            EXPECT_TRUE(seen.insert(links.links()[i].a).second);
            EXPECT_TRUE(seen.insert(links.links()[i].b).second);
        }
    }
}

TEST(ColouredLinks, RefuseBadLinksByNumber) {
    const auto refused = [](kernels::DistanceLink link) {
        const std::vector<kernels::DistanceLink> links{{0, 1, 1.0F, 0.0F}, link};
        const auto made = ColouredLinks::make(links, 3);
        return made.ok() ? std::string() : made.error();
    };
    EXPECT_EQ(refused({1, 2, 1.0F, 0.0F}), "");
    EXPECT_EQ(refused({1, 3, 1.0F, 0.0F}), "link 1: a node that is not there");
    EXPECT_EQ(refused({1, 1, 1.0F, 0.0F}), "link 1: joins a node to itself");
    EXPECT_EQ(refused({1, 2, 0.0F, 0.0F}), "link 1: rest length must be above 0");
    EXPECT_EQ(refused({1, 2, 1.0F, -1.0F}), "link 1: compliance must be finite and not below 0");
}

}  // namespace
}  // namespace zoned::compute
