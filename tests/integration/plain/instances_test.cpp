// Instances in a running world: opened as placed, entered, kept apart, ended, saved.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/groups/instance_book.h"
#include "tests/integration/plain/plain_log.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kDungeon = R"(
world { name: "dungeon" seed: 5 tick_rate_hz: 20 min_x_m: -100 min_z_m: -60 max_x_m: 100 max_z_m: 60 }
zones { zone_grid { columns: 1 rows: 1 } ghost_margin_m: 60 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "ball" sphere { radius_m: 0.2 } mass_kg: 2 aura_m { normal: 50 } }
type { name: "guard" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } character { speed_mps: 3 } brain: "guard" }
brain { name: "guard" state { name: "walk" action: WANDER radius_m: 5 } }
statics { box { x_m: 70 y_m: 1 z_m: 10 size { x_m: 4 y_m: 2 z_m: 4 } } box { x_m: -40 y_m: 1 z_m: 10 size { x_m: 4 y_m: 2 z_m: 4 } } }
entity { type: "ball" name: "orb" x_m: 60 z_m: 5 }
entity { type: "ball" name: "outside" x_m: -60 z_m: 5 asleep: true }
entity { type: "guard" name: "boss" x_m: 75 z_m: -10 }
scatter { type: "ball" count: 10 seed: 2 region { min_x_m: 45 max_x_m: 85 min_z_m: -25 max_z_m: 25 } asleep: true }
trigger { name: "altar" x_m: 60 y_m: 1 z_m: 5 size { x_m: 4 y_m: 4 z_m: 4 } type: "ball" }
joint { name: "chain" a: "orb" b: "link" distance { length_m: 3 } }
entity { type: "ball" name: "link" x_m: 63 z_m: 5 }
spawn { x_m: -50 z_m: 0 }
spawn { x_m: -55 z_m: 0 }
spawn { x_m: 45 z_m: 0 }
spawn { x_m: 47 z_m: 3 }
instance { name: "crypt" area { min_x_m: 40 max_x_m: 90 min_z_m: -30 max_z_m: 30 } copies: 3 close_s: 2 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

config::Settings dungeon_settings(const std::string& text) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(text, {}, settings, errors)) {
        ADD_FAILURE() << errors.front().path << ": " << errors.front().text;
    }
    return settings;
}

class Instances : public ::testing::Test {
  protected:
    Instances() : settings(dungeon_settings(kDungeon)) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        world.emplace(settings, 1);
        tick();
    }

    ~Instances() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    void tick(const std::vector<mailbox::InboxItem>& items = {}) {
        out.clear();
        world->tick(items, out);
    }

    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            tick();
        }
    }

    EntityId come(std::uint32_t client) {
        mailbox::Join join;
        join.client = ClientId(client);
        join.account = "account " + std::to_string(client);
        tick({join});
        return avatar(client);
    }

    [[nodiscard]] static EntityId avatar(std::uint32_t client) {
        return plain_log()->avatars.at(ClientId(client));
    }

    /// In the next tick the rules of a zone do this.
    void tick_with(std::uint16_t zone, const std::function<void(zone::RulesContext&)>& call) {
        plain_log()->busy = true;
        plain_log()->each_tick = [&](zone::RulesContext& context) {
            if (context.zone() == ZoneId(zone)) {
                call(context);
            }
        };
        tick();
        plain_log()->each_tick = nullptr;
        plain_log()->busy = false;
    }

    /// Its id; its zone is opened in the next tick, behind this.
    zone::InstanceId open() {
        tick_with(1, [](zone::RulesContext& c) {
            EXPECT_TRUE(c.instances()->open("crypt", EntityId()));
        });
        const zone::InstanceId id = world->instances()->open().back().id;
        tick();
        return id;
    }

    void enter(std::uint32_t client, zone::InstanceId instance, std::uint16_t from = 1) {
        tick_with(from, [&](zone::RulesContext& c) {
            EXPECT_TRUE(c.instances()->enter(c, avatar(client), instance, client));
        });
    }

    /// "2 opened", "1 ready"; forgets them.
    static std::vector<std::string> told() {
        std::vector<std::string> lines;
        for (const auto& [zone, change] : std::exchange(plain_log()->instances, {})) {
            std::string line = std::to_string(zone.value) + " ";
            line += zone::kInstanceEventNames[static_cast<std::size_t>(change.event)];
            lines.push_back(line);
        }
        return lines;
    }

    [[nodiscard]] zone::ZoneState& state(std::size_t zone) {
        return world->zones()[zone - 1]->state();
    }

    [[nodiscard]] Vec3d place_of(EntityId entity) {
        for (const auto& zone : world->zones()) {
            if (zone->owns(entity)) {
                const zone::ZoneState& s = zone->state();
                return s.settings.region().origin() +
                       s.entities.position[s.entities.find(entity)].cast<double>();
            }
        }
        ADD_FAILURE() << "nobody owns " << entity.value;
        return Vec3d::Zero();
    }

    [[nodiscard]] std::size_t zone_of(EntityId entity) {
        for (std::size_t z = 0; z < world->zones().size(); ++z) {
            if (world->zones()[z]->owns(entity)) {
                return z + 1;
            }
        }
        return 0;
    }

    config::Settings settings;
    std::optional<World> world;
    std::vector<mailbox::OutboxItem> out;
};

