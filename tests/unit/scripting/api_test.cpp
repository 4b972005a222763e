// The functions of the host: what they do, and what they say of wrong arguments.
#include "tests/unit/scripting/script_zone.h"
#include "proto/sandbox.pb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace zoned::scripting::test {
namespace {

using rules::test::Channel;
using ::testing::HasSubstr;

TEST(ScriptApi, SpawnsMovesHidesAndShowsEntities) {
    ScriptZone zone(R"(function on_tick()
        local b = spawn('ball', 1, 2, 3, { vx = 4, appearance = 7 })
        print(type_of(b), appearance(b), position(b))
        print(velocity(b))
        print(teleport(b, 5, 6, 7), position(b))
        print(add_velocity(b, 1, 0, 0), velocity(b))
        print(hide(b), is_hidden(b), hide(b), teleport(b, 0, 0, 0), add_velocity(b, 1, 1, 1))
        print(show(b, 8, 9, 10), is_hidden(b), show(b, 0, 0, 0), position(b))
        print(set_appearance(b, 3), appearance(b), set_stance(b, 'running'))
        print(despawn(b), is_known(b), despawn(b), position(b))
    end)");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "ball 7 1.0 2.0 3.0|4.0 0.0 0.0|true 5.0 6.0 7.0|true 5.0 0.0 0.0|"
              "true true false false false|true false false 8.0 9.0 10.0|true 3 true|"
              "true false false nil");
}

TEST(ScriptApi, SetsAndReadsDeclaredFields) {
    ScriptZone zone(R"(function on_tick()
        local p = spawn('player', 0, 0, 0)
        print(field(p, 'health'), field(p, 'mood'), field(p, 'ready'), field(p, 'title'))
        print(set_field(p, 'health', 41.6), set_field(p, 'mood', 'angry'),
              set_field(p, 'ready', true), set_field(p, 'title', 'Ann'))
        print(field(p, 'health'), field(p, 'mood'), field(p, 'ready'), field(p, 'title'))
        print(set_field(p, 'health', -5), field(p, 'health'), set_field(p, 'health', 'much'),
              set_field(p, 'mood', 'bored'), set_field(p, 'title', ('x'):rep(32)),
              field(p, 'title'))
        local b = spawn('crate', 0, 0, 0)
        print(field(b, 'health'), set_field(b, 'health', 1), field(12345, 'health'))
    end)");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "100.0 calm false |true true true true|42.0 angry true Ann|"
              "true 0.0 false false false Ann|nil false nil");
}

TEST(ScriptApi, ChangesNothingOfOtherZones) {
    ScriptZone owner("", {}, 2);
    const EntityId theirs = owner.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    ScriptZone zone(
        "function on_tick() local b = near(0, 0, 0, 10)[1] "
        "print(is_known(b), is_owned(b), teleport(b, 0, 0, 0), despawn(b), hide(b), "
        "set_appearance(b, 1), "
        "announce(b, 100), entity_state(b)) message(b, 'hi') end "
        "function on_message(target, payload) print(target, payload) end");
    zone.show_ghost(owner, theirs);
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "true false false false false false nil nil");
    ASSERT_EQ(zone.outbox.size(), 1u);
    EXPECT_EQ(zone.outbox[0].target, theirs);
    zone.clear();
    zone.rules->on_message(zone, theirs, zone.outbox[0].payload);
    EXPECT_EQ(zone.printed(), std::to_string(theirs.value) + " hi");
}

TEST(ScriptApi, KeepsTheAvatarsOfClientsThatAreHere) {
    ScriptZone zone(
        "function on_join(c, a) print(despawn(a), client_of(a)) end "
        "function on_leave(c, a) print(despawn(a)) end");
    const EntityId avatar = zone.join(4);
    EXPECT_EQ(zone.printed(), "false 4");
    zone.columns().set_client(zone.columns().find(avatar), ClientId());
    zone.rules->on_leave(zone, ClientId(4), avatar);
    EXPECT_FALSE(zone.exists(avatar));
}

TEST(ScriptApi, DespawnsWhoLeavesWhereTheScriptDoesNotCare) {
    ScriptZone zone("function on_join(c, a) entity_state(a).n = 1 end");
    const EntityId avatar = zone.join(4);
    zone.columns().set_client(zone.columns().find(avatar), ClientId());
    zone.rules->on_leave(zone, ClientId(4), avatar);
    EXPECT_FALSE(zone.exists(avatar));
    EXPECT_TRUE(zone.rules->take_entity(avatar).empty());
}

