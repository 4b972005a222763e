// Viewers that look far: a cone about the direction of their view, beside the round nimbus.
#include "server/interest/matcher.h"
#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace zoned::interest {
namespace {

constexpr std::uint8_t kZoomed = 5;

world::TypeTable types_with_cones(bool cones) {
    world::TypeTable types(2);
    types[0].aura_m.fill(90.0F);
    types[0].nimbus_m.fill(25.0F);
    types[1].aura_m.fill(140.0F);
    types[1].nimbus_m = {30, 10, 30, 30, 30, 0, 30, 30};
    if (cones) {
        types[0].nimbus_cone[kZoomed] = {120.0F, 0.2F};
        types[0].nimbus_cone[6] = {60.0F, 2.0F};  // wider than half of all round
        types[1].nimbus_cone[kZoomed] = {100.0F, 0.5F};
    }
    return types;
}

std::uint16_t yaw_of(double radians) {
    return static_cast<std::uint16_t>(
        static_cast<std::int32_t>(std::lround(radians * 32768.0 / std::numbers::pi)));
}

TEST(ViewCone, IsTheSectorThatLengthAndAngleSay) {
    core::Rng rng(3);
    int inside = 0;
    for (int i = 0; i < 200000; ++i) {
        const world::Cone cone{100.0F, rng.range(0.05F, 3.1F)};
        const auto yaw = static_cast<std::uint16_t>(rng.next());
        const float dx = rng.range(-130, 130);
        const float dz = rng.range(-130, 130);
        // Yaw 0 looks along +z and turns about +y: the direction of (x, z) is atan2(x, z).
        const double turn = static_cast<std::int16_t>(yaw) * std::numbers::pi / 32768.0;
        const double off = std::abs(
            std::remainder(std::atan2(double(dx), double(dz)) - turn, 2.0 * std::numbers::pi));
        const double distance = std::hypot(double(dx), double(dz));
        // Floats: a rounding of the edge decides differently within 1e-3 rad or 1e-4 m of it (the
        // cosine is flat where the half angle is small or nearly half a turn).
        const double half = static_cast<double>(cone.half_angle_rad);
        if (std::abs(off - half) < 1e-3 || std::abs(distance - 100.0) < 1e-4) {
            continue;
        }
        const bool expected = distance < 100.0 && off < half;
        inside += expected ? 1 : 0;
        EXPECT_EQ(hears(dx, dz, 0.0F, view_cone(cone, yaw, 0.1F), 500.0F, false, 0.1F), expected)
            << distance << " m, " << off << " of " << half;
    }
    EXPECT_GT(inside, 20000);
}

TEST(ViewCone, ReachesNoFartherThanTheAuraAndLeavesTheNimbusRound) {
    const ViewCone cone = view_cone({100.0F, 0.1F}, yaw_of(0.0), 0.1F);
    EXPECT_TRUE(hears(0, 60, 20, cone, 70, false, 0.1F));
    EXPECT_FALSE(hears(0, 71, 20, cone, 70, false, 0.1F));
    EXPECT_TRUE(hears(0, 71, 20, cone, 70, true, 0.1F));
    EXPECT_TRUE(hears(0, -19, 20, cone, 70, false, 0.1F)) << "behind, but near";
    EXPECT_FALSE(hears(0, -30, 20, cone, 70, false, 0.1F));
    EXPECT_FALSE(hears(20, 60, 20, cone, 70, false, 0.1F)) << "beside it";
    EXPECT_FALSE(hears(0, 60, 20, ViewCone{}, 70, false, 0.1F)) << "not zoomed";
    // A known entity stays known within a tenth more of the angle.
    EXPECT_FALSE(hears(6.3F, 60, 20, cone, 70, false, 0.1F));
    EXPECT_TRUE(hears(6.3F, 60, 20, cone, 70, true, 0.1F));
}

using Memory = std::map<EntityId, std::uint8_t>;

/// The rule applied to all pairs, with the entities known a tick ago.
Memory all_pairs(const world::Entities& e,
                 const world::TypeTable& types,
                 const world::Viewer& viewer,
                 const InterestSettings& settings,
                 const Memory& before) {
    Memory now;
    const world::Row own = e.find(viewer.avatar);
    for (world::Row row = 0; own != world::kNoRow && row < e.size(); ++row) {
        if (row == own || e.has(row, world::kHidden)) {
            continue;
        }
        const auto it = before.find(e.id[row]);
        const bool known = it != before.end();
        const float dx = e.position[row].x() - e.position[own].x();
        const float dz = e.position[row].z() - e.position[own].z();
        if (hears(dx,
                  dz,
                  types[e.type[own]].nimbus_m[e.stance[own]],
                  view_cone(e, types, own, settings.hysteresis),
                  types[e.type[row]].aura_m[e.stance[row]],
                  known,
                  settings.hysteresis)) {
            now[e.id[row]] =
                lod_at(std::sqrt(dx * dx + dz * dz), settings, known ? it->second : -1);
        }
    }
    return now;
}

class LookingRound {
  public:
    LookingRound(std::uint64_t seed, int count) : rng(seed) {
        for (int i = 0; i < count; ++i) {
            const world::Row row = entities.add(EntityId(static_cast<std::uint32_t>(i + 1)),
                                                static_cast<TypeIndex>(rng.below(2)));
            entities.position[row] = Vec3(rng.range(-200, 200), 0, rng.range(-200, 200));
            entities.velocity[row] = Vec3(rng.range(-6, 6), 0, rng.range(-6, 6));
        }
        for (std::uint32_t v = 0; v < 8; ++v) {
            viewers.push_back({ClientId(v + 1), EntityId(3 * v + 1)});
        }
    }