TEST_F(Instances, AreEmptyAndAsleepUntilTheyOpen) {
    ASSERT_EQ(world->zones().size(), 4u);
    EXPECT_EQ(settings.zones[3].name, "crypt.3");
    ticks(100);
    for (std::size_t z = 2; z <= 4; ++z) {
        EXPECT_EQ(state(z).entities.size(), 0u);
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            const auto pass = static_cast<zone::Pass>(p);
            const bool always = pass == zone::Pass::kHash || pass == zone::Pass::kGhosts;
            EXPECT_EQ(state(z).report.plan.has(pass), always) << zone::pass_name(pass);
        }
    }
}

TEST_F(Instances, AreFartherApartThanAnyRadius) {
    for (std::size_t a = 0; a < settings.zones.size(); ++a) {
        for (std::size_t b = a + 1; b < settings.zones.size(); ++b) {
            const config::ZoneRegion& p = settings.zones[a];
            const config::ZoneRegion& q = settings.zones[b];
            const double apart = std::max(
                {p.min_x - q.max_x, q.min_x - p.max_x, p.min_z - q.max_z, q.min_z - p.max_z});
            EXPECT_GE(apart, 120.0) << p.name << " " << q.name;
        }
    }
}

TEST_F(Instances, HaveDoorsOfTheirOwnForTheRules) {
    settings = dungeon_settings(std::string(kDungeon) +
                                "door { name: 'cell' moved_by: RULES box { x_m: 50 y_m: 1.5 z_m: "
                                "-20 size { x_m: 4 y_m: 3 z_m: 0.4 } } }");
    world.emplace(settings, 1);
    tick();
    open();
    open();
    tick_with(3, [](zone::RulesContext& c) { EXPECT_TRUE(c.set_door("cell", true, 0.5)); });
    ticks(20);
    for (const std::size_t z : {1U, 2U, 3U, 4U}) {
        EXPECT_EQ(zone::ZoneContext(state(z)).door_open("cell"), z == 3) << z;
    }
}

