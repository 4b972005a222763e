// Doors that rules move: alike in all zones and on clients that were told, also after a snapshot
// and on any number of threads; and the levers that players move them by.
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"
#include "proto/session.pb.h"
#include "shared/motion/input_command.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace zoned::app {
namespace {

using test::Crowd;

// The door lies in both zones, and so do its levers.
constexpr const char* kGateWorld = R"(
world { name: "gates" seed: 5 tick_rate_hz: 20 min_x_m: -50 min_z_m: -50 max_x_m: 50 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "ball" sphere { radius_m: 0.5 } mass_kg: 2 aura_m { normal: 50 } }
type { name: "lever" box { y_m: 1.2 } mass_kg: 5000 aura_m { normal: 50 } field { name: "on" flag { } } lever { reach_m: 3 } }
type { name: "walker" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } character { speed_mps: 3 } brain: "walk" }
brain { name: "walk" state { name: "walk" action: WANDER radius_m: 30 } }
ai { pathfinding { search: A_STAR } }
statics {
  box { x_m: -26 y_m: 1.5 size { x_m: 48 y_m: 3 z_m: 0.4 } }
  box { x_m: 26 y_m: 1.5 size { x_m: 48 y_m: 3 z_m: 0.4 } }
}
door { name: "gate" moved_by: RULES box { y_m: 1.5 size { x_m: 4 y_m: 3 z_m: 0.4 } } }
door { name: "clock" period_s: 4 open { from_s: 1 to_s: 2 } box { x_m: 20 y_m: 1.5 z_m: 10 size { x_m: 4 y_m: 3 z_m: 0.4 } } }
entity { type: "lever" name: "east" x_m: 2.5 z_m: -2 asleep: true }
entity { type: "ball" name: "ball" x_m: 0.8 z_m: -5 asleep: true }
scatter { type: "walker" count: 8 seed: 3 }
spawn { x_m: -1 z_m: -2 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

class MovedDoors : public ::testing::Test {
  protected:
    MovedDoors() { plain_log() = std::make_shared<scenario::PlainLog>(); }

    ~MovedDoors() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    /// Opens the gate in tick 10, for tick 30, and shuts it in tick 60, for tick 80; refusals too.
    static void move(zone::RulesContext& c) {
        if (c.zone() != ZoneId(1) || (c.now() != 10 && c.now() != 60)) {
            return;
        }
        EXPECT_TRUE(c.set_door("gate", c.now() == 10, 1.0));
    }

    static std::unique_ptr<Crowd> made(unsigned threads = 1) {
        plain_log()->busy = true;
        plain_log()->each_tick = move;
        return std::make_unique<Crowd>(kGateWorld, threads);
    }

    static bool shut(Crowd& in, std::size_t zone) {
        const zone::ZoneState& state = in.world().zones()[zone]->state();
        return static_cast<bool>(state.doors.body[0]);
    }

    static std::vector<std::uint64_t> hashes(Crowd& of) {
        std::vector<std::uint64_t> all;
        of.world().hash_zones(all);
        return all;
    }
};

TEST_F(MovedDoors, TurnInTheirTickInEveryZone) {
    const auto world = made();
    for (Tick tick = 1; tick <= 100; ++tick) {
        world->tick();
        const bool open = tick >= 30 && tick < 80;
        for (std::size_t zone = 0; zone < 2; ++zone) {
            ASSERT_EQ(shut(*world, zone), !open) << tick;
            zone::ZoneContext context(world->world().zones()[zone]->state());
            ASSERT_EQ(context.door_open("gate"), open) << tick;
        }
    }
}

TEST_F(MovedDoors, AreMovedByRulesAloneAndInTime) {
    const auto world = made();
    world->tick();
    zone::ZoneContext c(world->world().zones()[0]->state());
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(c.set_door("hatch", true, 1.0)) << "there is none";
    EXPECT_FALSE(c.set_door("clock", true, 1.0)) << "it has times of its own";
    EXPECT_FALSE(c.set_door("gate", true, none));
    EXPECT_FALSE(c.set_door("gate", true, -1.0));
    EXPECT_FALSE(c.set_door("gate", true, 1e300));
    EXPECT_FALSE(c.door_open("clock").has_value());
    EXPECT_FALSE(c.door_open("hatch").has_value());
    ASSERT_TRUE(world->world().zones()[0]->state().out.doors.empty());
    EXPECT_TRUE(c.set_door("gate", true, 0.0));
    EXPECT_EQ(world->world().zones()[0]->state().out.doors[0].course.from, c.now() + 10)
        << "half a second ahead";
}

TEST_F(MovedDoors, GoOnAfterASnapshotAsIfNothingHadBeen) {
    const auto world = made();
    for (const Tick at : {20, 45, 70}) {  // announced and not turned; open; announced again
        while (world->world().now() < at) {
            world->tick();
        }
        std::vector<std::uint8_t> bytes;
        std::string wrong = world->world().save(bytes);
        for (int more = 0; !wrong.empty() && more < 20; ++more) {  // paths follow the door
            world->tick();
            bytes.clear();
            wrong = world->world().save(bytes);
        }
        ASSERT_EQ(wrong, "");
        const auto copy = made();
        ASSERT_EQ(copy->world().load(bytes), "");
        ASSERT_EQ(copy->world().now(), world->world().now());
        const auto before = std::make_pair(shut(*world, 0), shut(*world, 1));
        EXPECT_EQ(std::make_pair(shut(*copy, 0), shut(*copy, 1)), before);
        std::vector<std::uint64_t> copied;
        for (int i = 0; i < 40; ++i) {
            copy->tick();
            const auto all = hashes(*copy);
            copied.insert(copied.end(), all.begin(), all.end());
        }
        EXPECT_EQ(shut(*copy, 0), copy->world().now() < 30 || copy->world().now() >= 80);
        std::vector<std::uint64_t> whole;
        for (int i = 0; i < 40; ++i) {
            world->tick();
            const auto all = hashes(*world);
            whole.insert(whole.end(), all.begin(), all.end());
        }
        ASSERT_EQ(copied, whole) << at;
    }
}

TEST_F(MovedDoors, AreTheSameOnAnyNumberOfThreads) {
    std::vector<std::vector<std::uint64_t>> runs;
    for (const unsigned threads : {1U, 2U, 4U}) {
        const auto world = made(threads);
        std::vector<std::uint64_t>& run = runs.emplace_back();
        for (int i = 0; i < 120; ++i) {
            world->tick();
            const auto all = hashes(*world);
            run.insert(run.end(), all.begin(), all.end());
        }
    }
    EXPECT_EQ(runs[0], runs[1]);
    EXPECT_EQ(runs[0], runs[2]);
}

TEST_F(MovedDoors, LetABallThroughAndStopTheNext) {
    const auto world = made();
    zone::ZoneState& state = world->world().zones()[1]->state();
    const auto roll = [&](Tick from) {
        while (world->world().now() < from) {
            world->tick();
        }
        zone::ZoneContext context(state);
        const EntityId ball = context.entity_named("ball");
        context.teleport(ball,
                         Vec3(1.5F, 0.5F, -5.0F) - state.settings.region().origin().cast<float>());
        context.add_velocity(ball, Vec3(0.0F, 0.0F, 10.0F));
        for (int i = 0; i < 20; ++i) {
            world->tick();
        }
        return state.entities.position[state.entities.find(ball)].z();
    };
    EXPECT_GT(roll(35), 1.0F);
    EXPECT_LT(roll(85), 0.0F);
}

mailbox::InboxItem player(double x) {
    mailbox::Join join;
    join.client = ClientId(1);
    join.name = "p";
    join.spawn[0] = x;
    join.spawn[1] = 1.0;
    join.spawn[2] = -2.0;
    join.placed = true;
    return join;
}

mailbox::InboxItem pressing(Tick tick, std::uint16_t buttons) {
    mailbox::Input input;
    input.client = ClientId(1);
    motion::InputCommand command;
    command.tick = tick;
    command.buttons = buttons;
    input.commands.push_back(command);
    return input;
}

constexpr std::uint16_t kLeverButton = 1U << 6U;

TEST_F(MovedDoors, AreToldToClientsBeforeTheyTurn) {
    const auto world = made();
    std::vector<std::pair<Tick, proto::SharedEnvironment>> told;
    for (int i = 0; i < 100; ++i) {
        std::vector<mailbox::OutboxItem> out;
        std::vector<mailbox::InboxItem> inbox;
        if (i == 0) {
            inbox.push_back(player(-1.0));
        }
        world->world().tick(inbox, out);
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind == proto::CORE_EVENT_SHARED_ENVIRONMENT) {
                proto::SharedEnvironment& one =
                    told.emplace_back(event->tick, proto::SharedEnvironment()).second;
                ASSERT_TRUE(one.ParseFromArray(event->payload.data(),
                                               static_cast<int>(event->payload.size())));
            }
        }
    }
    ASSERT_EQ(told.size(), 3U) << "at login, and before each turn";
    EXPECT_EQ(told[0].second.doors_size(), 0);
    EXPECT_EQ(told[1].first, 10);
    ASSERT_EQ(told[1].second.doors_size(), 1);
    EXPECT_EQ(told[1].second.doors(0).door(), 0U);
    EXPECT_EQ(told[1].second.doors(0).from(), 30);
    EXPECT_TRUE(told[1].second.doors(0).open());
    ASSERT_EQ(told[2].second.doors_size(), 2) << "as it is, and as it will be";
    EXPECT_EQ(told[2].second.doors(1).from(), 80);
    EXPECT_FALSE(told[2].second.doors(1).open());
}

