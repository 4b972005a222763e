#include "server/interest/matcher.h"

#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

namespace zoned::interest {
namespace {

world::TypeTable three_types() {
    world::TypeTable types(3);
    types[0].aura_m = {60, 30, 80, 100};
    types[0].nimbus_m = {70, 40, 90, 120};
    types[1].aura_m = {20, 10, 25, 25};
    types[2].aura_m = {150, 150, 0, 150};
    types[2].nimbus_m = {50, 50, 50, 50};
    return types;
}

InterestSettings two_lods() {
    InterestSettings settings;
    settings.lod_radius_m = {30.0F};
    return settings;
}

/// The entities that one viewer should know, kept by the definition alone: all pairs, a map as
/// memory.
class Model {
  public:
    using Known = std::map<EntityId, std::uint8_t>;

    void step(const world::Entities& entities,
              const world::TypeTable& types,
              const world::Viewer& viewer,
              const InterestSettings& settings) {
        const Known before = known_;
        known_.clear();
        const world::Row own = entities.find(viewer.avatar);
        for (world::Row row = 0; own != world::kNoRow && row < entities.size(); ++row) {
            if (row == own || entities.has(row, world::kHidden)) {
                continue;
            }
            const auto it = before.find(entities.id[row]);
            const bool was_known = it != before.end();
            const float nimbus = types[entities.type[own]].nimbus_m[entities.stance[own]];
            const float aura = types[entities.type[row]].aura_m[entities.stance[row]];
            const float dx = entities.position[row].x() - entities.position[own].x();
            const float dz = entities.position[row].z() - entities.position[own].z();
            const float d2 = dx * dx + dz * dz;
            if (hears(d2, nimbus, aura, was_known, settings.hysteresis)) {
                known_[entities.id[row]] =
                    lod_at(std::sqrt(d2), settings, was_known ? it->second : -1);
            }
        }
    }

    Known known_;
};

/// A small world whose moved_set, places, types and stances change at random.
struct RandomWorld {
    explicit RandomWorld(std::uint64_t seed, float extent_m) : rng(seed), extent(extent_m) {}

    Vec3 anywhere() {
        return {rng.range(-extent, extent), rng.range(0, 9), rng.range(-extent, extent)};
    }

    void spawn() {
        const world::Row row =
            entities.add(EntityId(next_id), static_cast<TypeIndex>(rng.below(3)));
        next_id += 1 + rng.below(3);
        entities.position[row] = anywhere();
        entities.velocity[row] = Vec3(rng.range(-9, 9), 0, rng.range(-9, 9));
        entities.stance[row] = static_cast<std::uint8_t>(rng.below(4));
    }

    void change() {
        for (world::Row row = 0; row < entities.size(); ++row) {
            entities.position[row] += entities.velocity[row] * 0.1F;
        }
        if (entities.size() < 60 || rng.below(3) == 0) {
            spawn();
        }
        const auto pick = [&] {
            return rng.below(static_cast<std::uint32_t>(entities.size()));
        };
        if (entities.size() > 50 && rng.below(3) == 0) {
            entities.remove(pick());
        }
        entities.position[pick()] = anywhere();
        entities.set_type(pick(), static_cast<TypeIndex>(rng.below(3)));
        entities.stance[pick()] = static_cast<std::uint8_t>(rng.below(4));
        const world::Row row = pick();
        entities.set(row, world::kHidden, rng.below(3) == 0);
    }