TEST_F(Instances, OpenAsTheConfigPlacesThings) {
    const EntityId orb_outside = zone::ZoneContext(state(1)).entity_named("orb");
    open();
    EXPECT_THAT(told(), ElementsAre("1 ready", "2 opened"));
    EXPECT_EQ(state(2).entities.size(), 13u);  // two balls, a guard, ten scattered ones
    EXPECT_EQ(state(3).entities.size(), 0u);
    const zone::ZoneContext inside(state(2));
    const EntityId orb = inside.entity_named("orb");
    ASSERT_TRUE(orb);
    EXPECT_NE(orb, orb_outside);
    EXPECT_EQ(zone_of(orb), 2u);
    EXPECT_EQ(zone::ZoneContext(state(1)).entity_named("orb"), orb_outside);
    EXPECT_EQ(inside.entity_named("outside"), zone::ZoneContext(state(1)).entity_named("outside"));
    // The centre of the area is the origin of the copy's zone.
    const Vec3d corner(65.0, 0.0, 0.0);
    EXPECT_LT(
        (place_of(orb) - state(2).settings.region().origin() - (place_of(orb_outside) - corner))
            .norm(),
        1e-3);
    EXPECT_TRUE(inside.joint_named(EntityId(), "chain"));
    EXPECT_TRUE(inside.agent(inside.entity_named("boss")));
    std::vector<EntityId> on_altar;
    inside.inside("altar", on_altar);
    EXPECT_THAT(on_altar, ::testing::Contains(orb));
    ASSERT_EQ(state(2).settings.statics->boxes().size(), 1u);
    EXPECT_LT((state(2).settings.statics->boxes()[0].centre - Vec3(5.0F, 1.0F, 10.0F)).norm(),
              1e-3F);
}

TEST_F(Instances, ReceivePlayersAndSendThemBackToWhereTheyWere) {
    come(1);
    come(2);
    ticks(3);
    const Vec3d before = place_of(avatar(1));
    const zone::InstanceId crypt = open();
    told();
    enter(1, crypt);
    EXPECT_EQ(zone_of(avatar(1)), 2u);
    EXPECT_EQ(zone_of(avatar(2)), 1u);
    const Vec3d entrance = state(2).settings.region().origin() + Vec3d(-18.0, 0.0, 3.0);
    EXPECT_LT((place_of(avatar(1)) - entrance).cwiseProduct(Vec3d(1, 0, 1)).norm(), 2e-3);
    tick();
    EXPECT_THAT(told(), ElementsAre("2 entered"));
    tick_with(2, [](zone::RulesContext& c) {
        EXPECT_EQ(c.instances()->here(), zone::InstanceId(1));
        EXPECT_TRUE(c.instances()->leave(c, avatar(1)));
    });
    EXPECT_EQ(zone_of(avatar(1)), 1u);
    EXPECT_LT((place_of(avatar(1)) - before).norm(), 0.02);
    tick();
    EXPECT_THAT(told(), ElementsAre("2 left"));
}

TEST_F(Instances, KeepTheirPlayersFromHearingEachOther) {
    for (std::uint32_t client = 1; client <= 6; ++client) {
        come(client);
    }
    const zone::InstanceId a = open();
    const zone::InstanceId b = open();
    for (const std::uint32_t client : {1U, 2U}) {
        enter(client, a);
        enter(client + 2, b);
    }
    std::size_t pairs = 0;
    for (int t = 0; t < 200; ++t) {
        tick_with(2, [](zone::RulesContext& c) { c.announce(avatar(1), zone::RulesEvent()); });
        for (const mailbox::OutboxItem& item : out) {
            const auto* event = std::get_if<mailbox::EventOut>(&item);
            if (event != nullptr && event->kind >= zone::kFirstRulesEvent) {
                EXPECT_THAT(event->recipients, ElementsAre(ClientId(1), ClientId(2)));
            }
        }
        for (const auto& zone : world->zones()) {
            EXPECT_THAT(zone->state().ghost_ids, IsEmpty());
            for (const world::VisibleSet& set : zone->state().visibility) {
                for (const world::Visible& visible : set.visible) {
                    // Once the news of the way there is through.
                    EXPECT_TRUE(zone->owns(visible.entity) || t == 0);
                    ++pairs;
                }
            }
        }
    }
    EXPECT_GT(pairs, 4000u);
}

