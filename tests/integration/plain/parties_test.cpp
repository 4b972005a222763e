// Parties in a running world: across zones, lost clients, topics, snapshots, threads.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/groups/rules_parties.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr zone::PartyId kFirst{1};

mailbox::Join join_of(std::uint32_t client, const std::string& account) {
    mailbox::Join join;
    join.client = ClientId(client);
    join.name = "name of " + account;
    join.account = account;
    return join;
}

/// Two zones of 120 m side by side; clients with an even number begin in the first.
class PartyWorld : public ::testing::Test {
  protected:
    PartyWorld() { begin(zone::PartySettings{3, 100, 40, 60}); }

    ~PartyWorld() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    void begin(std::optional<zone::PartySettings> parties) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        config::Settings settings = scenario::small_world(2, 1, 120.0);
        settings.spawn_points = {{Vec3d(-30.0, 0.9, 0.0), "", ""}, {Vec3d(30.0, 0.9, 0.0), "", ""}};
        settings.parties = parties;
        world.emplace(settings, 1);
    }

    void tick(const std::vector<mailbox::InboxItem>& items = {}) {
        std::vector<mailbox::OutboxItem> out;
        world->tick(items, out);
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind >= zone::kFirstRulesEvent) {
                for (const ClientId client : event->recipients) {
                    heard.push_back(client.value);
                }
            }
        }
    }

    void come(std::uint32_t client, const std::string& account = "") {
        tick({join_of(client, account)});
    }

    [[nodiscard]] static EntityId avatar(std::uint32_t client) {
        return plain_log()->avatars.at(ClientId(client));
    }

    /// In the next tick the rules of a zone with players do this.
    void tick_with(std::uint16_t zone, const std::function<void(zone::RulesContext&)>& call) {
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            if (context.zone() == ZoneId(zone)) {
                call(context);
            }
        };
        tick();
        plain_log()->each_tick = nullptr;
    }

    void order(const std::function<void(zone::RulesParties&)>& call, std::uint16_t zone = 1) {
        tick_with(zone, [&](zone::RulesContext& context) { call(*context.parties()); });
    }

    /// Party 1 of the clients 2, 4 (first zone) and 3 (second), led by 2.
    void form() {
        come(2, "ann");
        come(4);
        come(3, "bob");
        order([](zone::RulesParties& p) {
            p.invite(avatar(2), avatar(3));
            p.invite(avatar(2), avatar(4));
        });
        order([](zone::RulesParties& p) { p.accept(avatar(3), kFirst); }, 2);
        order([](zone::RulesParties& p) { p.accept(avatar(4), kFirst); });
        tick();
        plain_log()->parties.clear();
    }

    /// "1 joined 2": zone, event, client or -; forgets them.
    static std::vector<std::string> told() {
        std::vector<std::string> lines;
        for (const auto& [zone, change] : std::exchange(plain_log()->parties, {})) {
            std::string line = std::to_string(zone.value) + " ";
            line += zone::kPartyEventNames[static_cast<std::size_t>(change.event)];
            line += change.client ? " " + std::to_string(change.client.value) : " -";
            lines.push_back(line);
        }
        return lines;
    }

    std::vector<std::uint32_t> hear_topic() {
        heard.clear();
        tick_with(1, [](zone::RulesContext& context) {
            context.publish(zone::party_topic(kFirst), zone::RulesEvent());
        });
        return std::exchange(heard, {});
    }

    std::optional<World> world;
    std::vector<std::uint32_t> heard;
};

TEST_F(PartyWorld, FormsAcrossZonesAndTellsEachOnceWhereItIs) {
    come(2);
    come(3);
    come(4);
    order([](zone::RulesParties& p) { p.invite(avatar(2), avatar(3)); });
    EXPECT_THAT(told(), IsEmpty());
    tick();
    EXPECT_THAT(told(), ElementsAre("1 joined 2", "2 invited 3"));
    order([](zone::RulesParties& p) { p.accept(avatar(3), kFirst); }, 2);
    tick();
    EXPECT_THAT(told(), ElementsAre("2 joined 3"));
    tick();
    EXPECT_THAT(told(), IsEmpty());
    EXPECT_THAT(hear_topic(), ElementsAre(2, 3));
    // All zones read the same book.
    std::vector<const zone::PartyBook*> books;
    for (const auto& zone : world->zones()) {
        books.push_back(zone->state().parties.book());
    }
    EXPECT_THAT(books, ElementsAre(world->parties(), world->parties()));
}

