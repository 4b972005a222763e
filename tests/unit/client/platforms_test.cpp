// Platforms: the descriptions and courses that a client receives.
#include "client-sim/view/view.h"
#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::view::platforms_test {
namespace {

proto::WorldDescription with_platforms() {
    proto::WorldDescription w = test::FakeServer().world();
    for (const bool by_rules : {false, true}) {
        proto::Platform& platform = *w.add_platforms();
        platform.set_name(by_rules ? "lift" : "ferry");
        for (const float v : {1.0F, 2.0F, 3.0F}) {
            platform.mutable_box()->add_centre(v);
            platform.mutable_box()->add_half_extents(v);
            platform.add_offsets(0.0F);
        }
        for (const float v : {4.0F, 0.0F, 1.0F}) {
            platform.add_offsets(v);
        }
        platform.add_ticks(0);
        platform.add_ticks(100);
        platform.set_wait(10);
        platform.set_by_rules(by_rules);
        platform.set_start(by_rules ? 100 : 0);
    }
    return w;
}

TEST(ReplicatedPlatforms, StandInTheGeometryOfEachZone) {
    const auto world = test::read_world(with_platforms());
    ASSERT_TRUE(world.ok()) << world.error();
    ASSERT_EQ(world->platforms.size(), 2U);
    EXPECT_EQ(world->platforms[0].name, "ferry");
    for (const ZoneInfo& zone : world->zones) {
        ASSERT_EQ(zone.geometry.platforms().size(), 2U);
        const Vec3 first = (Vec3d(1, 2, 3) - zone.origin).cast<float>();
        EXPECT_EQ(zone.geometry.platform_box(0, 10).centre, first);
        EXPECT_EQ(zone.geometry.platform_box(0, 60).centre, first + Vec3(2.0F, 0.0F, 0.5F));
        EXPECT_EQ(zone.geometry.platform_box(1, 60).centre, first + Vec3(4.0F, 0.0F, 1.0F));
    }
}

TEST(ReplicatedPlatforms, AreRefusedWhereTheyMakeNoSense) {
    const auto refused = [](auto&& spoil) {
        proto::WorldDescription w = with_platforms();
        spoil(*w.mutable_platforms(1));
        return !test::read_world(w).ok();
    };
    using Told = proto::Platform;
    EXPECT_FALSE(refused([](Told&) {}));
    EXPECT_TRUE(refused([](Told& p) { p.clear_box(); }));
    EXPECT_TRUE(refused([](Told& p) { p.mutable_box()->clear_centre(); }));
    EXPECT_TRUE(refused([](Told& p) { p.clear_ticks(); }));
    EXPECT_TRUE(refused([](Told& p) { p.add_ticks(120); })) << "no place";
    EXPECT_TRUE(refused([](Told& p) { p.set_ticks(0, 1); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_ticks(1, 0); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_ticks(1, INT64_MAX); }));
    EXPECT_TRUE(
        refused([](Told& p) { p.set_offsets(2, std::numeric_limits<float>::quiet_NaN()); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_wait(-1); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_shift(INT64_MAX); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_start(101); }));
    EXPECT_TRUE(refused([](Told& p) { p.set_back(5); })) << "rules move none in a circle";
}

TEST(ReplicatedPlatforms, GoByTheCoursesThatAreAnnounced) {
    const auto world = test::read_world(with_platforms());
    ASSERT_TRUE(world.ok());
    View view(std::make_shared<const WorldInfo>(*world), {}, nullptr);
    const auto announce = [&](std::uint32_t platform, Tick from, Tick along, Tick to) {
        proto::SharedEnvironment update;
        auto& course = *update.add_platforms();
        course.set_platform(platform);
        course.set_from(from);
        course.set_along(along);
        course.set_to(to);
        wire::EventMessage event;
        event.kind = wire::kEventSharedEnvironment;
        event.tick = from - 15;
        event.payload = update.SerializeAsString();
        const std::uint64_t before = view.stats().environment_malformed;
        view.apply(event);
        return view.stats().environment_malformed == before;
    };
    EXPECT_TRUE(announce(1, 200, 100, 0));
    EXPECT_EQ(view.world().zones[0].geometry.along_at(1, 230), 70);
    EXPECT_EQ(view.world().zones[0].geometry.along_at(1, 500), 0);
    EXPECT_FALSE(announce(0, 200, 100, 0)) << "the ferry goes by its times";
    EXPECT_FALSE(announce(2, 200, 100, 0));
    EXPECT_FALSE(announce(1, 200, 101, 0));
    EXPECT_FALSE(announce(1, 200, 0, -1));
}

}  // namespace
}  // namespace zoned::view::platforms_test
