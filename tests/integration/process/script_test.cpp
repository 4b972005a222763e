// Rules in Lua as users run them: a server, a script, real sockets.
#include "tests/integration/process/fixture.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

namespace zoned::testing_process {
namespace {

class Scripted : public Process {
  protected:
    /// The arena's world with another script.
    static std::string world_with(const std::string& script) {
        const std::string folder = scratch_folder();
        std::filesystem::create_directories(folder + "/scripts");
        std::ofstream(folder + "/scripts/arena.lua") << script;
        std::ofstream(folder + "/arena.txtpb") << read(arena());
        return folder + "/arena.txtpb";
    }

    static std::string arena() { return ZONED_SOURCE_DIR "/config/arena.txtpb"; }
};

TEST_F(Scripted, PlaysTheArenaToAConsistentVerdictAndReplaysToTheSameHashes) {
    const std::string file = scratch_folder() + "/run.zrec";
    const std::string report = scratch_folder() + "/client.json";
    const auto server = start_server({"--set", "recording.file=\"" + file + "\""}, arena());
    std::vector<std::string> arguments = play(16, 6);
    arguments.insert(
        arguments.end(),
        {"--behaviour", "fight:4,chat:2,border:3,trade:1,wander:2", "--report", report});
    Child client("client-sim", arguments);
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    EXPECT_NE(client.output().find("verdict: consistent"), std::string::npos) << client.output();
    EXPECT_GT(number_after(read(report), "\"events_delivered\": "), 100);
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    EXPECT_EQ(server->errors().find("error in"), std::string::npos) << server->errors();
    for (const char* threads : {"1", "2"}) {
        Child replay("zoned", {"replay", file, "--threads", threads});
        EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    }
}

TEST_F(Scripted, SaysWhatIsLeftToSayWhenTheServerEnds) {
    const std::string config = world_with(
        "function on_start() store_get(nil, 'ends') end\n"
        "function on_store(request, status, value) print('found', status, value) end\n"
        "function on_stop()\n"
        "  print('the end of zone', zone(), store_put(nil, 'ends', 'well'))\n"
        "  print(pcall(function() state.x = 1 end))\n"
        "end\n");
    for (const char* found : {"found absent", "found done well"}) {
        const auto server = start_server({}, config);
        std::this_thread::sleep_for(std::chrono::milliseconds(500));  // the answer comes
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
        EXPECT_NE(server->errors().find(found), std::string::npos) << server->errors();
        EXPECT_NE(server->errors().find("the end of zone 2 0"), std::string::npos)
            << server->errors();
        EXPECT_NE(server->errors().find("false"), std::string::npos) << "it may change nothing";
    }
}

TEST_F(Scripted, GoesOnWhateverAScriptDoes) {
    const auto server =
        start_server({},
                     world_with("function on_start() state.n = 0 end\n"
                                "function on_command() while true do end end\n"
                                "function on_input(avatar)\n"
                                "  state.n = state.n + 1\n"
                                "  if state.n % 7 == 0 then local s = ('x'):rep(1 << 30) end\n"
                                "  if state.n % 11 == 0 then state.none.x = 1 end\n"
                                "end\n"));
    Child client("client-sim", play(6, 4));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    EXPECT_NE(client.output().find("verdict: consistent"), std::string::npos) << client.output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    for (const char* error : {"arena.lua:5: ", "arena.lua:6: attempt to index a nil value"}) {
        EXPECT_NE(server->errors().find(error), std::string::npos) << server->errors();
    }
}

TEST_F(Scripted, ReadsTheScriptAnewBetweenTwoTicksAndReplaysTheRun) {
    const auto script = [](const std::string& word) {
        return "function on_start() state.n = 0 end\n"
               "function on_tick()\n"
               "  state.n = state.n + 1\n"
               "  if state.n % 10 == 0 then print('" +
               word + "', state.n // 10 > 0) end\nend\n";
    };
    const std::string recording = scratch_folder() + "/run.zrec";
    const std::string config = world_with(script("before"));
    const auto server = start_server({"--set", "recording.file=\"" + recording + "\""}, config);
    Child client("client-sim", play(4, 8));
    const auto wait_for = [&server](const std::string& words) {
        EXPECT_TRUE(server->wait_for_errors(words, kPatience)) << server->errors();
    };
    wait_for("arena.lua: before true");
    world_with("function on_tick(\n");
    server->signal(SIGHUP);
    wait_for("arena.lua:2: ");
    world_with(script("after"));
    server->signal(SIGHUP);
    wait_for("script.text");
    // The state went on: the new script never started.
    wait_for("arena.lua: after true");
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    server->signal(SIGTERM);
    ASSERT_EQ(server->wait(kPatience), 0) << server->errors();
    for (const char* threads : {"1", "2"}) {
        Child replay("zoned", {"replay", recording, "--threads", threads});
        EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
        EXPECT_NE(replay.output().find("after true"), std::string::npos) << replay.output();
    }
}

TEST_F(Scripted, CheckNamesFileAndLine) {
    const auto check = [](const std::string& config) {
        Child child("zoned", {"check", config});
        EXPECT_EQ(child.wait(kPatience), 2);
        return child.errors();
    };
    const std::string syntax = check(world_with("function on_tick()\n  x = = 1\nend\n"));
    EXPECT_NE(syntax.find("arena.lua:2: unexpected symbol"), std::string::npos) << syntax;
    const std::string endless = check(world_with("while true do end\n"));
    EXPECT_NE(endless.find("arena.lua:1: "), std::string::npos) << endless;
    const std::string kept = check(world_with("local n = 0\nfunction on_tick() n = n + 1 end\n"));
    EXPECT_NE(kept.find("arena.lua:2: writes to 'n'"), std::string::npos) << kept;
    const std::string config = world_with("");
    std::filesystem::remove(std::filesystem::path(config).parent_path() / "scripts/arena.lua");
    const std::string missing = check(config);
    EXPECT_NE(missing.find("script.file"), std::string::npos) << missing;
}

}  // namespace
}  // namespace zoned::testing_process