TEST_F(PartyWorld, FollowsMembersAcrossBorders) {
    form();
    EXPECT_EQ(world->parties()->find(kFirst)->members[2].player.zone, ZoneId(1));
    tick_with(1, [](zone::RulesContext& context) {
        context.teleport(avatar(4), Vec3(100.0F, 0.9F, 5.0F));
    });
    EXPECT_EQ(world->parties()->find(kFirst)->members[2].player.zone, ZoneId(2));
    order([](zone::RulesParties& p) { p.kick(avatar(2), avatar(4)); });
    tick();
    EXPECT_THAT(told(), ElementsAre("2 kicked 4"));
    EXPECT_THAT(hear_topic(), ElementsAre(2, 3));
}

TEST_F(PartyWorld, KeepsPlacesOfAccountsAndTheirTopic) {
    form();
    tick({mailbox::Leave{ClientId(2)}, mailbox::Leave{ClientId(4)}});
    tick();
    // In the zone of the new leader; without an account the place is gone.
    EXPECT_THAT(told(), ElementsAre("1 left 4", "2 leads 3", "2 away -"));
    come(8);  // so that rules of the first zone run
    EXPECT_THAT(hear_topic(), ElementsAre(3));
    come(6, "ann");
    tick();
    EXPECT_THAT(told(), ElementsAre("1 back 6"));
    EXPECT_EQ(world->parties()->party_of(avatar(6)), kFirst);
    EXPECT_EQ(world->parties()->find(kFirst)->leader(), avatar(3));
    EXPECT_THAT(hear_topic(), ElementsAre(3, 6));
    tick({mailbox::Leave{ClientId(3)}});
    for (int i = 0; i < 61; ++i) {
        tick();
    }
    EXPECT_THAT(told(), ElementsAre("1 leads 6", "1 away -", "1 left -", "1 left 6", "1 ended -"));
    EXPECT_THAT(hear_topic(), IsEmpty());
}

TEST_F(PartyWorld, RefusesFloodsAndStrangersAndCountsThem) {
    come(2);
    std::size_t taken = 0;
    order([&](zone::RulesParties& p) {
        for (int i = 0; i < 5000; ++i) {
            taken += p.accept(EntityId(static_cast<std::uint32_t>(i)), kFirst) ? 1U : 0U;
        }
    });
    EXPECT_EQ(taken, zone::kMostPartyOrders);
    EXPECT_EQ(world->parties()->refused(), zone::kMostPartyOrders);
    tick();
    EXPECT_EQ(told().size(), zone::kMostPartyOrders);
}

TEST_F(PartyWorld, TakesTheMembersOfAZoneThatStops) {
    form();
    plain_log()->each_tick = [](zone::RulesContext& context) {
        if (context.zone() == ZoneId(2)) {
            throw std::runtime_error("on purpose");
        }
    };
    tick();
    plain_log()->each_tick = nullptr;
    tick();
    EXPECT_THAT(told(), ElementsAre("1 away -"));
    EXPECT_THAT(hear_topic(), ElementsAre(2, 4));
}

TEST_F(PartyWorld, ChangesNothingWhereNobodyUsesIt) {
    const auto course = [&](std::optional<zone::PartySettings> parties) {
        begin(parties);
        come(2, "ann");
        come(3, "bob");
        for (int i = 0; i < 20; ++i) {
            tick();
        }
        for (const auto& zone : world->zones()) {
            EXPECT_FALSE(zone->report().plan.has(zone::Pass::kInbox));
        }
        tick({mailbox::Leave{ClientId(2)}, mailbox::Leave{ClientId(3)}});
        for (int i = 0; i < 200; ++i) {
            tick();
        }
        EXPECT_TRUE(world->idle());
        EXPECT_THAT(told(), IsEmpty());
        return world->state_hash();
    };
    EXPECT_EQ(course(std::nullopt), course(zone::PartySettings()));
    begin(std::nullopt);
    come(2);
    tick_with(1, [](zone::RulesContext& context) { EXPECT_EQ(context.parties(), nullptr); });
}

