// Doors: the descriptions that a client receives.
#include "client-sim/view/world_info.h"
#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

namespace zoned::view {
namespace {

proto::WorldDescription with_a_door() {
    proto::WorldDescription w = test::FakeServer().world();
    proto::Door& door = *w.add_doors();
    door.set_name("gate");
    for (const float v : {1.0F, 2.0F, 3.0F}) {
        door.mutable_box()->add_centre(v);
        door.mutable_box()->add_half_extents(v);
    }
    door.set_period(100);
    door.set_shift(5);
    for (const int edge : {10, 20, 20, 30}) {
        door.add_open(edge);
    }
    return w;
}

TEST(ReplicatedDoors, StandInTheGeometryOfEachZone) {
    const auto world = test::read_world(with_a_door());
    ASSERT_TRUE(world.ok()) << world.error();
    ASSERT_EQ(world->doors.size(), 1U);
    EXPECT_EQ(world->doors[0].name, "gate");
    for (const ZoneInfo& zone : world->zones) {
        ASSERT_EQ(zone.geometry.doors().size(), 1U);
        const motion::Door& door = zone.geometry.doors()[0];
        EXPECT_EQ(door.box.centre, (Vec3d(1, 2, 3) - zone.origin).cast<float>());
        EXPECT_TRUE(zone.geometry.shut_at(0, 4));
        EXPECT_FALSE(zone.geometry.shut_at(0, 5));
        EXPECT_FALSE(zone.geometry.shut_at(0, 24));
        EXPECT_TRUE(zone.geometry.shut_at(0, 25));
        EXPECT_EQ(door.times, world->doors[0].times);
    }
}

TEST(ReplicatedDoors, AreRefusedWhereTheyMakeNoSense) {
    const auto refused = [](auto&& spoil) {
        proto::WorldDescription w = with_a_door();
        spoil(*w.mutable_doors(0));
        return !test::read_world(w).ok();
    };
    EXPECT_FALSE(refused([](proto::Door&) {}));
    EXPECT_TRUE(refused([](proto::Door& d) { d.clear_box(); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.mutable_box()->clear_centre(); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_period(0); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_period(INT64_MAX); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_shift(-1); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_shift(100); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.add_open(40); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_open(3, 101); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_open(0, -1); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_open(2, 19); }));
    EXPECT_TRUE(refused([](proto::Door& d) { d.set_open(1, 10); }));
}

}  // namespace
}  // namespace zoned::view
