// The state of a script outlives interpreters, handoffs and replays, and is hashed.
#include "tests/unit/scripting/script_zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace zoned::scripting::test {
namespace {

using ::testing::HasSubstr;

/// A little game that uses each kind of value, chance and time.
constexpr const char* kGame = R"(
function on_start()
  state.round = 1
  state.best = { name = 'nobody', score = 0.5 }
  state.list = {}
end
function on_join(client, avatar, name)
  local own = entity_state(avatar)
  own.name, own.score, own.alive = name, 0, true
end
function on_tick()
  keep_awake(1)
  for _, avatar in ipairs(avatars()) do
    local own = entity_state(avatar)
    own.score = own.score + math.random(10)
    if own.score > state.best.score then
      state.best = { name = own.name, score = own.score, at = { position(avatar) } }
    end
    if math.random() < 0.1 then add_velocity(avatar, math.random() - 0.5, 1, 0) end
  end
  state.list[#state.list + 1] = state.best.score
  if #state.list > 20 then table.remove(state.list, 1) end
  if now() % 50 == 0 then state.list = nil state.list = {} state.round = state.round + 1 end
  if now() % 37 == 0 then error('now and then') end
end
)";

std::vector<std::uint64_t> play(ScriptZone& zone, int restart_every) {
    std::vector<std::uint64_t> hashes;
    zone.join(1, Vec3(1.0F, 0.0F, 0.0F));
    zone.join(2, Vec3(5.0F, 0.0F, 0.0F));
    for (int tick = 1; tick <= 300; ++tick) {
        zone.tick();
        hashes.push_back(zone.hash());
        if (restart_every != 0 && tick % restart_every == 0) {
            zone.restart();
        }
    }
    return hashes;
}

TEST(ScriptState, HashesTheSameOverRestartsOfTheInterpreterEveryFewTicks) {
    ScriptZone straight(kGame);
    const std::vector<std::uint64_t> expected = play(straight, 0);
    EXPECT_GT(straight.rules->errors(), 3u);
    for (const int every : {1, 7, 50}) {
        ScriptZone restarted(kGame);
        EXPECT_EQ(play(restarted, every), expected) << every;
    }
}

TEST(ScriptState, RestartsWithAHashThatIsStillDue) {
    ScriptZone a(kGame);
    ScriptZone b(kGame);
    for (ScriptZone* zone : {&a, &b}) {
        zone->join(1);
        zone->tick(3);
    }
    b.restart();
    EXPECT_EQ(a.hash(), b.hash());
}

TEST(ScriptState, ChangesItsHashWithEachKindOfValueAndPlace) {
    const std::string before =
        "function on_join() state.a = {b = {c = 1}} state.n = 1 end function on_tick() ";
    std::set<std::uint64_t> seen;
    for (const char* change : {"",
                               "state.n = 2",
                               "state.n = 1.0",
                               "state.n = '1'",
                               "state.n = true",
                               "state.n = nil",
                               "state.n = {}",
                               "state.a.b.c = 2",
                               "state.a.b.d = 1",
                               "state.a.b = nil",
                               "state[1] = 1",
                               "state['1'] = 1",
                               "entity_state(1).n = 1"}) {
        ScriptZone zone(before + change + " end");
        zone.join(1);
        core::StateHash settled;
        zone.rules->hash(settled);
        zone.tick();
        core::StateHash hash;
        zone.rules->hash(hash);
        EXPECT_TRUE(seen.insert(hash.value()).second) << change;
    }
}

TEST(ScriptState, IsUsedLikeTables) {
    const auto shown = [](const std::string& statements) {
        return printed_by(statements);
    };
    EXPECT_EQ(
        shown("state.a = {1, 2, x = 'y'} print(#state.a, state.a[2], state.a.x, state.a.nope)"),
        "2 2 y nil");
    EXPECT_EQ(shown("state.a = {5, 4} for i, v in ipairs(state.a) do print(i, v) end"), "1 5|2 4");
    EXPECT_EQ(shown("state.z, state[2], state[-1], state.b = 1, 2, 3, 4 for k, v in pairs(state) "
                    "do print(k, v) end"),
              "-1 3|2 2|b 4|z 1");
    EXPECT_EQ(shown("state.l = {} for i = 1, 5 do table.insert(state.l, i * i) end "
                    "table.remove(state.l, 2) "
                    "table.sort(state.l, function(a, b) return a > b end) "
                    "print(table.concat(state.l, ' '))"),
              "25 16 9 1");
    EXPECT_EQ(
        shown(
            "state.l = {1, 2, 3} state.l[2] = nil print(#state.l) state.l[2] = 5 print(#state.l)"),
        "1|3");
    EXPECT_EQ(shown("state.a = {} print(state.a == state.a, state.a == state, state.a ~= state.a)"),
              "true false false");
    EXPECT_EQ(
        shown("state.a = {b = 1} for k in pairs(state.a) do state.a[k] = nil end print(#state.a)"),
        "0");
    EXPECT_EQ(shown("state.a = 3.0 state[4.0] = 'four' print(state.a, state[4])"), "3.0 four");
}

TEST(ScriptState, CopiesWhatIsPutIntoIt) {
    EXPECT_EQ(printed_by("local t = {n = 1} state.a = t t.n = 2 print(state.a.n)"), "1");
    EXPECT_EQ(
        printed_by("state.a = {n = 1} state.b = state.a state.b.n = 2 print(state.a.n, state.b.n)"),
        "1 2");
    EXPECT_EQ(printed_by("state.a = {b = {n = 7}} state.a = state.a.b print(state.a.n)"), "7");
}

TEST(ScriptState, KeepsNothingThatHasNoBytes) {
    EXPECT_THAT(error_of("state.f = print"), HasSubstr("a function cannot be kept"));
    EXPECT_THAT(error_of("state[{}] = 1"), HasSubstr("keys are strings or integers, not table"));
    EXPECT_THAT(error_of("state[1.5] = 1"), HasSubstr("keys are strings or integers"));
    EXPECT_THAT(error_of("state.t = {[true] = 1}"), HasSubstr("keys are strings or integers"));
    EXPECT_THAT(error_of("state.a = {} local a = state.a state.a = nil a.x = 1"),
                HasSubstr("taken out of the state"));
}

TEST(ScriptState, OfAnEntityGoesWithItToAnotherZone) {
    const char* source =
        "function on_join(client, avatar) entity_state(avatar).bag = {'ball', 'crate', n = 2} end "
        "function on_tick() for _, a in ipairs(avatars()) do local own = entity_state(a) "
        "print(own.bag and own.bag[2]) end end";
    ScriptZone from(source, {}, 1);
    ScriptZone to(source, {}, 2);
    const EntityId avatar = from.join(1);
    const zone::Bytes bytes = from.rules->take_entity(avatar);
    const world::Row row = to.columns().add(avatar, kPlayer);
    to.columns().set_client(row, ClientId(1));
    to.rules->load_entity(avatar, bytes);
    to.tick();
    EXPECT_EQ(to.printed(), "crate");
    from.tick();
    EXPECT_EQ(from.printed(), "nil");
    EXPECT_TRUE(from.rules->take_entity(EntityId(77)).empty());
}

TEST(ScriptState, OfAnEntityIsNilForOthersAndGoneWithIt) {
    ScriptZone zone(
        "function on_tick() local b = spawn('ball', 0, 0, 0) entity_state(b).n = 1 "
        "print(entity_state(b).n, despawn(b), entity_state(b), entity_state(999)) end");
    zone.tick();
    EXPECT_EQ(zone.printed(), "1 true nil nil");
    zone::Bytes bytes;
    ASSERT_TRUE(zone.rules->save(bytes));
    EXPECT_LT(bytes.size(), 200u);
}

TEST(ScriptState, RefusesDamagedBytesWithoutHarm) {
    ScriptZone zone(kGame);
    zone.join(1);
    zone.tick(40);
    zone::Bytes bytes;
    ASSERT_TRUE(zone.rules->save(bytes));
    core::Rng rng(5);
    int refused = 0;
    for (int i = 0; i < 2000; ++i) {
        zone::Bytes damaged = bytes;
        if (i % 2 == 0) {
            damaged.resize(rng.below(static_cast<std::uint32_t>(damaged.size())));
        } else {
            damaged[rng.below(static_cast<std::uint32_t>(damaged.size()))] ^=
                static_cast<std::uint8_t>(1 + rng.below(255));
        }
        ScriptZone other(kGame);
        refused += other.rules->load(damaged).empty() ? 0 : 1;
        other.rules->load_entity(EntityId(1), damaged);
    }
    EXPECT_GT(refused, 1000);
}

TEST(ScriptState, KeepsAZoneAwakeAsLongAsItAsks) {
    ScriptZone zone("function on_join() keep_awake(0.2) end");
    EXPECT_FALSE(zone.rules->busy());
    zone.join(1);
    EXPECT_TRUE(zone.rules->busy());
    zone.restart();
    EXPECT_TRUE(zone.rules->busy());
    zone.pass_tick();
    zone.tick(7);
    EXPECT_FALSE(zone.rules->busy());
}

TEST(ScriptState, StartsOnceInAZonesLife) {
    ScriptZone zone("function on_start() print('start') end function on_tick() print('tick') end");
    zone.tick();
    zone.restart();
    zone.tick();
    EXPECT_EQ(zone.printed(), "start|tick|tick");
}

}  // namespace
}  // namespace zoned::scripting::test