TEST_F(PartyWorld, IsPartOfTheStateHash) {
    const auto course = [&](bool promotes) {
        begin(zone::PartySettings{3, 100, 40, 60});
        form();
        if (promotes) {
            order([](zone::RulesParties& p) { p.promote(avatar(2), avatar(4)); });
        } else {
            tick();
        }
        tick();
        std::vector<std::uint64_t> zones;
        world->hash_zones(zones);
        return zones;
    };
    const std::vector<std::uint64_t> a = course(false);
    const std::vector<std::uint64_t> b = course(true);
    EXPECT_NE(a[0], b[0]);
    EXPECT_NE(a[1], b[1]);
}

/// Prints what parties cost: 1,000 players in 250 parties of four zones, at rest.
TEST(PartyCost, IsNothingInATickInWhichNothingHappens) {
    const auto median_ms = [](bool parties) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        config::Settings settings = scenario::small_world(2, 2, 200.0);
        for (world::EntityType& type : settings.types) {
            type.aura_m.fill(1.0F);
            type.nimbus_m.fill(1.0F);
        }
        settings.spawn_points.clear();
        for (int i = 0; i < 1000; ++i) {
            settings.spawn_points.push_back(
                {Vec3d(-95.0 + 6.0 * (i % 32), 0.9, -95.0 + 6.0 * (i / 32)), "", ""});
        }
        if (parties) {
            settings.parties = zone::PartySettings();
        }
        World world(settings, 1);
        std::vector<mailbox::OutboxItem> out;
        std::vector<mailbox::InboxItem> joins;
        for (std::uint32_t client = 1; client <= 1000; ++client) {
            joins.emplace_back(join_of(client, std::to_string(client)));
        }
        world.tick(joins, out);
        const auto give = [&](const std::function<void(zone::RulesParties&)>& orders) {
            plain_log()->each_tick = [&](zone::RulesContext& context) {
                if (context.zone() == ZoneId(1)) {
                    orders(*context.parties());
                }
            };
            world.tick({}, out);
            plain_log()->each_tick = nullptr;
        };
        const auto of = [](std::uint32_t client) {
            return plain_log()->avatars.at(ClientId(client));
        };
        if (parties) {
            give([&](zone::RulesParties& p) {
                for (std::uint32_t client = 1; client <= 1000; ++client) {
                    if (client % 4 != 1) {
                        p.invite(of(client - (client - 1) % 4), of(client));
                    }
                }
            });
            give([&](zone::RulesParties& p) {
                for (std::uint32_t client = 1; client <= 1000; ++client) {
                    if (client % 4 != 1) {
                        p.accept(of(client), zone::PartyId(1 + (client - 1) / 4));
                    }
                }
            });
            EXPECT_EQ(world.parties()->parties().size(), 250u);
            EXPECT_EQ(world.parties()->party_of(of(1000)), zone::PartyId(250));
        }
        std::vector<double> ms;
        for (int tick = 0; tick < 120; ++tick) {
            out.clear();
            const auto begin = std::chrono::steady_clock::now();
            world.tick({}, out);
            ms.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                    .count());
            if (tick > 0 && parties) {
                EXPECT_TRUE(world.parties()->changes().empty());
                for (const auto& zone : world.zones()) {
                    EXPECT_FALSE(zone->report().plan.has(zone::Pass::kInbox));
                }
            }
        }
        std::ranges::sort(ms);
        return ms[ms.size() / 2];
    };
    const double without = median_ms(false);
    const double with = median_ms(true);
    std::printf("1,000 players: %.3f ms a tick; in 250 parties: %.3f ms\n", without, with);
    plain_log() = std::make_shared<scenario::PlainLog>();
}

// ---- by a script ----

