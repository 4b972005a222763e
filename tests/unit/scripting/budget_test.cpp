// Traps that a script sets for the tick: each ends its call, and the zone goes on.
#include "tests/unit/scripting/script_zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

namespace zoned::scripting::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// CPU time of a call, s.
template <class Work>
double seconds_of(Work&& work) {
    const std::clock_t begin = std::clock();
    work();
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

struct Trap {
    const char* name;
    const char* statements;
    const char* error;
};

class Traps : public ::testing::TestWithParam<Trap> {};

TEST_P(Traps, EndTheCallSoonAndTheNextTickRuns) {
    ScriptZone zone(std::string("function on_tick() if state.sprung then print('alive') return end "
                                "state.sprung = true ") +
                    GetParam().statements + " end");
    EXPECT_LT(seconds_of([&] { zone.tick(); }), 0.5);
    EXPECT_EQ(zone.rules->errors(), 1u);
    EXPECT_THAT(zone.errors(), HasSubstr(GetParam().error));
    EXPECT_THAT(zone.errors(), HasSubstr("game.lua:1"));
    zone.tick();
    EXPECT_EQ(zone.printed(), "alive");
}

INSTANTIATE_TEST_SUITE_P(
    Script,
    Traps,
    ::testing::Values(
        Trap{"loop", "while true do end", "more instructions"},
        Trap{"swallowed",
             "while true do pcall(function() while true do end end) end",
             "more instructions"},
        Trap{"swallowed_twice",
             "pcall(pcall, function() while true do end end) while true do end",
             "more instructions"},
        Trap{"recursion", "local function f() return 1 + f() end f()", "more instructions"},
        Trap{"memory", "local t = {} while true do t[#t + 1] = {{}, {}, {}, {}} end", "more"},
        Trap{"swallowed_memory",
             "local t = {} pcall(function() for i = 1, 1e9 do t[i] = {i, {i}, {i}} end end) while "
             "true do t[#t + 1] = {} end",
             "more"},
        Trap{"rep", "local s = string.rep('x', 1 << 28)", "64 KiB"},
        Trap{"rep_overflow", "local s = ('xx'):rep(math.maxinteger)", "64 KiB"},
        Trap{"doubling", "local s = 'x' while true do s = s .. s end", "64 KiB"},
        Trap{"copying", "local s = ('x'):rep(60000) while true do local t = s .. 'y' end", "more"},
        Trap{"comparing",
             "local a, b = ('x'):rep(60000), ('x'):rep(59999) .. 'x' while a == b do end",
             "more instructions"},
        Trap{"format_width", "string.format('%99999999d', 1)", "4096"},
        Trap{"pack_size", "string.pack('c1000000000', '')", "4096"},
        Trap{"unpack", "table.unpack({}, 1, 1e8)", "250"},
        Trap{
            "insert_front",
            "local t = {} for i = 1, 20000 do t[i] = i end while true do table.insert(t, 1, 0) end",
            "work"},
        Trap{"sort",
             "local t = {} for i = 1, 20000 do t[i] = i % 7 end while true do table.sort(t) end",
             "work"},
        Trap{"sort_by_chance",
             "local t = {} for i = 1, 5000 do t[i] = i end table.sort(t, function() return "
             "math.random() < 0.5 end) while true do end",
             "more instructions"},
        Trap{"concat",
             "local t = {} for i = 1, 5000 do t[i] = 'xxxxxxxx' end while true do table.concat(t) "
             "end",
             "work"},
        Trap{"state", "while true do state[#state + 1] = 'x' end", "more instructions"},
        Trap{"state_texts",
             "local s = ('x'):rep(60000) for i = 1, 1000 do state[i] = s end",
             "script.state_mb"},
        Trap{"state_depth", "local t = {} t.t = t state.t = t", "deep"},
        Trap{"state_in_itself", "state.a = {} for i = 1, 30 do state.a.b = state end", "deep"},
        Trap{"rays", "while true do ray_cast(0, 0, 0, 1, 0, 0, 100) end", "work"},
        Trap{"pairs",
             "local t = {} for i = 1, 9000 do t[i] = i end while true do pairs(t) end",
             "work"},
        Trap{"varargs", "local function f(...) return f(1, ...) end f()", ""},
        Trap{"long_numbers", "local s = ('1'):rep(60000) while true do tonumber(s) end", "work"},
        Trap{"long_numbers_in_math",
             "local s = ('1'):rep(60000) while true do math.floor(s) end",
             "work"},
        Trap{"emptied",
             "local t = {} for i = 1, 20000 do t[i] = i end for i = 1, 20000 do t[i] = nil end "
             "while true do pairs(t) end",
             "work"},
        Trap{"error_table", "error({})", "no text"},
        Trap{"error_nil", "error(nil)", "no text"},
        Trap{"plain", "local t = nil; t.x = 1", "attempt to index a nil value"}),
    [](const auto& trap) { return trap.param.name; });

TEST(ScriptBudget, EndsRecursionBeforeTheStackOverflows) {
    ScriptSettings settings;
    settings.limits.instructions_per_call = 100'000'000;
    EXPECT_THAT(error_of("local function f() return 1 + f() end f()", settings),
                HasSubstr("more memory"));
    settings.limits.memory_bytes = 100U << 20U;
    EXPECT_THAT(error_of("local function f() return 1 + f() end f()", settings),
                HasSubstr("stack overflow"));
    EXPECT_EQ(printed_by("local depth = 0 local function f() depth = depth + 1 pcall(f) end f() "
                         "print(depth > 50 and depth < 250)"),
              "true");
}

TEST(ScriptBudget, LetsNothingRunAfterAnOverrunThatPcallCaught) {
    ScriptZone zone(
        "function on_tick() pcall(function() while true do "
        "ray_cast(0, 0, 0, 1, 0, 0, 100) end end) state.after = true end "
        "function on_join() print(state.after) end");
    zone.tick();
    EXPECT_EQ(zone.rules->errors(), 1u);
    zone.join(1);
    EXPECT_EQ(zone.printed(), "nil");
}

TEST(ScriptBudget, IsTheSameNumberOfInstructionsOnEveryRun) {
    const std::string source =
        "function on_tick() state.n = 0 while true do state.n = state.n + 1 end end";
    ScriptZone a(source);
    ScriptZone b(source);
    a.tick(3);
    b.tick(3);
    EXPECT_EQ(a.hash(), b.hash());
    EXPECT_EQ(a.rules->errors(), 3u);
}

TEST(ScriptBudget, OfATickStopsFurtherCallsUntilTheNext) {
    ScriptSettings settings;
    settings.limits.instructions_per_call = 50'000;
    settings.limits.instructions_per_tick = 100'000;
    ScriptZone zone(
        "function on_input() local x = 0 for i = 1, 10000 do x = x + i end state.n = (state.n or "
        "0) + 1 end "
        "function on_tick() print(state.n) end "
        "function on_join() print('join') end",
        settings);
    const EntityId avatar = zone.put(kPlayer, Vec3::Zero());
    for (int i = 0; i < 20; ++i) {
        zone.rules->on_input(zone, avatar, {}, 0);
    }
    EXPECT_THAT(zone.errors(), HasSubstr("script.instructions_per_tick"));
    zone.join(1);
    EXPECT_EQ(zone.printed(), "join");
    zone.pass_tick();
    zone.clear();
    zone.tick();
    EXPECT_NE(zone.printed(), "");
    EXPECT_NE(zone.printed(), "20");
}

TEST(ScriptBudget, RefusesStateBeyondItsMemoryAndKeepsTheRest) {
    ScriptSettings settings;
    settings.limits.state_bytes = 100'000;
    ScriptZone zone("function on_tick() for i = 1, 1000 do state[i] = ('x'):rep(500) end end",
                    settings);
    zone.tick();
    EXPECT_THAT(zone.errors(), HasSubstr("script.state_mb"));
    ScriptZone other("function on_tick() state.text = ('x'):rep(60000) state.text = nil end",
                     settings);
    other.tick(50);
    EXPECT_EQ(other.errors(), "");
}

TEST(ScriptErrors, AreCountedAndLoggedOncePerPlaceWithTheCallsThatLedThere) {
    ScriptZone zone(
        "local function inner()\n error('oops')\nend\nfunction on_tick()\n inner()\nend");
    zone.tick(5);
    EXPECT_EQ(zone.rules->errors(), 5u);
    EXPECT_EQ(zone.rules->errors(Callback::kTick), 5u);
    EXPECT_THAT(zone.errors(), HasSubstr("error in on_tick: game.lua:2: oops\nstack traceback:"));
    EXPECT_THAT(zone.errors(), HasSubstr("game.lua:5: in function"));
    EXPECT_THAT(zone.errors(), Not(HasSubstr("|")));
}

TEST(ScriptErrors, MuteTheCallbackThatFailsWhereTheConfigSaysSo) {
    ScriptSettings settings;
    settings.errors_allowed = 3;
    settings.on_errors = ErrorPolicy::kMute;
    ScriptZone zone(
        "function on_tick() state.n = (state.n or 0) + 1 error('oops') end "
        "function on_join() print(state.n) end",
        settings);
    zone.tick(10);
    zone.join(1);
    EXPECT_EQ(zone.printed(), "4");
}

TEST(ScriptErrors, StopTheZoneWhereTheConfigSaysSo) {
    ScriptSettings settings;
    settings.errors_allowed = 2;
    settings.on_errors = ErrorPolicy::kStopZone;
    ScriptZone zone("function on_tick() error('oops') end", settings);
    zone.tick(2);
    EXPECT_THROW(zone.tick(), std::runtime_error);
}

TEST(ScriptErrors, KeepWhatWasDoneBeforeThem) {
    ScriptZone zone(
        "function on_tick() state.before = true error('oops') end "
        "function on_join() print(state.before) end");
    zone.tick();
    zone.join(1);
    EXPECT_EQ(zone.printed(), "true");
}

}  // namespace
}  // namespace zoned::scripting::test