TEST(ScriptApi, DespawnsWhoLeavesWhereTheScriptFails) {
    ScriptZone zone("function on_leave(c, a) error('oops') end");
    const EntityId avatar = zone.join(4);
    zone.columns().set_client(zone.columns().find(avatar), ClientId());
    zone.rules->on_leave(zone, ClientId(4), avatar);
    EXPECT_FALSE(zone.exists(avatar));
}

TEST(ScriptApi, MayHearIsBriefOrHearsNothing) {
    ScriptZone zone(
        "function may_hear() local n = 0 for i = 1, 5000 do n = n + 1 end return true end");
    const EntityId a = zone.join(1);
    EXPECT_FALSE(zone.rules->may_hear(zone, a, a));
    EXPECT_THAT(zone.errors(), HasSubstr("more instructions"));
}

TEST(ScriptApi, AsksTheWorld) {
    ScriptZone zone(R"(function on_tick()
        local a, b = spawn('ball', 0, 0, 0), spawn('crate', 3, 0, 4)
        print(distance(a, b), #near(0, 0, 0, 10), #near(0, 0, 0, 10, 'crate'), #near(0, 0, 0, 1))
        print(ray_cast(-5, 0, 0, 2, 0, 0, 100, 0) ~= nil, select('#', ray_cast(0, 50, 0, 0, 1, 0, 10)))
        local d, hit = ray_cast(-5, 0, 0, 1, 0, 0, 100)
        print(d, hit == a)
        print(now(), zone(), ticks(1), ticks(0), origin())
        print(orientation(a))
        print(yaw(a), is_at_rest(a), is_grounded(a), is_carried(a), client_of(a), shared_value('day'))
        print(particles_near('hail', 0, 0, 0, 5), distance(a, 999), position_after(a, 3))
    end)");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "5.0 2 1 1|true 1|5.0 true|100 1 30 1 0.0 0.0 0.0|1.0 0.0 0.0 0.0|"
              "0 false false false nil nil|0 nil nil");
}

TEST(ScriptApi, SendsPlayersToOtherWorlds) {
    ScriptZone zone(R"(function on_join(client, avatar)
        print(travel(client, 'meadow', 'gate'), travel(client, 'tower'), pcall(travel, client))
    end)");
    zone.join(9);
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.travels, (std::vector<std::string>{"9 meadow gate", "9 tower "}));
    EXPECT_TRUE(zone.printed().starts_with("true true false ")) << zone.printed();
}

TEST(ScriptApi, SendsEvents) {
    ScriptZone zone(R"(function on_join(client, avatar)
        send(client, 100, 'one', { confirm = true })
        publish('world', 101)
        announce(avatar, 102, 'three', { durable = true })
        subscribe(client, 'world') unsubscribe(client, 'world')
        reset_view(client) note_outcome(true)
    end
    function on_confirm(client, event) print(client, event) end)");
    const EntityId avatar = zone.join(9);
    EXPECT_EQ(zone.errors(), "");
    ASSERT_EQ(zone.sent.size(), 3u);
    EXPECT_EQ(zone.sent[0].client, ClientId(9));
    EXPECT_EQ(zone.sent[0].event.payload, (zone::Bytes{'o', 'n', 'e'}));
    EXPECT_TRUE(zone.sent[0].event.confirm);
    EXPECT_FALSE(zone.sent[0].event.durable);
    EXPECT_EQ(zone.sent[1].topic, "world");
    EXPECT_EQ(zone.sent[2].channel, Channel::kViewers);
    EXPECT_EQ(zone.sent[2].source, avatar);
    EXPECT_TRUE(zone.sent[2].event.durable);
    EXPECT_EQ(zone.topics, (std::vector<std::string>{"+9 world", "-9 world"}));
    EXPECT_EQ(zone.resets, std::vector<ClientId>{ClientId(9)});
    EXPECT_EQ(zone.outcomes, std::vector<bool>{true});
    zone.rules->on_confirm(zone, ClientId(9), EventId(77));
    EXPECT_EQ(zone.printed(), "9 77");
}