constexpr const char* kPartyScript = R"lua(
function on_join(client, avatar, name) state.joined = (state.joined or 0) + 1 end
function on_command(client, avatar, kind, payload)
    local others = avatars()
    local other = others[1 + #payload % #others]
    if kind == 20 then party_invite(avatar, other) end
    if kind == 21 then
        for _, party in ipairs(party_invitations(avatar)) do party_accept(avatar, party) end
    end
    if kind == 22 then party_kick(avatar, other) party_promote(avatar, other) end
    if kind == 23 then party_leave(avatar) end
    if kind == 24 and party_of(avatar) then set_party_value(party_of(avatar), 'last', payload) end
    if kind == 25 then party_accept(avatar, #payload) party_disband(other) end
end
function on_party(event, party, player, other, name, client, refusal)
    state[event] = (state[event] or 0) + 1
    if event == 'joined' then
        publish(party_topic(party), 100, name .. (party_value(party, 'last') or ''))
    end
end
)lua";

config::Settings script_settings() {
    std::string text = R"(
world { name: "parties" seed: 5 tick_rate_hz: 20 min_x_m: -120 min_z_m: -60 max_x_m: 120 max_z_m: 60 }
zones { zone_grid { columns: 2 rows: 1 } ghost_margin_m: 60 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
spawn { x_m: -10 z_m: 0 } spawn { x_m: 10 z_m: 0 } spawn { x_m: 40 z_m: 9 } spawn { x_m: -40 z_m: 9 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
parties { size: 4 invitation_s: 2 rejoin_s: 4 }
session { dev_mode_loopback: true }
script { text: ")";
    for (const char* c = kPartyScript; *c != '\0'; ++c) {
        text += *c == '\n' ? "\\n" : std::string(1, *c);
    }
    text += "\" }\n";
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(text, {}, settings, errors)) {
        ADD_FAILURE() << errors.front().text;
    }
    return settings;
}

/// Players come, go, come back with their account, walk over the border and give orders.
std::vector<mailbox::InboxItem> random_items(core::Rng& rng, std::vector<std::uint32_t>& here) {
    std::vector<mailbox::InboxItem> items;
    const std::uint32_t player = rng.below(24);
    const std::uint32_t client = here[player];
    if (rng.below(6) == 0) {
        // Each account has a client anew each time it comes.
        if (client != 0) {
            items.emplace_back(mailbox::Leave{ClientId(client)});
            here[player] = 0;
        } else {
            here[player] = 1 + *std::ranges::max_element(here) + rng.below(3);
            items.emplace_back(
                join_of(here[player], player % 3 == 0 ? "" : "account " + std::to_string(player)));
        }
    }
    for (int i = 0; i < 3; ++i) {
        const std::uint32_t by = here[rng.below(24)];
        if (by != 0) {
            mailbox::Command command;
            command.client = ClientId(by);
            command.kind = static_cast<std::uint16_t>(20 + rng.below(6));
            command.payload.assign(rng.below(24), 'x');
            items.emplace_back(command);
        }
    }
    return items;
}

class PartyScript : public ::testing::TestWithParam<unsigned> {};

TEST_P(PartyScript, GoesOnFromASnapshotWithAnyNumberOfThreads) {
    const config::Settings settings = script_settings();
    World original(settings, 1);
    World threaded(settings, GetParam());
    std::unique_ptr<World> copy;
    core::Rng rng(GetParam());
    std::vector<std::uint32_t> here(24, 0);
    std::vector<mailbox::OutboxItem> out;
    std::map<zone::PartyEvent, int> events;
    std::size_t bytes_most = 0;
    for (int tick = 0; tick < 1500; ++tick) {
        const std::vector<mailbox::InboxItem> items = random_items(rng, here);
        for (World* world : {&original, &threaded, copy.get()}) {
            if (world != nullptr) {
                out.clear();
                world->tick(items, out);
                ASSERT_EQ(world->parties()->unsound(), "");
                ASSERT_EQ(world->state_hash(), original.state_hash()) << "tick " << tick;
            }
        }
        for (const zone::PartyChange& change : original.parties()->changes()) {
            ++events[change.event];
        }
        if (tick % 100 == 50) {
            std::vector<std::uint8_t> bytes;
            ASSERT_EQ(original.save(bytes), "");
            bytes_most = std::max(bytes_most, bytes.size());
            copy = std::make_unique<World>(settings, 1);
            ASSERT_EQ(copy->load(bytes), "");
            std::vector<std::uint8_t> again;
            ASSERT_EQ(copy->save(again), "");
            ASSERT_EQ(bytes, again);
        }
    }
    EXPECT_EQ(original.script_errors(), 0u);
    for (const zone::PartyEvent event : {zone::PartyEvent::kJoined,
                                         zone::PartyEvent::kAway,
                                         zone::PartyEvent::kBack,
                                         zone::PartyEvent::kKicked,
                                         zone::PartyEvent::kLeads,
                                         zone::PartyEvent::kExpired,
                                         zone::PartyEvent::kEnded}) {
        EXPECT_GT(events[event], 0) << zone::kPartyEventNames[static_cast<std::size_t>(event)];
    }
}

INSTANTIATE_TEST_SUITE_P(Threads, PartyScript, ::testing::Values(2U, 4U));

}  // namespace
}  // namespace zoned::app