    /// Some move, some turn, some zoom in or out.
    void change(std::uint32_t movers) {
        for (std::uint32_t i = 0; i < movers; ++i) {
            const world::Row row = rng.below(static_cast<std::uint32_t>(entities.size()));
            entities.position[row] += entities.velocity[row] * 0.1F;
        }
        for (const world::Viewer& viewer : viewers) {
            const world::Row row = entities.find(viewer.avatar);
            if (rng.below(3) == 0) {
                entities.yaw[row] =
                    static_cast<std::uint16_t>(entities.yaw[row] + rng.below(4000) - 2000);
            }
            if (rng.below(40) == 0) {
                entities.yaw[row] = static_cast<std::uint16_t>(rng.next());
            }
            if (rng.below(25) == 0) {
                entities.stance[row] = static_cast<std::uint8_t>(4 + rng.below(3));
            }
        }
        const world::Row row = rng.below(static_cast<std::uint32_t>(entities.size()));
        entities.set(row, world::kHidden, rng.below(2) == 0);
    }

    core::Rng rng;
    world::Entities entities;
    std::vector<world::Viewer> viewers;
};

TEST(MatcherWithCones, EqualsAllPairsWithMemoryWhileViewersTurnZoomAndWalk) {
    const world::TypeTable types = types_with_cones(true);
    InterestSettings settings;
    settings.lod_radius_m = {30.0F, 70.0F};
    std::size_t by_cone = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        LookingRound w(seed, 400);
        Matcher matcher;
        world::Visibility out;
        std::vector<Memory> known(w.viewers.size());
        for (int tick = 0; tick < 600 && !testing::Test::HasFailure(); ++tick) {
            w.change(seed % 2 == 0 ? 15 : 300);
            matcher.step(w.entities, types, w.viewers, settings, out);
            for (std::size_t i = 0; i < w.viewers.size(); ++i) {
                const Memory before = known[i];
                known[i] = all_pairs(w.entities, types, w.viewers[i], settings, before);
                Memory got;
                for (const world::Visible& v : out[i].visible) {
                    got[v.entity] = v.lod;
                }
                EXPECT_EQ(got, known[i]) << "seed " << seed << " tick " << tick << " viewer " << i;
                EXPECT_TRUE(out[i].changed || before == known[i]);
                std::vector<world::Row> inner, outer;
                brute_force(w.entities, types, w.viewers[i], settings, inner, outer);
                for (const world::Row row : inner) {
                    EXPECT_TRUE(got.contains(w.entities.id[row]));
                }
                EXPECT_LE(got.size(), outer.size());
                const world::Row own = w.entities.find(w.viewers[i].avatar);
                for (const auto& [entity, lod] : got) {
                    const Vec3 d =
                        w.entities.position[w.entities.find(entity)] - w.entities.position[own];
                    by_cone += std::hypot(d.x(), d.z()) > 60.0F ? 1 : 0;
                }
            }
        }
    }
    EXPECT_GT(by_cone, 1000U);
}

TEST(MatcherWithCones, SaysNoDifferenceWhereThereIsNone) {
    const world::TypeTable types = types_with_cones(true);
    LookingRound w(9, 300);
    for (const world::Viewer& viewer : w.viewers) {
        w.entities.stance[w.entities.find(viewer.avatar)] = kZoomed;
    }
    Matcher matcher;
    world::Visibility out;
    for (int tick = 0; tick < 3; ++tick) {
        matcher.step(w.entities, types, w.viewers, {}, out);
    }
    const std::uint64_t before = allocation_count();
    for (int tick = 0; tick < 5; ++tick) {
        const InterestReport report = matcher.step(w.entities, types, w.viewers, {}, out);
        EXPECT_EQ(report.entered + report.left, 0U);
        EXPECT_EQ(report.refreshed, w.viewers.size());
        for (const world::VisibleSet& set : out) {
            EXPECT_FALSE(set.changed);
        }
    }
    EXPECT_EQ(allocation_count(), before);
}

TEST(MatcherWithCones, RefreshesNobodyWhereNoBehaviourHasOne) {
    const world::TypeTable types = types_with_cones(false);
    LookingRound w(9, 300);
    for (const world::Viewer& viewer : w.viewers) {
        w.entities.stance[w.entities.find(viewer.avatar)] = kZoomed;
    }
    Matcher matcher;
    world::Visibility out;
    matcher.step(w.entities, types, w.viewers, {}, out);
    for (int tick = 0; tick < 5; ++tick) {
        for (const world::Viewer& viewer : w.viewers) {
            w.entities.yaw[w.entities.find(viewer.avatar)] += 3000;
        }
        EXPECT_EQ(matcher.step(w.entities, types, w.viewers, {}, out).refreshed, 0U);
    }
}

}  // namespace
}  // namespace zoned::interest