TEST_F(Instances, EndWhenEmptyAndBeginAnewAsPlaced) {
    come(1);
    const zone::InstanceId crypt = open();
    enter(1, crypt);
    ticks(60);  // longer than an empty one lasts
    EXPECT_NE(world->instances()->find(crypt), nullptr);
    EntityId orb;
    tick_with(2, [&](zone::RulesContext& c) {
        orb = c.entity_named("orb");
        c.teleport(orb, Vec3(3.0F, 0.3F, 3.0F));
        c.despawn(c.entity_named("boss"));
        zone::SpawnDef stray;
        stray.type = 1;
        stray.position = Vec3(1.0F, 0.3F, 1.0F);
        c.spawn(stray);
        c.start_timer(EntityId(), 1000.0, 5);
        EXPECT_TRUE(c.instances()->leave(c, avatar(1)));
    });
    told();
    ticks(39);
    EXPECT_NE(world->instances()->find(crypt), nullptr);
    ticks(4);
    EXPECT_THAT(told(), ElementsAre("2 left", "2 ends"));
    EXPECT_EQ(world->instances()->find(crypt), nullptr);
    EXPECT_EQ(state(2).entities.size(), 0u);
    EXPECT_TRUE(state(2).timers.empty());
    EXPECT_FALSE(zone::ZoneContext(state(2)).entity_named("orb"));
    const zone::InstanceId anew = open();
    EXPECT_NE(anew, crypt);
    EXPECT_EQ(state(2).entities.size(), 13u);
    const zone::ZoneContext inside(state(2));
    EXPECT_NE(inside.entity_named("orb"), orb);
    EXPECT_TRUE(inside.entity_named("boss"));
    const Vec3d local = place_of(inside.entity_named("orb")) - state(2).settings.region().origin();
    EXPECT_LT((local - Vec3d(-5.0, local.y(), 5.0)).norm(), 1e-3);
}

TEST_F(Instances, HaveMapsOfPathsWhileTheyAreOpen) {
    const auto mapped = [&] {
        std::vector<bool> zones;
        for (std::size_t zone = 1; zone <= 4; ++zone) {
            zones.push_back(!state(zone).paths.empty());
        }
        return zones;
    };
    EXPECT_THAT(mapped(), ElementsAre(true, false, false, false));
    come(1);
    const zone::InstanceId crypt = open();
    EXPECT_THAT(mapped(), ElementsAre(true, true, false, false));
    enter(1, crypt);  // an empty one ends
    // Its guard walks about its place, which lies in a box for a tenth.
    const EntityId boss = zone::ZoneContext(state(2)).entity_named("boss");
    const Vec3d before = place_of(boss);
    double way = 0.0;
    for (int i = 0; i < 600; ++i) {
        const Vec3d at = place_of(boss);
        tick();
        way += (place_of(boss) - at).norm();
    }
    EXPECT_GT(way, 10.0);
    EXPECT_LT((place_of(boss) - before).norm(), 12.0);
    EXPECT_GT(state(2).paths.counts().asked, 3u);
    tick_with(2, [&](zone::RulesContext& c) { EXPECT_TRUE(c.instances()->close(crypt)); });
    tick();
    EXPECT_THAT(mapped(), ElementsAre(true, false, false, false));
    open();
    EXPECT_THAT(mapped(), ElementsAre(true, true, false, false));
    EXPECT_LT(state(2).paths.counts().asked, 3u) << "it begins anew";
}