    /// Most stay where they are; steps, jumps, entries and exits, at random.
    void change_a_little() {
        const auto pick = [&] {
            return rng.below(static_cast<std::uint32_t>(entities.size()));
        };
        for (std::uint32_t i = 0; i < rng.below(12); ++i) {
            const world::Row row = pick();
            entities.position[row] += Vec3(rng.range(-3, 3), 0, rng.range(-3, 3));
        }
        if (rng.below(4) == 0 || entities.size() < 180) {
            spawn();
        }
        if (entities.size() > 200 && rng.below(2) == 0) {
            entities.remove(pick());
        }
        if (rng.below(3) == 0) {
            entities.position[pick()] = anywhere();
        }
        if (rng.below(3) == 0) {
            entities.stance[pick()] = static_cast<std::uint8_t>(rng.below(4));
        }
        if (rng.below(5) == 0) {
            entities.set_type(pick(), static_cast<TypeIndex>(rng.below(3)));
        }
        if (rng.below(3) == 0) {
            entities.set(pick(), world::kHidden, rng.below(2) == 0);
        }
        if (rng.below(40) == 0) {
            entities.position[pick()].x() = std::numeric_limits<float>::quiet_NaN();
        }
        if (rng.below(60) == 0) {
            entities.position[pick()] = anywhere() * 40.0F;  // beyond the extent of any grid
        }
        if (rng.below(50) == 0) {
            for (Vec3& p : entities.position) {
                p += Vec3(rng.range(-2, 2), 0, rng.range(-2, 2));
            }
        }
    }

    void choose_viewers(std::vector<world::Viewer>& viewers) {
        viewers.clear();
        for (std::uint32_t client = 1; client <= 12; ++client) {
            // A viewer comes and goes; avatars are any entities, some of them not here.
            if (core::mix(client * 7919 + era) % 4 != 0) {
                viewers.push_back({ClientId(client), EntityId(client * 3)});
            }
        }
    }

    core::Rng rng;
    float extent;
    world::Entities entities;
    std::uint32_t next_id = 1;
    std::uint32_t era = 0;
};

void expect_difference(const world::VisibleSet& set,
                       const Model::Known& before,
                       const Model::Known& now) {
    Model::Known entered, changed;
    std::vector<EntityId> left;
    for (const auto& [entity, lod] : now) {
        const auto it = before.find(entity);
        if (it == before.end()) {
            entered[entity] = lod;
        } else if (it->second != lod) {
            changed[entity] = lod;
        }
    }
    for (const auto& [entity, lod] : before) {
        if (!now.contains(entity)) {
            left.push_back(entity);
        }
    }
    const auto as_map = [](const std::vector<world::Visible>& list) {
        Model::Known map;
        for (const world::Visible& v : list) {
            map[v.entity] = v.lod;
        }
        EXPECT_EQ(map.size(), list.size());
        return map;
    };
    EXPECT_EQ(as_map(set.entered), entered);
    EXPECT_EQ(as_map(set.lod_changed), changed);
    EXPECT_EQ(set.left, left);
    EXPECT_EQ(as_map(set.visible), now);
    EXPECT_TRUE(std::is_sorted(
        set.visible.begin(),
        set.visible.end(),
        [](const world::Visible& a, const world::Visible& b) { return a.entity < b.entity; }));
}

void expect_between_brute_force(const RandomWorld& w,
                                const world::TypeTable& types,
                                const world::Viewer& viewer,
                                const InterestSettings& settings,
                                const Model::Known& known) {
    std::vector<world::Row> inner, outer;
    brute_force(w.entities, types, viewer, settings, inner, outer);
    for (const world::Row row : inner) {
        EXPECT_TRUE(known.contains(w.entities.id[row]));
    }
    for (const auto& [entity, lod] : known) {
        EXPECT_EQ(std::count_if(outer.begin(),
                                outer.end(),
                                [&, id = entity](world::Row r) { return w.entities.id[r] == id; }),
                  1);
    }
}

/// Returns how many ticks were broadcasts.
int run_random_world(std::uint64_t seed, float extent, int ticks) {
    const world::TypeTable types = three_types();
    const InterestSettings settings = two_lods();
    RandomWorld w(seed, extent);
    Matcher matcher;
    world::Visibility visibility;
    std::map<ClientId, Model> models;
    std::vector<world::Viewer> viewers;
    int broadcasts = 0;
    for (int tick = 0; tick < ticks && !testing::Test::HasFailure(); ++tick) {
        w.change();
        w.era = static_cast<std::uint32_t>(tick / 40);
        w.choose_viewers(viewers);
        const InterestReport report =
            matcher.step(w.entities, types, viewers, settings, visibility);
        broadcasts += report.broadcast ? 1 : 0;
        std::erase_if(models, [&](const auto& entry) {
            return std::none_of(viewers.begin(), viewers.end(), [&](const world::Viewer& v) {
                return v.client == entry.first;
            });
        });
        EXPECT_EQ(visibility.size(), viewers.size());
        std::uint32_t pairs = 0;
        for (std::size_t i = 0; i < viewers.size(); ++i) {
            EXPECT_EQ(visibility[i].client, viewers[i].client);
            Model& model = models[viewers[i].client];
            const Model::Known before = model.known_;
            model.step(w.entities, types, viewers[i], settings);
            expect_difference(visibility[i], before, model.known_);
            expect_between_brute_force(w, types, viewers[i], settings, model.known_);
            pairs += static_cast<std::uint32_t>(model.known_.size());
        }
        EXPECT_EQ(report.visible_pairs, pairs);
    }
    return broadcasts;
}

TEST(Matcher, EqualsBruteForceWithMemoryInEveryTickOfARandomWorld) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        // The first few ticks hold so few entities that they may all overlap.
        EXPECT_LT(run_random_world(seed, 150.0F, 600), 10);
    }
}