TEST(ScriptApi, StartsTimersAndStopsThem) {
    ScriptZone zone(R"(function on_start()
        state.late = start_timer(nil, 5, 9)
        print(start_timer(nil, 0.1, 7, 'bytes'), start_timer(nil, -1, 7))
        print(pcall(start_timer, nil, 1, 70000))
    end
    function on_timer(timer, entity, kind, payload)
        print(timer, entity, kind, payload)
        stop_timer(state.late)
    end)");
    EXPECT_TRUE(zone.printed().starts_with("2 nil|false ")) << zone.printed();
    zone.clear();
    zone.tick(3);
    EXPECT_EQ(zone.printed(), "");
    zone.tick(300);
    EXPECT_EQ(zone.printed(), "2 nil 7 bytes");
    EXPECT_EQ(zone.errors(), "");
}

TEST(ScriptApi, CommandsAgents) {
    ScriptZone zone(R"(function on_tick()
        local guard, ball = entity_named('the guard'), entity_named('nobody')
        print(guard, ball, agent_variable(guard, 'fear'), agent_variable(guard, 'x'), agent(99))
        print(set_agent_variable(guard, 'fear', 0.5), set_agent_variable(guard, 'x', 1))
        print(set_agent_home(guard, 1, 2, 3), set_agent_home(99, 1, 2, 3))
        local a = agent(guard)
        print(a.brain, a.state, a.action, a.target, a.x, a.y, a.z, agent_variable(guard, 'fear'))
    end)");
    const EntityId guard = zone.put(kPlayer, Vec3::Zero());
    zone.names["the guard"] = guard;
    zone.homes[guard] = Vec3::Zero();
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "1 nil 0.0 nil nil|true false|true false|guard watch stand nil 1.0 2.0 3.0 0.5");
}

TEST(ScriptApi, FormsPartiesAndHearsWhatBecomesOfThem) {
    ScriptZone zone(R"(
    function on_command(client, avatar, kind, payload)
        local other = tonumber(payload)
        if kind == 20 then print(party_invite(avatar, other)) end
        if kind == 21 then
            local party = party_invitations(avatar)[1]
            print(party_topic(party), party_accept(avatar, party), party_decline(avatar, 7))
        end
        if kind == 22 then
            local party = party_of(avatar)
            for _, m in ipairs(party_members(party)) do print(m.entity, m.client, m.name, m.zone, m.away) end
            print(set_party_value(party, 'goal', 'north'), party_value(party, 'goal'))
        end
        if kind == 23 then print(party_value(party_of(avatar), 'goal'), party_kick(avatar, other), party_promote(avatar, other)) end
        if kind == 24 then print(party_leave(other), party_disband(avatar), party_of(other)) end
    end
    function on_party(...) print(...) end)");
    zone.open_parties({});
    const EntityId a = zone.join(1);
    const EntityId b = zone.join(2);
    const std::string b_text = std::to_string(b.value);
    const auto told = [&] {
        zone.clear();
        for (const zone::PartyChange& change : zone.carry_out_party_orders()) {
            zone.rules->on_party(zone, change);
        }
        return zone.printed();
    };
    zone.command(1, a, 20, b_text);
    EXPECT_EQ(zone.printed(), "true");
    EXPECT_EQ(told(), "joined 1 1 nil name1 1 none|invited 1 5 1 name2 2 none");
    zone.command(2, b, 21, "");
    EXPECT_EQ(told(), "joined 1 5 nil name2 2 none|refused 7 5 nil  nil not_invited");
    zone.clear();
    zone.command(1, a, 22, "");
    EXPECT_EQ(zone.printed(), "1 1 name1 1 false|5 2 name2 1 false|true nil");
    EXPECT_EQ(told(), "");
    zone.command(2, b, 23, b_text);
    EXPECT_EQ(zone.printed(), "north true true");
    EXPECT_EQ(told(), "refused 1 5 5 name2 2 not_leader|refused 1 5 5 name2 2 not_leader");
    zone.clear();
    zone.command(1, a, 24, b_text);
    EXPECT_EQ(zone.printed(), "true true 1");
    EXPECT_EQ(told(),
              "left 1 5 nil name2 2 none|left 1 1 nil name1 1 none|ended 1 1 nil name1 nil none|"
              "refused 0 1 nil name1 1 no_party");
    EXPECT_EQ(zone.errors(), "");
}

TEST(ScriptApi, KnowsOfNoPartiesWhereTheConfigHasNone) {
    EXPECT_EQ(printed_by("print(party_of(1), party_members(1), #party_invitations(1), "
                         "party_value(1, 'x'), party_invite(1, 2), set_party_value(1, 'x', 'y'))"),
              "nil nil 0 nil false false");
}

