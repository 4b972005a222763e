// Matches in a running world: capture the flag in Lua, played in instances by players and parties.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/groups/match_book.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kCaptureWorld = R"(
world { name: "matches" seed: 5 tick_rate_hz: 20 min_x_m: -100 min_z_m: -60 max_x_m: 100 max_z_m: 60 }
zones { zone_grid { columns: 2 rows: 1 } ghost_margin_m: 60 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "flag" box { x_m: 0.3 y_m: 0.8 z_m: 0.3 } mass_kg: 500 aura_m { normal: 50 } }
entity { type: "flag" name: "flag1" x_m: 45 z_m: 0 asleep: true }
entity { type: "flag" name: "flag2" x_m: 85 z_m: 0 asleep: true }
spawn { x_m: -20 z_m: 0 } spawn { x_m: 20 z_m: 0 } spawn { x_m: -25 z_m: 5 } spawn { x_m: 25 z_m: 5 }
spawn { x_m: 50 z_m: 10 } spawn { x_m: 80 z_m: 10 }
instance { name: "field" area { min_x_m: 40 max_x_m: 90 min_z_m: -30 max_z_m: 30 } copies: 2 close_s: 2 }
parties { size: 2 }
match { name: "ctf" teams: 2 size: 2 instance: "field" limit_s: 20 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

constexpr std::uint16_t kQueue = 20;
constexpr std::uint16_t kGo = 21;  // to the flag of a team: "1", "2"
constexpr std::uint16_t kInvite = 22;
constexpr std::uint16_t kAccept = 23;
constexpr std::uint16_t kResult = 100;

/// Capture the flag: a zone whose instance is a match keeps its score.
constexpr const char* kCaptureScript = R"lua(
function finish() end_match(state.match, 100, 'red ' .. state.score1 .. ' blue ' .. state.score2) end
function on_command(client, avatar, kind, payload)
    if kind == 20 then queue_match('ctf', avatar) end
    if kind == 21 and instance_here() then
        local x, y, z = position(entity_named('flag' .. payload))
        teleport(avatar, x + 0.6, 0.9, z)
    end
    if kind == 22 then party_invite(avatar, tonumber(payload)) end
    if kind == 23 then party_accept(avatar, party_invitations(avatar)[1]) end
end
function on_match(event, match, kind, player, team, refusal)
    state[event] = (state[event] or 0) + 1
    if event == 'came' then entity_state(player).team = team end
    if event == 'began' then
        state.match = match
        state.score1 = 0 state.score2 = 0
        state.carrier1 = nil state.carrier2 = nil
    end
    if event == 'lost' then
        for team = 1, 2 do
            if state['carrier' .. team] == player then state['carrier' .. team] = nil end
        end
    end
    if event == 'time_up' then finish() end
    if event == 'ended' then
        state.match = nil
        for _, a in ipairs(avatars()) do entity_state(a).team = nil end
    end
end
function on_tick()
    if not state.match then return end
    for team = 1, 2 do
        local flag, theirs = entity_named('flag' .. team), 'carrier' .. 3 - team
        for _, a in ipairs(avatars()) do
            local of = entity_state(a).team
            if distance(a, flag) < 1.5 and of then
                if of ~= team and not state['carrier' .. team] then
                    state['carrier' .. team] = a
                elseif of == team and state[theirs] == a then
                    state[theirs] = nil
                    state['score' .. team] = state['score' .. team] + 1
                    if state['score' .. team] >= 2 then finish() end
                end
            end
        end
    end
end
)lua";

config::Settings game_settings() {
    std::string script;
    for (const char* c = kCaptureScript; *c != '\0'; ++c) {
        script += *c == '\n' ? "\\n" : std::string(1, *c);
    }
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(
            std::string(kCaptureWorld) + "script { text: \"" + script + "\" }\n",
            {},
            settings,
            errors)) {
        ADD_FAILURE() << errors.front().path << ": " << errors.front().text;
    }
    return settings;
}

class MatchWorld : public ::testing::Test {
  protected:
    MatchWorld() : settings(game_settings()), world(settings, 2) {}