/// Follows a world of few changes; `tamper` may touch the sets between ticks. Returns how many sets
/// were made anew.
template <class Tamper>
std::uint64_t follow_quiet_world(std::uint64_t seed, float extent, int ticks, Tamper&& tamper) {
    const world::TypeTable types = three_types();
    const InterestSettings settings = two_lods();
    RandomWorld w(seed, extent);
    for (int i = 0; i < 150; ++i) {
        w.spawn();
    }
    Matcher matcher;
    world::Visibility visibility;
    std::map<ClientId, Model> models;
    std::vector<world::Viewer> viewers;
    std::uint64_t refreshed = 0;
    for (int tick = 0; tick < ticks && !testing::Test::HasFailure(); ++tick) {
        w.change_a_little();
        w.era = static_cast<std::uint32_t>(tick / 100);
        w.choose_viewers(viewers);
        tamper(tick, visibility, models);
        std::erase_if(models, [&](const auto& entry) {
            return std::none_of(viewers.begin(), viewers.end(), [&](const world::Viewer& v) {
                return v.client == entry.first;
            });
        });
        const InterestReport report =
            matcher.step(w.entities, types, viewers, settings, visibility);
        refreshed += report.refreshed;
        EXPECT_EQ(visibility.size(), viewers.size());
        std::uint32_t pairs = 0;
        for (std::size_t i = 0; i < viewers.size(); ++i) {
            Model& model = models[viewers[i].client];
            const Model::Known before = model.known_;
            model.step(w.entities, types, viewers[i], settings);
            expect_difference(visibility[i], before, model.known_);
            EXPECT_TRUE(visibility[i].changed || before == model.known_);
            pairs += static_cast<std::uint32_t>(model.known_.size());
        }
        EXPECT_EQ(report.visible_pairs, pairs);
        EXPECT_FALSE(testing::Test::HasFailure()) << "seed " << seed << " tick " << tick;
    }
    return refreshed;
}

TEST(Matcher, EqualsBruteForceWithMemoryWhereOnlyAFewMove) {
    const auto leave_alone = [](auto&&...) {
    };
    constexpr int kTicks = 2500;
    for (std::uint64_t seed = 11; seed <= 14; ++seed) {
        const float extent = seed % 2 == 0 ? 150.0F : 500.0F;
        // About ten viewers: most sets are not made anew.
        EXPECT_LT(follow_quiet_world(seed, extent, kTicks, leave_alone), kTicks * 2);
    }
}