TEST(ScriptApi, HearsOfTriggersAndAsksThem) {
    ScriptZone zone(R"(function on_trigger(trigger, entity, entered)
        print(trigger, entity, entered, #inside(trigger), #inside('none'))
    end)");
    zone.held["goal"] = {EntityId(5), EntityId(6)};
    zone.rules->on_trigger(zone, {"goal", EntityId(5), true});
    zone.rules->on_trigger(zone, {"gone", EntityId(6), false});
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "goal 5 true 2 0|gone 6 false 0 0");
}

TEST(ScriptApi, TellsZonesAndOperators) {
    ScriptZone zone(R"(function on_tick()
        message_zone(2, 'two') message_zone(nil, 'all')
        count('captures') count('captures', 2) gauge('alive', 3.5)
    end)");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    ASSERT_EQ(zone.zone_mail.size(), 2u);
    EXPECT_EQ(zone.zone_mail[0].first, ZoneId(2));
    EXPECT_EQ(zone.zone_mail[1].first, ZoneId());
    EXPECT_EQ(zone.zone_mail[1].second, (zone::Bytes{'a', 'l', 'l'}));
    EXPECT_EQ(zone.figures.at("captures"), 3.0);
    EXPECT_EQ(zone.figures.at("alive"), 3.5);
}

TEST(ScriptApi, AsksTheStore) {
    ScriptZone zone(R"(function on_tick()
        print(store_get(nil, 'best'), store_put(5, 'bag', 'bytes', 'anna'), store_get(5, 'bag', 'anna', 'hero'))
    end
    function on_store(request, status, value, key, account, character)
        print(request, status, value, key, account, character)
    end)");
    zone.tick();
    EXPECT_EQ(zone.printed(), "1 2 3");
    ASSERT_EQ(zone.asked.size(), 3u);
    EXPECT_EQ(zone.asked[0].key, (mailbox::StoreKey{mailbox::StoreScope::kWorld, "", "", "best"}));
    EXPECT_EQ(zone.asked[1].key,
              (mailbox::StoreKey{mailbox::StoreScope::kAccount, "anna", "", "bag"}));
    EXPECT_EQ(zone.asked[2].key,
              (mailbox::StoreKey{mailbox::StoreScope::kCharacter, "anna", "hero", "bag"}));
    EXPECT_EQ(zone.asked[1].target, EntityId(5));
    zone.clear();
    mailbox::StoreAnswer answer;
    answer.number = 3;
    answer.status = mailbox::StoreStatus::kAbsent;
    answer.key = zone.asked[2].key;
    zone.rules->on_store(zone, answer);
    EXPECT_EQ(zone.printed(), "3 absent  bag anna hero");
}

TEST(ScriptApi, GivesEachCallbackItsArguments) {
    ScriptZone zone(R"(
    function on_join(client, avatar, name, team, account) print(client, avatar, name, team, account) end
    function on_command(client, avatar, kind, payload) print(client, avatar, kind, #payload, payload:byte(1, -1)) end
    function on_input(avatar, x, z, buttons, pressed, yaw, pitch) print(avatar, x, z, buttons, pressed, yaw, pitch) end
    function on_contact(a, b, speed, impulse, x, y, z, began, ended) print(a, b, speed, impulse, x, y, z, began, ended) end
    function on_joint_broken(joint, a, b, root, name, force) print(joint, a, b, root, name, force) end)");
    const EntityId avatar = zone.join(2);
    zone.command(2, avatar, 40, std::string_view("\0\xff", 2));
    motion::InputCommand input;
    input.move_x = 127;
    input.move_z = -127;
    input.yaw = 9;
    input.pitch = -5;
    input.buttons = 3;
    zone.rules->on_input(zone, avatar, input, 1);
    zone::EntityContact contact;
    contact.b = avatar;
    contact.approach_speed = 2.0F;
    contact.began = true;
    zone.rules->on_contact(zone, contact);
    zone.rules->on_joint_broken(
        zone, {zone::EntityJointId(4), EntityId(), avatar, EntityId(), "rope", 8.0F});
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "2 1 name2 red account|2 1 40 2 0 255|1 1.0 -1.0 3 1 9 -5|nil 1 2.0 0.0 0.0 0.0 0.0 "
              "true false|"
              "4 nil 1 nil rope 8.0");
}