TEST_F(Instances, SendPlayersBackWhenRulesEndThem) {
    come(1);
    come(2);
    const zone::InstanceId a = open();
    const Vec3d before = place_of(avatar(1));
    enter(1, a);
    enter(2, a);
    tick_with(2, [&](zone::RulesContext& c) { EXPECT_TRUE(c.instances()->close(a)); });
    tick();
    EXPECT_EQ(zone_of(avatar(1)), 1u);
    EXPECT_EQ(zone_of(avatar(2)), 1u);
    EXPECT_LT((place_of(avatar(1)) - before).norm(), 0.02);
    EXPECT_EQ(state(2).entities.size(), 0u);
    // A player that walked from one to the other goes back to where it entered the first.
    const zone::InstanceId b = open();
    const zone::InstanceId c = open();
    enter(1, b);
    const auto from = static_cast<std::uint16_t>(zone_of(avatar(1)));
    enter(1, c, from);
    const auto to = static_cast<std::uint16_t>(zone_of(avatar(1)));
    EXPECT_NE(from, to);
    tick_with(to, [](zone::RulesContext& context) {
        EXPECT_TRUE(context.instances()->leave(context, avatar(1)));
    });
    EXPECT_LT((place_of(avatar(1)) - before).norm(), 0.02);
}

TEST_F(Instances, AreRefusedWhereNoneIsFreeOrKnown) {
    come(1);
    open();
    open();
    open();
    told();
    tick_with(1, [](zone::RulesContext& c) {
        EXPECT_TRUE(c.instances()->open("crypt", avatar(1)));
        EXPECT_FALSE(c.instances()->open("palace", avatar(1)));
        EXPECT_TRUE(c.instances()->close(zone::InstanceId(99)));
        EXPECT_FALSE(c.instances()->enter(c, avatar(1), zone::InstanceId(99), 0));
        EXPECT_FALSE(c.instances()->enter(c, EntityId(12345), zone::InstanceId(1), 0));
        EXPECT_FALSE(c.instances()->enter(c, c.entity_named("orb"), zone::InstanceId(1), 0));
        EXPECT_FALSE(c.instances()->leave(c, avatar(1)));
    });
    EXPECT_EQ(world->instances()->refused(), 2u);
    tick();
    EXPECT_THAT(told(), ElementsAre("1 refused", "1 refused"));
    std::size_t taken = 0;
    tick_with(1, [&](zone::RulesContext& c) {
        for (int i = 0; i < 5000; ++i) {
            taken += c.instances()->open("crypt", EntityId()) ? 1U : 0U;
        }
    });
    EXPECT_EQ(taken, zone::kMostInstanceOrders);
}

TEST_F(Instances, KeepNobodysLoginInThem) {
    const EntityId first = come(1);
    ticks(3);
    const Vec3d before = place_of(first);
    const zone::InstanceId crypt = open();
    enter(1, crypt);
    tick();
    const Vec3d inside = place_of(first);
    told();
    tick({mailbox::Leave{ClientId(1)}});
    // The store is told where it was outside.
    bool stored = false;
    for (const mailbox::StoreRequest& request : world->store_requests()) {
        if (request.act == mailbox::StoreAct::kStand) {
            stored = true;
            EXPECT_LT(
                (Vec3d(request.position[0], request.position[1], request.position[2]) - before)
                    .norm(),
                2e-3);
        }
    }
    EXPECT_TRUE(stored);
    tick();
    EXPECT_THAT(told(), ElementsAre("2 left"));
    mailbox::Join join;
    join.client = ClientId(9);
    join.placed = true;
    for (int axis = 0; axis < 3; ++axis) {
        join.spawn[axis] = inside[axis];
    }
    tick({join});
    EXPECT_EQ(zone_of(avatar(9)), 1u);
    for (std::uint32_t client = 10; client < 20; ++client) {
        EXPECT_EQ(zone_of(come(client)), 1u);  // entrances are nobody's spawn points
    }
}

TEST_F(Instances, DoNotOpenWhereAZoneHasStopped) {
    plain_log()->busy = true;
    plain_log()->each_tick = [](zone::RulesContext& context) {
        if (context.zone() == ZoneId(2)) {
            throw std::runtime_error("on purpose");
        }
    };
    tick();
    plain_log()->each_tick = nullptr;
    const zone::InstanceId crypt = open();
    EXPECT_EQ(world->instances()->find(crypt)->zone, ZoneId(3));
}