/// All walk (few pairs are near a step) or run (more are than the grid has blocks), with one radius
/// and with several.
TEST(Matcher, EqualsBruteForceWithMemoryWhereAllWalkOrRun) {
    const InterestSettings settings = two_lods();
    for (const bool alike : {true, false}) {
        world::TypeTable types = three_types();
        if (alike) {
            types[0].aura_m.fill(40.0F);
            types[0].nimbus_m.fill(40.0F);
        }
        for (const float speed : {0.01F, 0.2F, 2.0F, 7.0F}) {
            RandomWorld w(41, 150.0F);
            for (int i = 0; i < 400; ++i) {
                w.spawn();
            }
            std::vector<world::Viewer> viewers;
            for (world::Row row = 0; row < w.entities.size(); ++row) {
                w.entities.set_type(row, alike ? TypeIndex{0} : w.entities.type[row]);
                if (row % 4 == 0) {
                    const EntityId id = w.entities.id[row];
                    viewers.push_back({ClientId(id.value), id});
                }
            }
            Matcher matcher;
            world::Visibility visibility;
            std::vector<Model> models(viewers.size());
            std::size_t differences = 0;
            for (int tick = 0; tick < 100; ++tick) {
                for (world::Row row = 0; row < w.entities.size(); ++row) {
                    const Vec3 turn(w.rng.range(-1, 1), 0, w.rng.range(-1, 1));
                    const Vec3 ahead = w.entities.velocity[row] + turn;
                    w.entities.position[row] += ahead.normalized() * speed;
                }
                matcher.step(w.entities, types, viewers, settings, visibility);
                for (std::size_t i = 0; i < viewers.size(); ++i) {
                    const Model::Known before = models[i].known_;
                    models[i].step(w.entities, types, viewers[i], settings);
                    expect_difference(visibility[i], before, models[i].known_);
                    differences += tick > 0 ? visibility[i].entered.size() : 0;
                }
                ASSERT_FALSE(testing::Test::HasFailure()) << "speed " << speed << " tick " << tick;
            }
            EXPECT_GT(differences, 10U) << "speed " << speed;
        }
    }
}

TEST(Matcher, GoesOnFromASetThatAnotherWroteWhenItIsToldSo) {
    // A client comes back from another zone: the entities that it knows then count as known.
    const auto rewrite = [](int tick, world::Visibility& sets, auto& models) {
        if (tick % 7 == 0 && !sets.empty()) {
            world::VisibleSet& set = sets[static_cast<std::size_t>(tick) % sets.size()];
            const ClientId client = set.client;
            set = world::VisibleSet();
            set.client = client;
            for (std::uint32_t id = 1; id < 90; id += 4) {
                set.visible.push_back({EntityId(id), 0});
            }
            auto& known = models[client].known_;
            known.clear();
            for (const world::Visible& v : set.visible) {
                known[v.entity] = v.lod;
            }
        }
    };
    follow_quiet_world(31, 150.0F, 800, rewrite);
}

TEST(Matcher, DoesNotNoticeASetThatWasAlteredBehindItsBackButTheComparisonDoes) {
    const world::TypeTable types = three_types();
    RandomWorld w(7, 60.0F);
    for (int i = 0; i < 60; ++i) {
        w.spawn();
    }
    const std::vector<world::Viewer> viewers = {{ClientId(1), w.entities.id[0]}};
    w.entities.set_type(0, 0);
    Matcher matcher;
    world::Visibility visibility;
    Model model;
    for (int tick = 0; tick < 3; ++tick) {
        matcher.step(w.entities, types, viewers, two_lods(), visibility);
        model.step(w.entities, types, viewers[0], two_lods());
    }
    ASSERT_EQ(visibility[0].visible.size(), model.known_.size());
    ASSERT_FALSE(visibility[0].visible.empty());
    visibility[0].visible.pop_back();
    matcher.step(w.entities, types, viewers, two_lods(), visibility);
    EXPECT_NE(visibility[0].visible.size(), model.known_.size());
}