TEST(ScriptApi, AsksWhoMayHearAndLetsNothingChangeThen) {
    ScriptZone zone(R"(function on_join(c, a) entity_state(a).team = c end
    function may_hear(viewer, entity)
        local theirs = entity_state(entity)
        if theirs.team == 3 then state.x = 1 end
        return entity_state(viewer).team == theirs.team
    end)");
    const EntityId a = zone.join(1);
    const EntityId b = zone.join(2);
    const EntityId c = zone.join(3);
    zone::Bytes before;
    ASSERT_TRUE(zone.rules->save(before));
    EXPECT_TRUE(zone.rules->may_hear(zone, a, a));
    EXPECT_FALSE(zone.rules->may_hear(zone, a, b));
    EXPECT_FALSE(zone.rules->may_hear(zone, a, c));
    EXPECT_THAT(zone.errors(), HasSubstr("may_hear and on_stop change nothing"));
    EXPECT_EQ(zone.rules->errors(), 0u);
    zone::Bytes after;
    ASSERT_TRUE(zone.rules->save(after));
    EXPECT_EQ(after, before);
    ScriptZone without("");
    EXPECT_TRUE(without.rules->may_hear(without, a, b));
}

TEST(ScriptApi, ReadsTheContactsThatAreWishedFor) {
    ScriptZone zone("contact_wish = { ball = { lasts = true }, crate = { ends = true } }");
    EXPECT_TRUE(zone.rules->contact_wish(kBall).lasts);
    EXPECT_FALSE(zone.rules->contact_wish(kBall).ends);
    EXPECT_TRUE(zone.rules->contact_wish(kCrate).ends);
    EXPECT_FALSE(zone.rules->contact_wish(kPlayer).lasts);
    EXPECT_THAT(refusal_of("contact_wish = { dragon = {} }"), HasSubstr("'dragon'"));
}

struct WrongCall {
    const char* call;
    const char* error;
};

TEST(ScriptApi, NamesTheFunctionAndTheArgumentThatIsWrong) {
    for (const WrongCall& wrong : {
             WrongCall{"teleport(1, 'x', 0, 0)",
                       "#2 to 'teleport' (position: a number is wanted, not string)"},
             WrongCall{"teleport(1, 0/0, 0, 0)", "#2 to 'teleport' (position: a finite number"},
             WrongCall{"teleport(1, 0, 1e30, 0)", "#3 to 'teleport' (position: a finite number"},
             WrongCall{"teleport({}, 0, 0, 0)",
                       "#1 to 'teleport' (entity: an integer is wanted, not table)"},
             WrongCall{"teleport(-1, 0, 0, 0)",
                       "#1 to 'teleport' (entity: an integer from 0 to 4294967295"},
             WrongCall{"add_velocity(1, 1/0, 0, 0)", "#2 to 'add_velocity' (velocity:"},
             WrongCall{"spawn('dragon', 0, 0, 0)", "#1 to 'spawn' (type: the world has none"},
             WrongCall{"spawn('ball', 0, 0, 0, { speed = 1 })",
                       "#5 to 'spawn' (it has no setting 'speed')"},
             WrongCall{"spawn('ball', 0, 0, 0, { appearance = 70000 })",
                       "appearance: an integer from 0 to 65535"},
             WrongCall{"near(0, 0, 0)", "#4 to 'near' (radius: a number is wanted, not no value)"},
             WrongCall{"near(0, 0, 0, -1)", "#4 to 'near' (radius: it is negative)"},
             WrongCall{"ray_cast(0, 0, 0, 0, 0, 0, 1)",
                       "#4 to 'ray_cast' (direction: it has no length)"},
             WrongCall{"send(1, 3)", "#2 to 'send' (kind: an integer from 16 to 65535"},
             WrongCall{"send(0, 16)", "#1 to 'send' (client: nobody)"},
             WrongCall{"send(1, 16, ('x'):rep(20000))",
                       "#3 to 'send' (payload: at most 16384 bytes"},
             WrongCall{"send(1, 16, 7)", "#3 to 'send' (payload: a string is wanted, not number)"},
             WrongCall{"publish('', 16)", "#1 to 'publish' (topic: readable text is wanted"},
             WrongCall{"publish('\\255', 16)", "#1 to 'publish' (topic: readable text is wanted"},
             WrongCall{"set_stance(1, 'dancing')",
                       "#2 to 'set_stance' (stance: the world has none"},
             WrongCall{"set_field(1, 'stamina', 1)",
                       "#2 to 'set_field' (field: no type declares one of that name"},
             WrongCall{"field(1, 'stamina')",
                       "#2 to 'field' (field: no type declares one of that name"},
             WrongCall{"set_field(1, 'health', nil)",
                       "#3 to 'set_field' (value: a number, true, false or a string is wanted"},
             WrongCall{"emit('dust', 0, 0, 0, 0, 0, 0, 5000)",
                       "#8 to 'emit' (count: an integer from 1 to 1000"},
             WrongCall{"note_outcome(1)",
                       "#1 to 'note_outcome' (player_succeeded: true or false is wanted"},
             WrongCall{"math.random(0)", "#1 to 'random' (most: an integer from 1"},
             WrongCall{"store_put(1, 'k', 'v', nil, 'hero')", "#4 to 'store_put' (account:"},
             WrongCall{"decode('', 'x')", "#2 to 'decode' (schema: fields read like"},
             WrongCall{"encode(1, '1 int x')", "#1 to 'encode' (fields: a table is wanted)"},
             WrongCall{"set_motor_target(1.5, 1)",
                       "#1 to 'set_motor_target' (joint: an integer is wanted"},
             WrongCall{"apply_force(1, 1, 1, 1/0, 0, 0, 0)",
                       "#4 to 'apply_force' (force: a finite number"},
         }) {
        EXPECT_THAT(error_of(wrong.call), HasSubstr(wrong.error)) << wrong.call;
    }
}