// ---- by a script ----

constexpr const char* kDungeonScript = R"lua(
function on_start() state.open = {} end
function on_command(client, avatar, kind, payload)
    if kind == 20 then open_instance('crypt', avatar) end
    if kind == 21 then enter_instance(avatar, #payload, #payload + 1) end
    if kind == 22 then leave_instance(avatar) end
    if kind == 23 then close_instance(#payload) end
    if kind == 24 and instance_here() then
        local orb = entity_named('orb')
        if orb and is_owned(orb) then entity_state(orb).kicks = 1 add_velocity(orb, 3, 4, 0) end
        start_timer(nil, 5, 1)
    end
end
function on_instance(event, instance, kind, player)
    state[event] = (state[event] or 0) + 1
    if event == 'ready' then enter_instance(player, instance) end
end
)lua";

TEST(InstanceScript, GoesOnFromSnapshotsWithAnyNumberOfThreads) {
    std::string script;
    for (const char* c = kDungeonScript; *c != '\0'; ++c) {
        script += *c == '\n' ? "\\n" : std::string(1, *c);
    }
    const config::Settings settings =
        dungeon_settings(std::string(kDungeon) + "script { text: \"" + script + "\" }\n");
    World original(settings, 1);
    World threaded(settings, 4);
    std::unique_ptr<World> copy;
    core::Rng rng(3);
    std::vector<mailbox::OutboxItem> out;
    std::map<zone::InstanceEvent, int> events;
    std::size_t most_open = 0;
    std::set<std::uint32_t> here;
    for (int tick = 0; tick < 1500; ++tick) {
        std::vector<mailbox::InboxItem> items;
        const std::uint32_t player = 1 + rng.below(8);
        if (!here.contains(player) || rng.below(100) == 0) {
            if (here.erase(player) > 0) {
                items.emplace_back(mailbox::Leave{ClientId(player)});
            } else {
                here.insert(player);
                mailbox::Join join;
                join.client = ClientId(player);
                items.emplace_back(join);
            }
        } else if (rng.below(4) == 0) {
            mailbox::Command command;
            command.client = ClientId(player);
            command.kind = static_cast<std::uint16_t>(20 + rng.below(5));
            const std::size_t open = original.instances()->open().size();
            const bool known = open > 0 && rng.below(4) != 0;
            command.payload.assign(known ? original.instances()
                                               ->open()[rng.below(static_cast<std::uint32_t>(open))]
                                               .id.value
                                         : rng.below(30),
                                   'x');
            items.emplace_back(command);
        }
        for (World* world : {&original, &threaded, copy.get()}) {
            if (world != nullptr) {
                out.clear();
                world->tick(items, out);
                ASSERT_EQ(world->instances()->unsound(), "");
                ASSERT_EQ(world->state_hash(), original.state_hash()) << "tick " << tick;
            }
        }
        most_open = std::max(most_open, original.instances()->open().size());
        for (const zone::InstanceChange& change : original.instances()->changes()) {
            ++events[change.event];
        }
        std::vector<std::uint8_t> bytes;
        if (tick % 100 >= 50 && (copy == nullptr || tick % 100 == 50) &&
            original.save(bytes).empty()) {
            copy = std::make_unique<World>(settings, 1);
            ASSERT_EQ(copy->load(bytes), "");
            std::vector<std::uint8_t> again;
            ASSERT_EQ(copy->save(again), "");
            ASSERT_EQ(bytes, again);
        }
    }
    EXPECT_NE(copy, nullptr);
    EXPECT_EQ(original.script_errors(), 0u);
    EXPECT_EQ(most_open, 3u);
    for (std::size_t event = 0; event < std::size(zone::kInstanceEventNames); ++event) {
        EXPECT_GT(events[static_cast<zone::InstanceEvent>(event)], 3)
            << zone::kInstanceEventNames[event];
    }
}

}  // namespace
}  // namespace zoned::app
