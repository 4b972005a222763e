// The own avatar against servers whose states make no sense.
#include "client-sim/view/own_avatar.h"

#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

namespace zoned::view {
namespace {

constexpr Tick kNewest = 1000;

wire::OwnState state_of(Tick tick) {
    wire::OwnState own;
    own.avatar = EntityId(test::FakeServer::kAvatar);
    own.input_tick = tick;
    own.state.position = Vec3(0.0F, 1.0F, 0.0F);
    return own;
}

/// An avatar with a full ring of commands, up to kNewest.
OwnAvatar walked(const WorldInfo& world) {
    OwnAvatar own(world);
    own.reconcile(state_of(kNewest - 300), ZoneId(1));
    for (Tick tick = kNewest - 299; tick <= kNewest; ++tick) {
        motion::InputCommand command;
        command.tick = tick;
        command.move_x = 100;
        own.push(command);
    }
    return own;
}

/// The commands of a packet can be written, whatever the server said.
void expect_consecutive(std::span<const motion::InputCommand> commands) {
    for (std::size_t i = 1; i < commands.size(); ++i) {
        EXPECT_EQ(commands[i].tick, commands[0].tick + static_cast<Tick>(i));
    }
    std::vector<std::uint8_t> body;
    wire::write_commands(commands, body);
}

TEST(OwnAvatar, GoesOnAfterStatesFromAnyTimeOfTheRing) {
    const auto world = test::read_world(test::FakeServer().world());
    ASSERT_TRUE(world.ok());
    for (const bool other_avatar : {false, true}) {
        for (Tick distance = -600; distance <= 600; ++distance) {
            OwnAvatar own = walked(*world);
            wire::OwnState state = state_of(kNewest - distance);
            state.avatar = EntityId(other_avatar ? 5 : test::FakeServer::kAvatar);
            own.reconcile(state, ZoneId(1));
            for (Tick tick = kNewest + 1; tick < kNewest + 6; ++tick) {
                motion::InputCommand command;
                command.tick = tick;
                own.push(command);
                expect_consecutive(own.newest_commands(4));
                EXPECT_TRUE(own.position_between(0.5).allFinite());
            }
            // The truth comes back, and with it the prediction.
            own.reconcile(state_of(kNewest + 5), ZoneId(1));
            if (distance >= -5) {
                EXPECT_TRUE(own.known()) << distance;
                EXPECT_EQ(own.position(), Vec3d(0.0, 1.0, 0.0)) << distance;
            }
        }
    }
}

TEST(OwnAvatar, GoesOnAfterStatesFromTheEndsOfTime) {
    const auto world = test::read_world(test::FakeServer().world());
    ASSERT_TRUE(world.ok());
    for (const Tick tick : {Tick{0}, Tick{-1}, INT64_MIN, Tick{1} << 32, (Tick{1} << 40)}) {
        OwnAvatar own = walked(*world);
        own.reconcile(state_of(tick), ZoneId(1));
        own.reconcile(state_of(tick), ZoneId(77));
        motion::InputCommand command;
        command.tick = kNewest + 1;
        own.push(command);
        expect_consecutive(own.newest_commands(8));
    }
}

}  // namespace
}  // namespace zoned::view