    void tick(const std::vector<mailbox::InboxItem>& items = {}) {
        std::vector<mailbox::OutboxItem> out;
        world.tick(items, out);
        ASSERT_EQ(world.matches()->unsound(), "");
        for (const mailbox::OutboxItem& item : out) {
            if (const auto* joined = std::get_if<mailbox::Joined>(&item)) {
                avatars[joined->client.value] = joined->avatar;
            }
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind == kResult) {
                EXPECT_TRUE(event->durable);
                for (const ClientId client : event->recipients) {
                    results[client.value].emplace_back(event->payload.begin(),
                                                       event->payload.end());
                }
            }
        }
        for (const mailbox::StoreRequest& request : world.store_requests()) {
            stored += request.act == mailbox::StoreAct::kEvent ? 1 : 0;
        }
    }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            tick();
        }
    }

    void come(std::uint32_t client) {
        mailbox::Join join;
        join.client = ClientId(client);
        join.name = "player";
        tick({join});
    }

    void order(std::uint32_t client, std::uint16_t kind, const std::string& payload = "") {
        mailbox::Command command;
        command.client = ClientId(client);
        command.kind = kind;
        command.payload.assign(payload.begin(), payload.end());
        tick({command});
    }

    [[nodiscard]] Vec3d place_of(std::uint32_t client) const {
        for (const auto& zone : world.zones()) {
            if (zone->owns(avatars.at(client))) {
                const zone::ZoneState& s = zone->state();
                return s.settings.region().origin() +
                       s.entities.position[s.entities.find(avatars.at(client))].cast<double>();
            }
        }
        return Vec3d::Zero();
    }

    [[nodiscard]] std::size_t zone_of(std::uint32_t client) const {
        for (std::size_t z = 0; z < world.zones().size(); ++z) {
            if (world.zones()[z]->owns(avatars.at(client))) {
                return z + 1;
            }
        }
        return 0;
    }

    [[nodiscard]] std::uint16_t team_of(std::uint32_t client) const {
        const zone::Match* const match =
            world.matches()->find(world.matches()->match_of(avatars.at(client)));
        for (const zone::MatchPlayer& player : match->players) {
            if (player.avatar == avatars.at(client)) {
                return player.team;
            }
        }
        return 99;
    }

    /// Of four players, who have queued; the match has begun.
    void begin(std::uint32_t first) {
        for (std::uint32_t client = first; client < first + 4; ++client) {
            come(client);
        }
        ticks(5);
        for (std::uint32_t client = first; client < first + 4; ++client) {
            before[client] = place_of(client);
            order(client, kQueue);
        }
        ticks(4);
    }

    /// A player takes the other team's flag home.
    void capture(std::uint32_t client) {
        const std::uint16_t team = team_of(client);
        order(client, kGo, team == 0 ? "2" : "1");
        ticks(2);
        order(client, kGo, team == 0 ? "1" : "2");
        ticks(2);
    }

    config::Settings settings;
    World world;
    std::map<std::uint32_t, EntityId> avatars;
    std::map<std::uint32_t, std::vector<std::string>> results;
    std::map<std::uint32_t, Vec3d> before;
    int stored = 0;
};

TEST_F(MatchWorld, PlaysInAnInstanceAndSendsAllBackWithTheResult) {
    begin(1);
    ASSERT_EQ(world.matches()->matches().size(), 1u);
    EXPECT_GT(world.matches()->matches()[0].began, 0);
    for (std::uint32_t client = 1; client <= 4; ++client) {
        EXPECT_EQ(zone_of(client), 3u);
    }
    // The entrance of its team.
    const double red = place_of(team_of(1) == 0 ? 1 : 2).x();
    const double blue = place_of(team_of(1) == 0 ? 2 : 1).x();
    EXPECT_NEAR(blue - red, 30.0, 2.0);
    const std::string won = team_of(2) == 0 ? "red 2 blue 0" : "red 0 blue 2";
    capture(2);
    EXPECT_THAT(results, IsEmpty());
    capture(2);
    ticks(3);
    for (std::uint32_t client = 1; client <= 4; ++client) {
        EXPECT_THAT(results[client], ElementsAre(won));
        EXPECT_LT((place_of(client) - before[client]).norm(), 0.01) << client;
    }
    EXPECT_EQ(stored, 1);
    ticks(5);
    EXPECT_THAT(world.matches()->matches(), IsEmpty());
    EXPECT_THAT(world.instances()->open(), IsEmpty());
    EXPECT_EQ(world.zones()[2]->state().entities.size(), 0u);
    EXPECT_EQ(world.script_errors(), 0u);
}

