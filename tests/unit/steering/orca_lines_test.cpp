#include "server/ai/crowd/orca_lines.h"

#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace zoned::ai::steering {

namespace {

struct Plane {
    double nx, nz, c;
};

struct Velocity {
    double x, z;
};

/// The best velocity by trying all corners, feet on borders and the desired velocity itself. It is
/// exact, and has nothing in common with the incremental programme.
std::optional<Velocity> best_of_all(const std::vector<Plane>& planes, Velocity want, double speed) {
    std::vector<Velocity> tried{want};
    const auto on_border = [&](const Plane& p, double t) {
        tried.push_back({p.c * p.nx + t * p.nz, p.c * p.nz - t * p.nx});
    };
    for (const Plane& p : planes) {
        on_border(p, want.x * p.nz - want.z * p.nx);
        if (std::abs(p.c) <= speed) {
            on_border(p, std::sqrt(speed * speed - p.c * p.c));
            on_border(p, -std::sqrt(speed * speed - p.c * p.c));
        }
        for (const Plane& q : planes) {
            const double slope = q.nx * p.nz - q.nz * p.nx;
            if (std::abs(slope) > 1e-12) {
                on_border(p, (q.c - p.c * (q.nx * p.nx + q.nz * p.nz)) / slope);
            }
        }
    }
    std::optional<Velocity> best;
    const auto off = [&](Velocity v) {
        return std::hypot(v.x - want.x, v.z - want.z);
    };
    for (const Velocity& v : tried) {
        bool in = std::hypot(v.x, v.z) <= speed + 1e-9;
        for (const Plane& p : planes) {
            in = in && p.nx * v.x + p.nz * v.z >= p.c - 1e-9;
        }
        if (in && (!best || off(v) < off(*best))) {
            best = v;
        }
    }
    return best;
}

/// A programme of eight random agents, with the planes of each.
struct RandomProgram {
    OrcaLineSet<24> section;
    std::vector<Plane> planes[kLanes];
    OrcaVelocity want{};
    Lanes speed{};

    RandomProgram(core::Rng& rng, std::size_t most, float lowest, float highest) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const float angle = rng.range(0.0F, 6.2F);
            speed[lane] = rng.range(0.5F, 2.0F);
            const float wanted = speed[lane] * rng.unit();
            want.x[lane] = wanted * std::cos(angle);
            want.z[lane] = wanted * std::sin(angle);
            const auto count = rng.below(static_cast<std::uint32_t>(most) + 1);
            for (std::uint32_t i = 0; i < count; ++i) {
                const float turned = rng.range(0.0F, 6.3F);
                OrcaLine plane{splat(std::cos(turned)),
                               splat(std::sin(turned)),
                               splat(rng.range(lowest, highest))};
                section.add(1U << lane, plane);
                const auto nx = static_cast<double>(plane.nx[0]);
                const auto nz = static_cast<double>(plane.nz[0]);
                const double unit = std::hypot(nx, nz);  // 1 but for a float's rounding
                planes[lane].push_back(
                    {nx / unit, nz / unit, static_cast<double>(plane.c[0]) / unit});
            }
        }
    }

    [[nodiscard]] OrcaProgram program(std::size_t fixed) const {
        OrcaProgram p;
        p.want = want;
        p.most_speed = speed;
        p.append(section);
        p.fixed = fixed < p.rows ? fixed : p.rows;
        return p;
    }

    [[nodiscard]] std::optional<Velocity> exact(std::size_t lane, double slack) const {
        std::vector<Plane> moved = planes[lane];
        for (Plane& p : moved) {
            p.c -= slack;
        }
        return best_of_all(moved,
                           {static_cast<double>(want.x[lane]), static_cast<double>(want.z[lane])},
                           static_cast<double>(speed[lane]));
    }
};

/// Corners of planes that are nearly parallel move by eps / sine; of random ones few are flatter
/// than 1/100, where c and n are off by 1e-7: 1e-4 m/s.
constexpr double kCornerError = 1e-4;

TEST(OrcaLines, ChooseTheNearestVelocityThatAllOfThemAllow) {
    core::Rng rng(1);
    int found = 0;
    int none = 0;
    int doubtful = 0;
    for (int round = 0; round < 2000; ++round) {
        const RandomProgram random(rng, 10, -1.5F, 0.3F);
        const OrcaProgram p = random.program(OrcaProgram::kMostRows);
        const OrcaSolution s = solve(p, Lanes{});
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const auto exact = random.exact(lane, 0.0);
            if (exact.has_value() != (s.failed_at[lane] == static_cast<int>(p.rows))) {
                // Only where a hair more or less decides.
                const bool wider = random.exact(lane, 1e-5).has_value();
                const bool narrower = random.exact(lane, -1e-5).has_value();
                ASSERT_NE(wider, narrower);
                ++doubtful;
            } else if (exact) {
                const double dx = static_cast<double>(s.v.x[lane]) - exact->x;
                const double dz = static_cast<double>(s.v.z[lane]) - exact->z;
                ASSERT_LT(std::hypot(dx, dz), kCornerError) << "round " << round;
                ++found;
            } else {
                ++none;
            }
        }
    }
    EXPECT_GT(found, 8000);
    EXPECT_GT(none, 1000);
    EXPECT_LT(doubtful, 5);
}

TEST(OrcaLines, GiveWayByNoMoreThanIsNeeded) {
    core::Rng rng(2);
    constexpr int kHalved = 6;
    int gave_way = 0;
    for (int round = 0; round < 500; ++round) {
        const RandomProgram random(rng, 10, -1.0F, 0.5F);
        const OrcaProgram p = random.program(0);
        const OrcaSolution s = solve_with_slack(p, 2.0F * random.speed, kHalved);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            ASSERT_EQ(s.failed_at[lane], static_cast<int>(p.rows));
            double slack = 0.0;
            for (const Plane& plane : random.planes[lane]) {
                slack = std::max(slack,
                                 plane.c - plane.nx * static_cast<double>(s.v.x[lane]) -
                                     plane.nz * static_cast<double>(s.v.z[lane]));
            }
            const double grain =
                2.0 * static_cast<double>(random.speed[lane]) / static_cast<double>(1 << kHalved);
            if (slack > 1e-5) {
                ++gave_way;
                // A grain less would not have been enough.
                ASSERT_FALSE(random.exact(lane, slack - 1.01 * grain).has_value());
            }
        }
    }
    EXPECT_GT(gave_way, 500);
}

TEST(OrcaLines, KeepTheStrictestWhereALaneIsFull) {
    OrcaLineSet<4> section;
    for (int i = 0; i < 6; ++i) {
        section.add(0b101U, {splat(1.0F), Lanes{}, splat(static_cast<float>(i % 5) - 3.0F)});
    }
    EXPECT_EQ(section.full(), 0b101U);
    // -3 to 1, then -3 again: of the six -3 is lost twice.
    EXPECT_EQ(section.lost()[2], -3.0F);
    EXPECT_LT(section.lost()[1], -1e6F);
    ASSERT_EQ(section.rows(), 4U);
    std::vector<float> kept;
    for (std::size_t i = 0; i < 4; ++i) {
        kept.push_back(section.row(i).c[2]);
        EXPECT_LT(section.row(i).c[1], 0.0F) << "the lane between has none";
    }
    EXPECT_THAT(kept, testing::UnorderedElementsAre(-2.0F, -1.0F, 0.0F, 1.0F));
}

}  // namespace

}  // namespace zoned::ai::steering
