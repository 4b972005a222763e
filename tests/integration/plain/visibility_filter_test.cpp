// Concealed entities are kept from viewers within their radii: behind walls, or because rules say
// so.
#include "server/zone/viewers/visibility_filter.h"

#include "server/app/world/world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"
#include "proto/session.pb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

namespace zoned::app {
namespace {

/// One zone of 100 m with a player at (0, 0), who hears 40 m far, and a wall of 8 m at x = 5.
config::Settings walled(world::VisibilityFilter visibility_filter) {
    config::Settings s = scenario::small_world(1, 1, 100.0);
    s.types[scenario::kCrate].visibility_filter = visibility_filter;
    s.spawn_points = {{Vec3d(0.0, 0.9, 0.0), "", ""}};
    motion::StaticBox wall;
    wall.centre = Vec3(5.0F, 2.0F, 0.0F);
    wall.half_extents = Vec3(0.2F, 2.0F, 4.0F);
    s.boxes.push_back(wall);
    return s;
}

config::InitialEntity crate_at(float x, float z) {
    config::InitialEntity crate;
    crate.type = scenario::kCrate;
    crate.position = Vec3d(x, 0.5, z);
    crate.asleep = true;
    return crate;
}

class FilteredWorld {
  public:
    explicit FilteredWorld(const config::Settings& settings) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        world_.emplace(settings, 1);
    }

    void join() {
        mailbox::Join join;
        join.client = ClientId(1);
        join.name = "player";
        tick({join});
    }

    void tick(const std::vector<mailbox::InboxItem>& items = {}) {
        out.clear();
        world_->tick(items, out);
    }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            tick();
        }
    }

    zone::ZoneState& state() { return world_->zones()[0]->state(); }

    bool knows(EntityId entity) {
        const auto& sets = state().visibility;
        return !sets.empty() &&
               std::any_of(sets[0].visible.begin(),
                           sets[0].visible.end(),
                           [&](const world::Visible& v) { return v.entity == entity; });
    }

    /// Entities in the order in which they were placed.
    EntityId placed(std::size_t i) { return state().entities.id[i]; }

    std::vector<mailbox::OutboxItem> out;

  private:
    std::optional<World> world_;
};

TEST(FilteredVisibility, AWallHidesWhatStandsBehindItAndNothingElse) {
    config::Settings s = walled(world::VisibilityFilter::kLineOfSight);
    s.initial = {crate_at(8.0F, 0.0F), crate_at(8.0F, 20.0F), crate_at(-8.0F, 0.0F)};
    FilteredWorld c(s);
    c.join();
    c.ticks(30);
    EXPECT_FALSE(c.knows(c.placed(0)));
    EXPECT_TRUE(c.knows(c.placed(1)));
    EXPECT_TRUE(c.knows(c.placed(2)));
    EXPECT_TRUE(c.state().report.plan.has(zone::Pass::kVisibilityFilter));
}

TEST(FilteredVisibility, WhoStepsOutOfSightIsForgottenAfterTheGraceAndWhatItAnnouncesIsNotSent) {
    config::Settings s = walled(world::VisibilityFilter::kLineOfSight);
    s.visibility_filter.stale_ticks = 4;
    s.visibility_filter.grace_ticks = 6;
    s.initial = {crate_at(8.0F, 20.0F)};
    FilteredWorld c(s);
    c.join();
    const EntityId crate = c.placed(0);
    const auto announced = [&] {
        return std::count_if(c.out.begin(), c.out.end(), [](const mailbox::OutboxItem& item) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            return event != nullptr && event->kind >= zone::kFirstRulesEvent;
        });
    };
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.announce(crate, zone::RulesEvent{});
    };
    c.ticks(5);
    ASSERT_TRUE(c.knows(crate));
    EXPECT_EQ(announced(), 1);
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.teleport(crate, Vec3(8.0F, 0.5F, 0.0F));
        context.announce(crate, zone::RulesEvent{});
    };
    c.tick();
    int known = 0;
    for (; c.knows(crate) && known < 100; ++known) {
        EXPECT_EQ(announced(), 1);
        c.tick();
    }
    // No answer older than 4 ticks counts, and then the grace.
    EXPECT_LE(known, 4 + 6);
    EXPECT_GE(known, 6);
    EXPECT_EQ(announced(), 0);
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.teleport(crate, Vec3(8.0F, 0.5F, 20.0F));
    };
    c.ticks(3);
    EXPECT_TRUE(c.knows(crate));
}

TEST(FilteredVisibility, RulesMayKeepAnEntityFromAViewer) {
    config::Settings s = walled(world::VisibilityFilter::kRules);
    s.initial = {crate_at(-8.0F, 0.0F), crate_at(-9.0F, 5.0F)};
    FilteredWorld c(s);
    const EntityId secret = c.placed(0);
    plain_log()->may_hear = [&](EntityId, EntityId entity) {
        return entity != secret;
    };
    c.join();
    c.ticks(20);
    EXPECT_FALSE(c.knows(secret));
    EXPECT_TRUE(c.knows(c.placed(1)));
    plain_log()->may_hear = nullptr;
    c.ticks(8);
    EXPECT_TRUE(c.knows(secret));
}