TEST(ScriptApi, SaysWhatIsWrongWithPartiesArguments) {
    EXPECT_THAT(error_of("party_members('x')"), HasSubstr("party"));
    EXPECT_THAT(error_of("party_members(-1)"), HasSubstr("party"));
    EXPECT_THAT(error_of("party_invite(1, 'x')"), HasSubstr("other"));
    EXPECT_THAT(error_of("set_party_value(1, 'k', ('x'):rep(257))"), HasSubstr("value"));
}

TEST(ScriptChance, IsTheZones) {
    ScriptZone zone(
        "function on_tick() print(math.random(1, 6), math.random(3), math.random()) end");
    core::Rng expected = zone.rng();
    zone.tick();
    const std::uint32_t die = 1 + expected.below(6);
    const std::uint32_t three = 1 + expected.below(3);
    const std::string start = std::to_string(die) + " " + std::to_string(three) + " 0.";
    EXPECT_EQ(zone.printed().substr(0, start.size()), start);
}

TEST(ScriptMessages, ReadAndWriteTheMessagesOfClients) {
    sandbox::Shoot shoot;
    shoot.set_tick(123456789);
    shoot.set_dx(0.5F);
    shoot.set_dz(-1.0F);
    shoot.mutable_seen()->set_tick(5);
    ScriptZone zone(R"(function on_command(client, avatar, kind, payload)
        local shot = decode(payload, '1 int tick, 2 float dx, 3 float dy, 4 float dz, 40 bytes seen')
        if not shot then print('malformed') return end
        print(shot.tick, shot.dx, shot.dy, shot.dz, decode(shot.seen, '2 int tick').tick)
        send(client, 100, encode({ items = { 1, 300, 70000 } }, '1 ints items'))
        send(client, 101, encode({ a = 7, t = true, x = 2.5, s = -3, b = 'hi' },
                                 '1 int a, 2 bool t, 3 float x, 4 sint s, 5 bytes b, 6 int missing'))
    end)");
    zone.command(1, EntityId(1), 2, shoot.SerializeAsString());
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "123456789 0.5 0.0 -1.0 5");
    ASSERT_EQ(zone.sent.size(), 2u);
    const auto inventory = FakeContext::parse<sandbox::Inventory>(zone.sent[0]);
    EXPECT_EQ((std::vector<std::uint32_t>(inventory.items().begin(), inventory.items().end())),
              (std::vector<std::uint32_t>{1, 300, 70000}));
    const zone::Bytes expected{
        0x08, 7, 0x10, 1, 0x1D, 0, 0, 0x20, 0x40, 0x20, 5, 0x2A, 2, 'h', 'i'};
    EXPECT_EQ(zone.sent[1].event.payload, expected);
    zone.clear();
    zone.command(1, EntityId(1), 2, "\xff\xff");
    zone.command(1, EntityId(1), 2, "\x08");
    zone.command(1, EntityId(1), 2, "\x0d\x01");
    zone.command(1, EntityId(1), 2, "\x0a\x7f");
    EXPECT_EQ(zone.printed(), "malformed|malformed|malformed|malformed");
}