TEST(Matcher, EqualsBruteForceWhileItComesAndGoesAsABroadcast) {
    // All radii are at least 20 m, the crowd fits into 16 m (diagonal), and outliers teleport.
    world::TypeTable types(1);
    types[0].aura_m = {20, 20, 20, 20};
    types[0].nimbus_m = {25, 25, 25, 25};
    const InterestSettings settings = two_lods();
    RandomWorld w(9, 5.5F);
    for (int i = 0; i < 20; ++i) {
        w.spawn();
        w.entities.set_type(static_cast<world::Row>(i), 0);
    }
    std::vector<world::Viewer> viewers;
    for (std::uint32_t c = 1; c <= 5; ++c) {
        viewers.push_back({ClientId(c), w.entities.id[c]});
    }
    Matcher matcher;
    world::Visibility visibility;
    std::vector<Model> models(viewers.size());
    int broadcasts = 0;
    for (int tick = 0; tick < 300; ++tick) {
        const world::Row row = w.rng.below(20);
        w.entities.position[row] = w.anywhere() * (tick % 10 == 0 ? 9.0F : 1.0F);
        if (tick % 10 == 5) {
            for (Vec3& p : w.entities.position) {
                p = w.anywhere();
            }
        }
        const InterestReport report =
            matcher.step(w.entities, types, viewers, settings, visibility);
        broadcasts += report.broadcast ? 1 : 0;
        for (std::size_t i = 0; i < viewers.size(); ++i) {
            const Model::Known before = models[i].known_;
            models[i].step(w.entities, types, viewers[i], settings);
            expect_difference(visibility[i], before, models[i].known_);
        }
        ASSERT_FALSE(HasFailure()) << "tick " << tick;
    }
    EXPECT_GT(broadcasts, 100);
    EXPECT_LT(broadcasts, 300);
}

/// Default InterestSettings are settings too.
TEST(Matcher, ForgetsWhatGoesBeyondTheWidenedRadiusAlsoWithDefaultSettings) {
    const world::TypeTable types = three_types();
    const InterestSettings settings;
    world::Entities entities;
    entities.add(EntityId(1), 0);
    const world::Row goer = entities.add(EntityId(2), 0);
    Matcher matcher;
    Model model;
    world::Visibility out;
    const std::vector<world::Viewer> viewers = {{ClientId(1), EntityId(1)}};
    for (int tick = 0; tick < 300; ++tick) {
        entities.position[goer].x() = 0.3F * static_cast<float>(tick);
        matcher.step(entities, types, viewers, settings, out);
        model.step(entities, types, viewers[0], settings);
        ASSERT_EQ(out[0].visible.size(), model.known_.size()) << "tick " << tick;
    }
    EXPECT_TRUE(out[0].visible.empty());
}

TEST(Matcher, SkipsEverythingWithoutAViewer) {
    const world::TypeTable types = three_types();
    RandomWorld w(4, 50.0F);
    w.spawn();
    Matcher matcher;
    world::Visibility visibility(1);
    const InterestReport report = matcher.step(w.entities, types, {}, two_lods(), visibility);
    EXPECT_TRUE(report.skipped);
    EXPECT_FALSE(report.broadcast);
    EXPECT_TRUE(visibility.empty());
}

TEST(Matcher, AViewerWhoseAvatarIsGoneHearsNothingAnyMore) {
    const world::TypeTable types = three_types();
    world::Entities entities;
    entities.add(EntityId(1), 0);
    entities.add(EntityId(2), 0);
    const std::vector<world::Viewer> viewers = {{ClientId(1), EntityId(1)}};
    Matcher matcher;
    world::Visibility visibility;
    matcher.step(entities, types, viewers, two_lods(), visibility);
    ASSERT_EQ(visibility[0].visible.size(), 1U);
    entities.remove(entities.find(EntityId(1)));
    matcher.step(entities, types, viewers, two_lods(), visibility);
    EXPECT_TRUE(visibility[0].visible.empty());
    EXPECT_EQ(visibility[0].left, std::vector<EntityId>{EntityId(2)});
}