TEST_F(MovedDoors, HaveLeversThatTurnForWhoeverPressesTheirButtonWithinReach) {
    // From its own zone, and from across the border.
    for (const double x : {1.0, -0.3}) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        Crowd crowd(kGateWorld);
        World& world = crowd.world();
        std::vector<mailbox::OutboxItem> out;
        const auto tick = [&](const std::vector<mailbox::InboxItem>& inbox) {
            world.tick(inbox, out);
            out.clear();
        };
        tick({player(x)});
        tick({});
        const zone::ZoneState& owner = world.zones()[1]->state();
        const EntityId lever = zone::ZoneContext(world.zones()[1]->state()).entity_named("east");
        const auto on = [&] {
            return std::get<bool>(
                *zone::ZoneContext(world.zones()[1]->state()).field(lever, wire::field_id("on")));
        };
        ASSERT_NE(owner.entities.find(lever), world::kNoRow);
        const auto press = [&](std::uint16_t buttons) {
            tick({pressing(world.now() + 1, buttons)});
            tick({});
        };
        press(1U << 5U);
        EXPECT_FALSE(on()) << "another button";
        press(kLeverButton);
        EXPECT_TRUE(on()) << x;
        tick({pressing(world.now() + 1, kLeverButton)});
        EXPECT_TRUE(on()) << "held down it does not turn again";
        press(0);
        press(kLeverButton);
        EXPECT_FALSE(on());
        const EntityId avatar = plain_log()->avatars.at(ClientId(1));
        ASSERT_EQ(plain_log()->uses.size(), 2U);
        EXPECT_EQ(plain_log()->uses[0].first, ZoneId(2)) << "in the zone that owns it";
        EXPECT_EQ(plain_log()->uses[0].second.lever, lever);
        EXPECT_EQ(plain_log()->uses[0].second.user, avatar);
        EXPECT_TRUE(plain_log()->uses[0].second.on);
        EXPECT_FALSE(plain_log()->uses[1].second.on);
    }
}

TEST_F(MovedDoors, LeversOutOfReachOrHiddenStay) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    Crowd crowd(kGateWorld);
    World& world = crowd.world();
    std::vector<mailbox::OutboxItem> out;
    world.tick(std::vector{player(6.0)}, out);
    world.tick(std::vector{pressing(2, kLeverButton)}, out);
    world.tick({}, out);
    EXPECT_TRUE(plain_log()->uses.empty()) << "3.5 m away, and it reaches 3 m";
    zone::ZoneContext context(world.zones()[1]->state());
    const EntityId avatar = plain_log()->avatars.at(ClientId(1));
    context.teleport(avatar,
                     Vec3(1.0F, 1.0F, -2.0F) -
                         world.zones()[1]->state().settings.region().origin().cast<float>());
    context.hide(context.entity_named("east"));
    world.tick(std::vector{pressing(world.now() + 1, 0)}, out);
    world.tick(std::vector{pressing(world.now() + 1, kLeverButton)}, out);
    world.tick({}, out);
    EXPECT_TRUE(plain_log()->uses.empty());
}

}  // namespace
}  // namespace zoned::app