TEST(FilteredVisibility, KeepsItsBudgetAndTellsNobodyUnasked) {
    config::Settings s = walled(world::VisibilityFilter::kLineOfSight);
    s.visibility_filter.checks_per_tick = 5;
    for (int i = 0; i < 40; ++i) {
        s.initial.push_back(crate_at(-6.0F - 2.0F * static_cast<float>(i % 8),
                                     -10.0F + 4.0F * static_cast<float>(i / 8)));
    }
    FilteredWorld c(s);
    c.join();
    std::size_t known = 0;
    for (int tick = 0; tick < 40; ++tick) {
        c.tick();
        EXPECT_LE(c.state().filtered.checks, 5U);
        known = std::max(known, c.state().visibility[0].visible.size());
        for (const world::Visible& v : c.state().visibility[0].visible) {
            const zone::FilteredPair* pair =
                zone::find_filtered_pair(c.state(), ClientId(1), v.entity);
            ASSERT_NE(pair, nullptr);
            EXPECT_GE(pair->asked, 0);
        }
    }
    EXPECT_GT(known, 5U);
    EXPECT_GT(c.state().filtered.overdue, 0U);
}

TEST(FilteredVisibility, IsNoPassWhereNoTypeIsFiltered) {
    config::Settings s = walled(world::VisibilityFilter::kNothing);
    s.initial = {crate_at(8.0F, 0.0F)};
    FilteredWorld c(s);
    c.join();
    c.ticks(3);
    EXPECT_TRUE(c.knows(c.placed(0)));
    EXPECT_FALSE(c.state().report.plan.has(zone::Pass::kVisibilityFilter));
    EXPECT_TRUE(c.state().filtered.heard.empty());
}

TEST(FilteredVisibility, KeepsBurstsFromThoseWhoDoNotSeeThePlace) {
    // The player's eyes are at x = 0 before the wall at x = 5, 4 m high.
    for (const bool conceals : {false, true}) {
        config::Settings s = walled(world::VisibilityFilter::kNothing);
        const motion::BurstKind kind{0.5F, 0.5F, 0.0F, 1.0F, 2.0F};
        s.cosmetics.push_back({"sparks", Vec3::Zero(), 0.0F, Vec3::Zero(), {}, kind});
        s.cosmetic_bursts.push_back({"sparks", 0, kind, 30.0F, 1000.0F, conceals});
        FilteredWorld c(s);
        c.join();
        c.ticks(2);
        const auto told = [&](const Vec3& place) {
            plain_log()->each_tick = [&](zone::RulesContext& context) {
                const Vec3d origin = context.origin();
                context.emit(
                    "sparks", (place.cast<double>() - origin).cast<float>(), Vec3::UnitY(), 5);
            };
            c.tick();
            plain_log()->each_tick = nullptr;
            return std::count_if(c.out.begin(), c.out.end(), [](const mailbox::OutboxItem& item) {
                const auto* event = std::get_if<mailbox::EventOut>(&item);
                return event != nullptr && event->kind == proto::CORE_EVENT_PARTICLE_BURST;
            });
        };
        EXPECT_EQ(told(Vec3(8.0F, 1.0F, 0.0F)), conceals ? 0 : 1) << "behind the wall";
        EXPECT_EQ(told(Vec3(4.8F, 1.0F, 0.0F)), 1) << "on its near side";
        EXPECT_EQ(told(Vec3(5.2F, 1.0F, 0.0F)), conceals ? 0 : 1) << "on its far side";
        EXPECT_EQ(told(Vec3(8.0F, 1.0F, 20.0F)), 1) << "beside it";
        EXPECT_EQ(told(Vec3(3.0F, 0.0F, 0.0F)), 1) << "on the ground before it";
    }
}

TEST(Stances, WithAConeHearFarWhereTheViewerLooks) {
    config::Settings s = walled(world::VisibilityFilter::kNothing);
    s.stances = {"driving", "zoomed"};
    s.types[scenario::kPlayer].nimbus_m.fill(10.0F);
    s.types[scenario::kPlayer].nimbus_cone[5] = {45.0F, 0.3F};
    s.initial = {crate_at(0.0F, 30.0F), crate_at(0.0F, -30.0F), crate_at(20.0F, 25.0F)};
    FilteredWorld c(s);
    c.join();
    c.ticks(2);
    const EntityId avatar = plain_log()->avatars[ClientId(1)];
    const auto look = [&](std::uint16_t yaw) {
        motion::InputCommand command;
        command.tick = c.state().now + 1;
        command.yaw = yaw;
        c.tick({mailbox::Input{ClientId(1), {command}}});
        return std::array<bool, 3>{
            c.knows(c.placed(0)), c.knows(c.placed(1)), c.knows(c.placed(2))};
    };
    EXPECT_EQ(look(0), (std::array<bool, 3>{false, false, false}));
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        context.set_stance(avatar, *context.stance_named("zoomed"));
    };
    EXPECT_EQ(look(0), (std::array<bool, 3>{true, false, false}));
    EXPECT_EQ(look(32768), (std::array<bool, 3>{false, true, false}));
}

TEST(Stances, ThatAConfigNamesHaveRadiiOfTheirOwnThatRulesSwitchTo) {
    config::Settings s = walled(world::VisibilityFilter::kNothing);
    s.stances = {"driving", "zoomed"};
    s.types[scenario::kPlayer].nimbus_m = {10, 10, 10, 10, 10, 35, 10, 10};
    s.initial = {crate_at(-30.0F, 0.0F)};
    FilteredWorld c(s);
    c.join();
    c.ticks(2);
    EXPECT_FALSE(c.knows(c.placed(0)));
    plain_log()->each_tick = [&](zone::RulesContext& context) {
        EXPECT_EQ(context.stance_named("walking"), std::nullopt);
        EXPECT_EQ(context.stance_named("riding"), world::Stance::kRiding);
        const auto zoomed = context.stance_named("zoomed");
        ASSERT_TRUE(zoomed.has_value());
        context.set_stance(plain_log()->avatars[ClientId(1)], *zoomed);
    };
    c.ticks(2);
    EXPECT_TRUE(c.knows(c.placed(0)));
}

}  // namespace
}  // namespace zoned::app
