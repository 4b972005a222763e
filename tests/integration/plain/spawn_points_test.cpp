// Spawn points by team, as players come to them and as rules choose them; and the end of a zone.
#include "server/zone/context/stop_context.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"

#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using test::Crowd;
using test::with;

constexpr const char* kTeamsWorld = R"(
world { name: "teams" seed: 5 tick_rate_hz: 20 min_x_m: -50 min_z_m: -50 max_x_m: 50 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
spawn { x_m: -30 z_m: 0 name: "west" team: "red" }
spawn { x_m: -30 z_m: 20 team: "red" }
spawn { x_m: 30 z_m: 0 name: "east" team: "blue" }
spawn { x_m: -10 z_m: 0 name: "well" }
spawn { x_m: 10 z_m: 0 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

class SpawnPoints : public ::testing::Test {
  protected:
    SpawnPoints() { plain_log() = std::make_shared<scenario::PlainLog>(); }

    ~SpawnPoints() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    /// Where the avatars of a team's next players stand, x.
    std::multiset<double> places_of(World& world, const std::string& team, std::uint32_t players) {
        std::vector<mailbox::InboxItem> inbox;
        std::vector<ClientId> clients;
        for (std::uint32_t i = 0; i < players; ++i) {
            mailbox::Join join;
            join.client = clients.emplace_back(++next_);
            join.name = "p";
            join.team = team;
            inbox.emplace_back(join);
        }
        std::vector<mailbox::OutboxItem> out;
        world.tick(inbox, out);
        std::multiset<double> places;
        for (const ClientId client : clients) {
            for (const auto& zone : world.zones()) {
                const zone::ZoneState& state = zone->state();
                const world::Row row = state.entities.find(plain_log()->avatars.at(client));
                if (row != world::kNoRow && !state.entities.has(row, world::kGhost)) {
                    places.insert(
                        std::round(state.settings.region().origin().x() +
                                   static_cast<double>(state.entities.position[row].x())));
                }
            }
        }
        return places;
    }

    std::uint32_t next_ = 0;
};

TEST_F(SpawnPoints, OfTheirTeamAreWherePlayersComeTo) {
    Crowd crowd(kTeamsWorld);
    EXPECT_EQ(places_of(crowd.world(), "red", 4), (std::multiset<double>{-30, -30, -30, -30}));
    EXPECT_EQ(places_of(crowd.world(), "blue", 2), (std::multiset<double>{30, 30}));
    EXPECT_EQ(places_of(crowd.world(), "", 4), (std::multiset<double>{-10, -10, 10, 10}));
    EXPECT_EQ(places_of(crowd.world(), "green", 2).count(30), 0u) << "it has none: those of all";
}

TEST_F(SpawnPoints, AreAllThereIsWhereAnotherTeamHasThem) {
    std::string text = with(kTeamsWorld, "spawn { x_m: -10 z_m: 0 name: \"well\" }\n", "");
    Crowd crowd(with(text, "spawn { x_m: 10 z_m: 0 }\n", ""));
    EXPECT_EQ(places_of(crowd.world(), "green", 3).size(), 3u);
}

TEST_F(SpawnPoints, AreChosenByRulesByNameTeamAndRoom) {
    Crowd crowd(kTeamsWorld);
    World& world = crowd.world();
    crowd.tick();
    const zone::ZoneContext west(world.zones()[0]->state());
    ASSERT_EQ(west.spawn_points().size(), 5u);
    EXPECT_EQ(west.spawn_points()[0].name, "west");
    EXPECT_EQ(west.spawn_points()[2].team, "blue");
    EXPECT_NEAR(west.local(west.spawn_points()[0].position).x(), -5.0F, 1e-4F);
    EXPECT_EQ(west.freest_spawn("red"), &west.spawn_points()[0]) << "of equals the first";
    EXPECT_EQ(west.freest_spawn("blue"), &west.spawn_points()[2]) << "blue has none in this zone";
    EXPECT_EQ(west.freest_spawn(""), &west.spawn_points()[3]) << "of this zone";
    places_of(world, "red", 1);
    const zone::ZoneState& state = world.zones()[0]->state();
    const world::Row row = state.entities.find(plain_log()->avatars.at(ClientId(1)));
    const bool at_first = state.entities.position[row].z() < 10.0F;
    EXPECT_EQ(west.freest_spawn("red"), &west.spawn_points()[at_first ? 1 : 0]);
}

/// Rules that have something to say at the end.
TEST_F(SpawnPoints, AndTheEndOfAZoneWritesStoreAndLogAndChangesNothing) {
    Crowd crowd(kTeamsWorld);
    World& world = crowd.world();
    places_of(world, "red", 2);
    crowd.tick();
    std::vector<std::uint8_t> before;
    ASSERT_EQ(world.save(before), "");
    const std::uint64_t hash = world.state_hash();
    plain_log()->at_stop = [](zone::StopContext& c) {
        const mailbox::StoreKey key{mailbox::StoreScope::kWorld, "", "", "end"};
        EXPECT_TRUE(c.store_put(key, {1, 2}));
        EXPECT_FALSE(c.store_put({mailbox::StoreScope::kWorld, "", "", ""}, {})) << "no name";
        EXPECT_EQ(c.zone().now(), 2);
        c.log("good night");
        if (c.zone().zone() == ZoneId(2)) {
            throw std::runtime_error("too tired");
        }
    };
    world.stop();
    ASSERT_EQ(world.store_requests().size(), 2u);
    EXPECT_EQ(world.store_requests()[0].number, 0u) << "nobody waits for an answer";
    EXPECT_EQ(world.store_requests()[0].value, (std::vector<std::uint8_t>{1, 2}));
    EXPECT_EQ(world.zones()[0]->output().lines, (std::vector<std::string>{"good night"}));
    EXPECT_EQ(world.zones()[1]->output().lines,
              (std::vector<std::string>{"good night", "on_stop threw: too tired"}));
    std::vector<std::uint8_t> after;
    ASSERT_EQ(world.save(after), "");
    EXPECT_EQ(after, before);
    EXPECT_EQ(world.state_hash(), hash);
}

}  // namespace
}  // namespace zoned::app