TEST_F(MatchWorld, PlaysSeveralAtATimeApart) {
    begin(1);
    begin(5);
    ASSERT_EQ(world.matches()->matches().size(), 2u);
    EXPECT_EQ(zone_of(1), 3u);
    EXPECT_EQ(zone_of(5), 4u);
    for (const std::size_t zone : {2U, 3U}) {
        for (const world::VisibleSet& set : world.zones()[zone]->state().visibility) {
            EXPECT_EQ(set.visible.size(), 5u);  // three players, two flags
        }
    }
    capture(6);
    capture(6);
    ticks(3);
    EXPECT_EQ(results[5].size(), 1u);
    EXPECT_EQ(results[1].size(), 0u);
    EXPECT_NE(world.matches()->match_of(avatars[1]), zone::MatchId());
}

TEST_F(MatchWorld, EndsWithItsTimeAndKeepsPartiesTogether) {
    for (std::uint32_t client = 1; client <= 4; ++client) {
        come(client);
    }
    ticks(5);
    order(2, kInvite, std::to_string(avatars[4].value));
    ticks(2);
    order(4, kAccept);
    ticks(2);
    order(1, kQueue);
    order(3, kQueue);
    order(4, kQueue);  // who does not lead
    ticks(2);
    EXPECT_THAT(world.matches()->matches(), IsEmpty());
    order(2, kQueue);
    ticks(4);
    EXPECT_EQ(team_of(2), team_of(4));
    EXPECT_NE(team_of(1), team_of(4));
    EXPECT_EQ(team_of(1), team_of(3));
    tick({mailbox::Leave{ClientId(3)}});
    ticks(2);
    EXPECT_TRUE(world.matches()->matches()[0].players[1].lost ||
                world.matches()->matches()[0].players[0].lost);
    ticks(430);
    EXPECT_THAT(results[1], ElementsAre("red 0 blue 0"));
    EXPECT_THAT(results[4], ElementsAre("red 0 blue 0"));
    EXPECT_THAT(world.matches()->matches(), IsEmpty());
    EXPECT_EQ(world.script_errors(), 0u);
}

TEST(MatchScript, GoesOnFromSnapshotsWithAnyNumberOfThreads) {
    const config::Settings settings = game_settings();
    World original(settings, 1);
    World threaded(settings, 4);
    std::unique_ptr<World> copy;
    core::Rng rng(6);
    std::vector<mailbox::OutboxItem> out;
    std::map<zone::MatchEvent, int> events;
    std::set<std::uint32_t> here;
    for (int tick = 0; tick < 2500; ++tick) {
        std::vector<mailbox::InboxItem> items;
        const std::uint32_t player = 1 + rng.below(10);
        if (!here.contains(player)) {
            mailbox::Join join;
            join.client = ClientId(player);
            items.emplace_back(join);
            here.insert(player);
        } else if (rng.below(200) == 0) {
            items.emplace_back(mailbox::Leave{ClientId(player)});
            here.erase(player);
        } else {
            mailbox::Command command;
            command.client = ClientId(player);
            command.kind = rng.below(4) == 0 ? kQueue : kGo;
            command.payload.assign(1, static_cast<std::uint8_t>('1' + rng.below(2)));
            items.emplace_back(command);
        }
        for (World* world : {&original, &threaded, copy.get()}) {
            if (world != nullptr) {
                out.clear();
                world->tick(items, out);
                ASSERT_EQ(world->matches()->unsound(), "");
                ASSERT_EQ(world->state_hash(), original.state_hash()) << "tick " << tick;
            }
        }
        for (const zone::MatchChange& change : original.matches()->changes()) {
            ++events[change.event];
        }
        std::vector<std::uint8_t> bytes;
        if (tick % 250 == 100 && original.save(bytes).empty()) {
            copy = std::make_unique<World>(settings, 1);
            ASSERT_EQ(copy->load(bytes), "");
        }
    }
    EXPECT_NE(copy, nullptr);
    EXPECT_EQ(original.script_errors(), 0u);
    for (const zone::MatchEvent event : {zone::MatchEvent::kRefused,
                                         zone::MatchEvent::kBegan,
                                         zone::MatchEvent::kLost,
                                         zone::MatchEvent::kEnded}) {
        EXPECT_GT(events[event], 2) << zone::kMatchEventNames[static_cast<std::size_t>(event)];
    }
}

}  // namespace
}  // namespace zoned::app