TEST(Matcher, LeavesOutPositionsThatAreNotFinite) {
    const world::TypeTable types = three_types();
    world::Entities entities;
    for (std::uint32_t i = 1; i <= 3; ++i) {
        entities.add(EntityId(i), 0);
    }
    entities.position[1].x() = std::numeric_limits<float>::quiet_NaN();
    const std::vector<world::Viewer> viewers = {{ClientId(1), EntityId(1)},
                                                {ClientId(2), EntityId(2)}};
    Matcher matcher;
    world::Visibility visibility;
    const InterestReport report = matcher.step(entities, types, viewers, two_lods(), visibility);
    EXPECT_FALSE(report.broadcast);
    ASSERT_EQ(visibility[0].visible.size(), 1U);
    EXPECT_EQ(visibility[0].visible[0].entity, EntityId(3));
    EXPECT_TRUE(visibility[1].visible.empty());
}

TEST(Matcher, MatchesTenThousandViewersWithoutAllocatingAfterWarmUp) {
    constexpr std::uint32_t kViewers = 10000;
    constexpr std::uint32_t kEntities = 100000;
    world::TypeTable types(1);
    types[0].aura_m = {60, 60, 60, 60};
    types[0].nimbus_m = {60, 60, 60, 60};
    world::Entities entities;
    core::Rng rng(5);
    std::vector<world::Viewer> viewers;
    for (std::uint32_t i = 1; i <= kEntities; ++i) {
        const world::Row row = entities.add(EntityId(i), 0);
        entities.position[row] = Vec3(rng.range(-2000, 2000), 0, rng.range(-2000, 2000));
        entities.velocity[row] = Vec3(rng.range(-4, 4), 0, rng.range(-4, 4));
        if (i % (kEntities / kViewers) == 0) {
            viewers.push_back({ClientId(i), EntityId(i)});
        }
    }
    Matcher matcher;
    const InterestSettings settings = two_lods();
    world::Visibility visibility;
    InterestReport report;
    constexpr int kWarmUp = 3;
    constexpr int kTicks = 10;
    double seconds = 0.0;
    for (int tick = 0; tick < kWarmUp + kTicks; ++tick) {
        // The last tick repeats the positions of the one before: sets of the same sizes, so that an
        // allocation could only come from working space that is not kept.
        const bool still = tick == kWarmUp + kTicks - 1;
        for (std::size_t row = 0; row < entities.size() && !still; ++row) {
            entities.position[row] += entities.velocity[row] / 30.0F;
        }
        const std::uint64_t before = allocation_count();
        const auto begin = std::chrono::steady_clock::now();
        report = matcher.step(entities, types, viewers, settings, visibility);
        const auto end = std::chrono::steady_clock::now();
        seconds += tick >= kWarmUp ? std::chrono::duration<double>(end - begin).count() : 0.0;
        if (still) {
            EXPECT_EQ(allocation_count() - before, 0U);
        }
    }
    // Expected pairs: 10^4 viewers x 10^5 / (16 km2) x pi (60 m)^2 = 7.07 10^5, a few percent less
    // at the edges of the world and a little more by hysteresis.
    EXPECT_GT(report.visible_pairs, 640000U);
    EXPECT_LT(report.visible_pairs, 860000U);
    std::printf("matching 10,000 viewers x 100,000 entities: %.1f ms per tick, %u pairs\n",
                seconds / kTicks * 1e3,
                report.visible_pairs);
}

}  // namespace
}  // namespace zoned::interest