TEST(Places, AreSpawnPointsByTeam) {
    ScriptZone zone(R"(
        function on_tick()
          for _, point in ipairs(spawn_points('red')) do
            print(point.name, point.team, point.x, point.y, point.z)
          end
          print(#spawn_points(), #spawn_points('green'))
          print(freest_spawn('blue'))
        end)");
    zone.spawns = {{Vec3d(1, 2, 3), "gate", "red"},
                   {Vec3d(4, 5, 6), "tower", "blue"},
                   {Vec3d(7, 8, 9), "", ""}};
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "gate red 1.0 2.0 3.0|3 0|4.0 5.0 6.0 tower");
}

TEST(Places, AreEntitiesByTypeAndPropertiesOfTypes) {
    ScriptZone zone(R"(
        function on_tick()
          local balls = entities('ball')
          print(#entities(), #balls, type_of(balls[1]), type_of(balls[2]), balls[1] < balls[2])
          print(#entities('guard'))
          local ball, player = type_properties('ball'), type_properties('player')
          print(ball.kind, ball.mass, ball.size_x == 2 * ball.radius, ball.speed)
          print(player.kind, player.mass, player.speed, player.sprint_speed, player.name)
          print(type_properties('dragon'))
        end)");
    zone.put(kBall, Vec3::Zero());
    zone.put(kCrate, Vec3::Zero());
    zone.put(kBall, Vec3::Zero());
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(),
              "3 2 ball ball true|0|prop 2.0 true nil|character 80.0 5.0 8.0 player|nil");
}

TEST(Places, TellAStanceThatWasSet) {
    ScriptZone zone(R"(
        function on_join(client, avatar)
          print(stance(avatar))
          set_stance(avatar, 'running')
          print(stance(avatar), stance(999))
        end)");
    zone.join(1);
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "normal|running nil");
}

TEST(Fields, AreDeclaredByAScriptInItsOrder) {
    const ScriptZone zone(R"(fields = {
        { type = 'ball', name = 'heat', kind = 'number', min = -1, max = 1, quantum = 0.5, initial = 0.5 },
        { type = 'player', name = 'side', kind = 'choice', values = { 'left', 'right' }, initial = 'right',
          max_changes_per_s = 4 },
        { type = 'ball', name = 'lit', kind = 'flag', initial = true },
        { type = 'ball', name = 'label', kind = 'text', initial = 'a' },
    })");
    const std::vector<zone::TypeField> fields = zone.rules->declared_fields();
    ASSERT_EQ(fields.size(), 4u);
    EXPECT_EQ(fields[0].type, "ball");
    EXPECT_EQ(fields[0].field.name, "heat");
    EXPECT_EQ(fields[0].field.minimum, -1.0);
    EXPECT_EQ(fields[0].field.most, 4u);
    EXPECT_EQ(fields[0].field.initial[0], 3u);
    EXPECT_EQ(fields[1].field.values, (std::vector<std::string>{"left", "right"}));
    EXPECT_EQ(fields[1].field.initial[0], 1u);
    EXPECT_EQ(fields[1].max_changes_per_s, 4.0);
    EXPECT_EQ(fields[2].field.initial[0], 1u);
    EXPECT_TRUE(wire::FieldSchema::make({fields[0].field, fields[2].field, fields[3].field}).ok());
}

TEST(Fields, OfAnotherFormAreErrorsOfTheScript) {
    const auto refused = [](const std::string& field) {
        try {
            const ScriptZone zone("fields = " + field);
        } catch (const std::runtime_error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(refused("7").find("a list of tables is wanted"), std::string::npos);
    EXPECT_NE(refused("{ 7 }").find("a list of tables is wanted"), std::string::npos);
    EXPECT_NE(refused("{ { name = 'a', kind = 'colour' } }").find("not 'colour'"),
              std::string::npos);
    EXPECT_NE(refused("{ { name = 7, kind = 'flag' } }").find("'name' is no text"),
              std::string::npos);
    EXPECT_NE(refused("{ { kind = 'number', max = 'x' } }").find("'max' is no number"),
              std::string::npos);
    EXPECT_NE(refused("{ { kind = 'choice' } }").find("a choice has values"), std::string::npos);
}

}  // namespace
}  // namespace zoned::scripting::test
