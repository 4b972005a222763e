// Things that a script can reach, and those that it cannot.
#include "tests/unit/scripting/script_zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::scripting::test {
namespace {

using ::testing::HasSubstr;

TEST(ScriptFile, IsRefusedWithItsLineWhereItDoesNotCompileOrRun) {
    EXPECT_THAT(refusal_of("x = 1\ny = = 2"), HasSubstr("game.lua:2:"));
    EXPECT_THAT(refusal_of("x = 1\n\nerror('no')"), HasSubstr("game.lua:3: no"));
    EXPECT_THAT(refusal_of("while true do end"), HasSubstr("more instructions"));
    EXPECT_THAT(refusal_of("x = string.rep('x', 1 << 30)"), HasSubstr("64 KiB"));
    EXPECT_THAT(refusal_of("function on_tik() end"), HasSubstr("no callback 'on_tik'"));
    EXPECT_THAT(refusal_of("on_tick = 3"), HasSubstr("'on_tick' is no function"));
    EXPECT_THAT(refusal_of(std::string("\x1bLua\x54", 5)), HasSubstr("binary"));
    EXPECT_EQ(refusal_of(""), "");
}

TEST(ScriptFile, NeedsTheTypeOfTheAvatars) {
    ScriptSettings settings;
    settings.avatar = "crate";
    EXPECT_THAT(refusal_of("", settings), HasSubstr("script.avatar"));
    settings.avatar = "ghost";
    EXPECT_THAT(refusal_of("", settings), HasSubstr("'ghost'"));
}

TEST(ScriptFile, MayNotWriteToLocalsThatOutliveTheCall) {
    EXPECT_THAT(refusal_of("local n = 0\nfunction on_tick()\n n = n + 1\nend"),
                HasSubstr("game.lua:3: writes to 'n'"));
    EXPECT_THAT(
        refusal_of("local n = 0\nfunction on_tick()\n local f = function() n = 1 end f()\nend"),
        HasSubstr("game.lua:3: writes to 'n'"));
    EXPECT_THAT(
        refusal_of("local function counter() local n = 0\n return function() n = n + 1 end end\n"
                   "local count = counter()\nfunction on_tick() count() end"),
        HasSubstr("game.lua:2: writes to 'n'"));
    EXPECT_THAT(refusal_of("local t = { f = function() end }\nfunction on_tick() _ENV = {} end"),
                HasSubstr("writes to '_ENV'"));
    EXPECT_EQ(
        refusal_of("function on_tick() local n = 0 local f = function() n = n + 1 end f() end"),
        "");
    EXPECT_EQ(
        refusal_of("local n = 0\nfor i = 1, 3 do n = n + i end\nfunction on_tick() print(n) end"),
        "");
}

TEST(ScriptFile, MayNotRaiseToPowers) {
    EXPECT_THAT(refusal_of("function on_tick()\n local x = now()\n print(x ^ 0.3)\nend"),
                HasSubstr("game.lua:3: '^' differs"));
    EXPECT_THAT(refusal_of("function on_tick()\n print(now() ^ now())\nend"),
                HasSubstr("game.lua:2: '^'"));
}

TEST(ScriptFile, CannotTouchTheWorldWhileItRuns) {
    EXPECT_THAT(refusal_of("state.x = 1"), HasSubstr("use on_start"));
    EXPECT_THAT(refusal_of("x = state.x"), HasSubstr("use on_start"));
    EXPECT_THAT(refusal_of("spawn('ball', 0, 0, 0)"), HasSubstr("use on_start"));
    EXPECT_THAT(refusal_of("x = math.random()"), HasSubstr("use on_start"));
}

TEST(ScriptGlobals, AreReadOnlyOnceTheFileHasRun) {
    EXPECT_THAT(error_of("x = 1"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("on_join = nil"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("math.pi = 3"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("string.rep = print"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("settings.greeting = 'bye'"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("table.insert(math, 1)"), HasSubstr("read-only"));
    EXPECT_THAT(error_of("print(undefined_name)"), HasSubstr("no global 'undefined_name'"));
    for (const char* write :
         {"list[1] = 0", "list[9] = 0", "inner.deep.x = 1", "upvalue.n = 1", "table.sort(list)"}) {
        ScriptZone zone(
            std::string("list = {3, 2, 1} inner = {deep = {x = 0}} local upvalue = {n = 0} "
                        "function on_tick() print(upvalue.n) ") +
            write + " end");
        zone.tick();
        EXPECT_THAT(zone.errors(), HasSubstr("read-only")) << write;
    }
}

TEST(ScriptGlobals, ReadAsBeforeOnceTheFileHasRun) {
    ScriptZone zone(
        "list = {3, 2, 1, n = {4, 5}} "
        "function on_tick() print(#list, list[1], #list.n, table.concat(list, '-'), select('#', "
        "table.unpack(list))) "
        "for i, v in ipairs(list) do print(i, v) end for k in pairs(list) do print(k) end end");
    zone.tick();
    EXPECT_EQ(zone.errors(), "");
    EXPECT_EQ(zone.printed(), "3 3 2 3-2-1 3|1 3|2 2|3 1|1|2|3|n");
}

TEST(ScriptLibraries, HoldNothingThatReachesOut) {
    for (const char* name :
         {"io",           "os",     "debug",    "package",   "require",        "load",
          "loadstring",   "dofile", "loadfile", "coroutine", "collectgarbage", "setmetatable",
          "getmetatable", "rawset", "rawget",   "next",      "xpcall",         "utf8",
          "_G",           "warn"}) {
        EXPECT_THAT(error_of(std::string("print(") + name + ")"),
                    HasSubstr(std::string("no global '") + name))
            << name;
    }
    for (const char* name : {"dump", "gsub", "gmatch", "match"}) {
        EXPECT_EQ(printed_by(std::string("print(string.") + name + ")"), "nil") << name;
    }
    for (const char* name : {"sin", "cos", "tan", "exp", "log", "randomseed", "pow"}) {
        EXPECT_EQ(printed_by(std::string("print(math.") + name + ")"), "nil") << name;
    }
    EXPECT_EQ(printed_by("print(('x').gsub, ('').rep == string.rep)"), "nil true");
}

TEST(ScriptLibraries, ShowNoAddresses) {
    EXPECT_EQ(printed_by("print({}, print, function() end, state)"),
              "table function function table");
    EXPECT_EQ(printed_by("print(tostring({}), string.format('%s %s', {}, print))"),
              "table table function");
    EXPECT_THAT(error_of("string.format('%5p', {})"), HasSubstr("addresses"));
    EXPECT_THAT(error_of("string.format('%d%% %p', 1, {})"), HasSubstr("addresses"));
    EXPECT_EQ(printed_by("print(pcall(string.format, 'x%5'))").substr(0, 5), "false");
}

TEST(ScriptLibraries, GoThroughTablesInOrder) {
    EXPECT_EQ(
        printed_by(
            "local t = {} for _, k in ipairs{'b', 'a', 'ab', 2, 10, 1, 1.5, true} do t[k] = 1 end "
            "for k in pairs(t) do print(k) end"),
        "1|2|10|1.5|a|ab|b|true");
    EXPECT_EQ(
        printed_by(
            "local t = {a = 1, b = 2, c = 3} for k in pairs(t) do t.b = nil t.d = 4 print(k) end"),
        "a|c");
    EXPECT_THAT(error_of("local t = {} t[{}] = 1 pairs(t)"), HasSubstr("no order"));
    EXPECT_THAT(error_of("local t = {} t[print] = 1 pairs(t)"), HasSubstr("no order"));
}

TEST(ScriptLibraries, SortStablyWhateverTheOrderSays) {
    EXPECT_EQ(
        printed_by("local t = {} for i = 1, 500 do t[i] = {i % 3, i} end "
                   "table.sort(t, function(a, b) return a[1] < b[1] end) "
                   "local good = true for i = 2, 500 do local a, b = t[i - 1], t[i] "
                   "good = good and (a[1] < b[1] or a[1] == b[1] and a[2] < b[2]) end print(good)"),
        "true");
    EXPECT_EQ(printed_by("local t = {3, 1, 2} table.sort(t) print(table.concat(t, ' ')) "
                         "table.sort(t, function() return true end) print(#t)"),
              "1 2 3|3");
    EXPECT_THAT(error_of("table.sort({1, 'x'})"), HasSubstr("compare"));
}

TEST(ScriptLibraries, HandleTextsAndLists) {
    EXPECT_EQ(
        printed_by("print(('abc'):find('x'), ('abab'):find('ab', 2)) print(('a.b'):find('.'))"),
        "nil 3 4|2 2");
    EXPECT_EQ(printed_by("print(table.concat(('a b  c'):split(' '), '|'))"), "a|b||c");
    EXPECT_EQ(printed_by("print(('hello'):byte(1, -1))"), "104 101 108 108 111");
    EXPECT_EQ(printed_by("print(('hello'):byte(-1), ('ab'):rep(3, '-'), ('Ab'):upper())"),
              "111 ab-ab-ab AB");
    EXPECT_EQ(printed_by("print(string.unpack('<I4z', string.pack('<I4z', 7, 'seven')))"),
              "7 seven 11");
    EXPECT_EQ(printed_by("local t = {1, 2, 4} table.insert(t, 3, 3) print(table.remove(t, 1), "
                         "table.concat(t, ' '))"),
              "1 2 3 4");
    EXPECT_EQ(printed_by("print(string.format('%5.2f %d %s %q', 1.5, 3, 'x', 'y'))"),
              " 1.50 3 x \"y\"");
    EXPECT_EQ(
        printed_by("print(math.sqrt(2) * math.sqrt(2) > 2, 7 // 2, 7 % -3, math.floor(-1.5))"),
        "true 3 -2 -2");
    EXPECT_EQ(printed_by("print(type(state), type({}), type(nil), type(print))"),
              "table table nil function");
    EXPECT_EQ(printed_by("print(pcall(error, 'x'))"), "false x");
    EXPECT_EQ(printed_by("print(settings.greeting)"), "hello");
}

}  // namespace
}  // namespace zoned::scripting::test
