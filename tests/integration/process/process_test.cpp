#include "tests/integration/process/fixture.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace zoned::testing_process {
namespace {

TEST_F(Process, PlaysOverRealSocketsToAConsistentVerdictAndStopsOnSigterm) {
    const std::string server_report = scratch_folder() + "/server.json";
    const std::string client_report = scratch_folder() + "/client.json";
    const auto server = start_server({"--report", server_report});
    std::vector<std::string> arguments = play(6, 3);
    arguments.insert(arguments.end(), {"--report", client_report});
    Child client("client-sim", arguments);
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    EXPECT_NE(client.output().find("verdict: consistent"), std::string::npos) << client.output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    EXPECT_NE(read(server_report).find("\"sessions_max\": 6"), std::string::npos)
        << read(server_report);
    for (const char* field : {"bots_asked",
                              "bots_joined",
                              "position_error_m_p50",
                              "bound_violations",
                              "missing_entities",
                              "extra_entities",
                              "events_delivered",
                              "event_spread_ms_p99",
                              "input_to_remote_display_ms_p50",
                              "rtt_ms_p99",
                              "clock_error_ms_p99",
                              "verdict",
                              "reasons"}) {
        EXPECT_NE(read(client_report).find("\"" + std::string(field) + "\""), std::string::npos)
            << field;
    }
}

TEST_F(Process, TellsItsClientsWhyItCloses) {
    const auto server = start_server();
    Child client("client-sim", play(2, 30));
    EXPECT_TRUE(server->wait(2.0) == -1);
    server->signal(SIGINT);
    EXPECT_EQ(server->wait(kPatience), 0);
    // The run was cut short: the verdict is a failure, and its reason names the server's farewell.
    EXPECT_EQ(client.wait(kPatience), 1) << client.output();
    EXPECT_NE(client.output().find("server closes"), std::string::npos) << client.output();
}

TEST_F(Process, RecordsARunThatReplaysToTheSameHashesWithAnyNumberOfThreads) {
    const std::string file = scratch_folder() + "/run.zrec";
    const auto server = start_server({"--set", "recording.file=\"" + file + "\""});
    Child client("client-sim", play(4, 2));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    server->signal(SIGTERM);
    ASSERT_EQ(server->wait(kPatience), 0);
    for (const char* threads : {"1", "2", "4"}) {
        Child replay("zoned", {"replay", file, "--threads", threads});
        EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    }
    // A replay that could not fail would be worthless: one changed byte must show up.
    std::string bytes = read(file);
    bytes[bytes.size() * 3 / 4] = static_cast<char>(bytes[bytes.size() * 3 / 4] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
    Child damaged("zoned", {"replay", file});
    EXPECT_NE(damaged.wait(kPatience), 0);
}

TEST_F(Process, ReadsBrainsAnewAndReplaysTheRun) {
    const std::string folder = scratch_folder();
    const std::string config = folder + "/hamlet.txtpb";
    const std::string recording = folder + "/run.zrec";
    const std::string hamlet = read(ZONED_SOURCE_DIR "/config/hamlet.txtpb");
    const auto write = [&config](const std::string& text) {
        std::ofstream(config, std::ios::trunc) << text;
    };
    const auto with = [&hamlet](const std::string& from, const std::string& to) {
        const std::size_t at = hamlet.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        std::string text = hamlet;
        return text.replace(at, from.size(), to);
    };
    write(hamlet);
    Child server("zoned",
                 {"serve",
                  "--config",
                  config,
                  "--set",
                  state_set(),
                  "--set",
                  "recording.file=\"" + recording + "\""});
    ASSERT_TRUE(server.wait_for_output("ready ", kPatience)) << server.errors();
    const auto reload_until = [&server](const std::string& words) {
        server.signal(SIGHUP);
        EXPECT_TRUE(server.wait_for_errors(words, kPatience)) << server.errors();
    };
    // Watchmen stroll instead of walking their round.
    write(with("state { name: \"walk\" action: PATROL", "state { name: \"walk\" action: WANDER"));
    reload_until("PATROL -> WANDER");
    write(with("to: \"stand\" threshold: 20", "to: \"stood\" threshold: 20"));
    reload_until("no state named 'stood'");
    write(with("spawn { x_m: -20", "spawn { x_m: -21"));
    reload_until("waits for a restart: spawn[0].x_m -20 -> -21");
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(kPatience), 0) << server.errors();
    Child replay("zoned", {"replay", recording, "--threads", "2"});
    EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos);
    EXPECT_NE(read(recording).find("WANDER"), std::string::npos);
}

TEST_F(Process, RefusesToReplayOverSurfacesThatChanged) {
    const std::string config = ZONED_SOURCE_DIR "/config";
    const std::string folder = scratch_folder() + "/hills";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    std::filesystem::copy(config + "/hills.txtpb", folder);
    std::filesystem::copy(
        config + "/geometry", folder + "/geometry", std::filesystem::copy_options::recursive);
    const std::string recording = folder + "/run.zrec";
    auto server = std::make_unique<Child>("zoned",
                                          std::vector<std::string>{"serve",
                                                                   "--config",
                                                                   folder + "/hills.txtpb",
                                                                   "--set",
                                                                   state_set(),
                                                                   "--set",
                                                                   "recording.file=run.zrec"});
    ASSERT_TRUE(server->wait_for_output("ready ", kPatience)) << server->errors();
    tcp_port = number_after(server->output(), "tcp=");
    Child client("client-sim", play(4, 2));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    server->signal(SIGTERM);
    ASSERT_EQ(server->wait(kPatience), 0);
    for (const char* threads : {"1", "2"}) {
        Child replay("zoned", {"replay", recording, "--threads", threads});
        EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    }
    // A bowl with one corner a centimetre higher is another world.
    std::string bowl = read(folder + "/geometry/bowl.obj");
    const std::size_t at = bowl.find("v 0 0.3 0");
    ASSERT_NE(at, std::string::npos);
    bowl.replace(at, 9, "v 0 0.31 0");
    std::ofstream(folder + "/geometry/bowl.obj", std::ios::binary) << bowl;
    Child changed("zoned", {"replay", recording});
    EXPECT_EQ(changed.wait(kPatience), 2);
    EXPECT_NE(changed.errors().find("bowl.obj has another content"), std::string::npos)
        << changed.errors();
    std::filesystem::remove(folder + "/geometry/bowl.obj");
    Child missing("zoned", {"replay", recording});
    EXPECT_EQ(missing.wait(kPatience), 2);
    EXPECT_NE(missing.errors().find("bowl.obj: cannot be opened"), std::string::npos)
        << missing.errors();
}

TEST_F(Process, SaysWhichPortIsInUse) {
    const auto server = start_server();
    Child second("zoned",
                 {"serve",
                  "--config",
                  minimal(),
                  "--set",
                  state_set(),
                  "--set",
                  "network.tcp_port=" + std::to_string(tcp_port)});
    EXPECT_EQ(second.wait(kPatience), 3);
    EXPECT_NE(second.errors().find(std::to_string(tcp_port)), std::string::npos) << second.errors();
    EXPECT_NE(second.errors().find("another program uses the port"), std::string::npos);
}

TEST_F(Process, ReportsEveryMistakeOfAConfigAndExitsWithTwo) {
    const std::string file = scratch_folder() + "/bad.txtpb";
    std::ofstream(file)
        << "world { tick_rate_hz: 9999 }\nspawn { x_m: 0 z_m: 0 }\nlod { }\nno_such_field: 1\n";
    Child check("zoned", {"check", file});
    EXPECT_EQ(check.wait(kPatience), 2);
    EXPECT_NE(check.errors().find(":1:"), std::string::npos) << check.errors();
    EXPECT_NE(check.errors().find(":4:"), std::string::npos) << check.errors();
}

TEST_F(Process, LogsStabilityWarningsOnce) {
    const auto server = start_server({"--set", "physics.substeps=1"});
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    const std::string warning = "physics: the step is too long for contacts";
    const std::size_t at = server->errors().find(warning);
    ASSERT_NE(at, std::string::npos) << server->errors();
    EXPECT_EQ(server->errors().find(warning, at + 1), std::string::npos) << server->errors();
}

TEST_F(Process, NamesACertificateThatIsMissing) {
    Child server("zoned",
                 {"serve",
                  "--config",
                  minimal(),
                  "--set",
                  "session.tls_certificate_file=\"/nonexistent/cert.pem\"",
                  "--set",
                  "session.tls_key_file=\"/nonexistent/key.pem\""});
    const int code = server.wait(kPatience);
    EXPECT_TRUE(code == 2 || code == 3) << code;
    EXPECT_NE(server.errors().find("/nonexistent/cert.pem"), std::string::npos) << server.errors();
}

TEST_F(Process, SaysThatAHostCannotBeReached) {
    Child client("client-sim", {"--connect", "127.0.0.1:1", "--bots", "1", "--seconds", "1"});
    EXPECT_EQ(client.wait(kPatience), 3) << client.output();
    EXPECT_NE(client.errors().find("127.0.0.1:1"), std::string::npos) << client.errors();
}

TEST_F(Process, LetsInWhoHoldsATicketAndNobodyElse) {
    const std::string base = scratch_folder() + "/operator";
    Child keygen("zoned", {"keygen", base});
    ASSERT_EQ(keygen.wait(kPatience), 0) << keygen.errors();
    Child ticket("zoned",
                 {"ticket",
                  "--key",
                  base + ".key",
                  "--account",
                  "ann",
                  "--right",
                  "play",
                  "--right",
                  "audit",
                  "--out",
                  base + ".ticket"});
    ASSERT_EQ(ticket.wait(kPatience), 0) << ticket.errors();
    const auto server = start_server({"--set",
                                      "session.dev_mode_loopback=false",
                                      "--set",
                                      "session.ticket_public_key_file=\"" + base + ".pub\""});
    Child stranger("client-sim", play(1, 1));
    EXPECT_NE(stranger.wait(kPatience), 0) << stranger.output();
    std::vector<std::string> arguments = play(1, 3);
    arguments.insert(arguments.end(), {"--ticket", base + ".ticket"});
    Child ann("client-sim", arguments);
    EXPECT_EQ(ann.wait(kPatience), 0) << ann.output() << ann.errors();
}

TEST_F(Process, ExplainsThePlanAndShowsHelp) {
    Child explain("zoned", {"explain", minimal(), "--ticks", "5"});
    EXPECT_EQ(explain.wait(kPatience), 0) << explain.errors();
    EXPECT_NE(explain.output().find("no viewer"), std::string::npos) << explain.output();
    EXPECT_NE(explain.output().find("soft bodies: nothing to choose: no soft type"),
              std::string::npos)
        << explain.output();
    Child cloth("zoned", {"explain", ZONED_SOURCE_DIR "/config/cloth.txtpb", "--ticks", "5"});
    EXPECT_EQ(cloth.wait(kPatience), 0) << cloth.errors();
    EXPECT_NE(cloth.output().find("soft type curtain: "), std::string::npos) << cloth.output();
    EXPECT_NE(cloth.output().find("more than 0.02"), std::string::npos) << cloth.output();
    Child help("zoned", {"--help"});
    EXPECT_EQ(help.wait(kPatience), 0);
    Child nonsense("zoned", {"serve", "--no-such-option"});
    EXPECT_EQ(nonsense.wait(kPatience), 2);
}

/// Numbers of the line of `text` that begins with `name`, in order.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t at = line.find_first_not_of(' ');
        if (at != std::string::npos && line.compare(at, name.size(), name) == 0) {
            std::istringstream rest(line.substr(at + name.size()));
            std::vector<double> out;
            for (double number = 0.0; rest >> number;) {
                out.push_back(number);
            }
            return out;
        }
    }
    return {};
}

TEST_F(Process, ExplainsWhatIsExpectedBesideWhatHappens) {
    Child analysis("zoned", {"explain", minimal(), "--analyze", "--seconds", "2", "--bots", "4"});
    EXPECT_EQ(analysis.wait(kPatience), 0) << analysis.errors();
    const std::string text = analysis.output();
    ASSERT_NE(text.find("expected beside actual, over 60 ticks"), std::string::npos) << text;
    const std::string after = text.substr(text.find("expected beside actual"));
    for (const char* name : {"cost", "downlink", "level 0 position", "level 0 orientation"}) {
        const std::vector<double> found = numbers_of(after, name);
        ASSERT_GE(found.size(), 3U) << name << "\n" << after;
        EXPECT_GT(found[0], 0.0) << name;
        EXPECT_GT(found[1], 0.0) << name;
        EXPECT_NEAR(found[2], found[1] / found[0], 0.02 + 0.05 * found[2]) << name;
        if (std::string(name) != "cost") {  // a cost is a time, and the machine is shared
            EXPECT_GT(found[2], 0.5) << name;
            EXPECT_LT(found[2], 2.0) << name;
        }
    }
    // Walkers turn, so their views miss by the whole bound, and by no more.
    const std::vector<double> position = numbers_of(after, "level 0 position");
    EXPECT_GT(position[1], 0.025);
    EXPECT_LT(position[1], 0.05 + 0.01);
    EXPECT_EQ(after.find("MORE"), std::string::npos) << after;
}

TEST_F(Process, ExplainsWhatOtherBudgetsWouldChange) {
    Child budget("zoned",
                 {"explain",
                  minimal(),
                  "--set",
                  "lod[0].position_bound_m=",
                  "--set",
                  "lod[1].position_bound_m=",
                  "--set",
                  "budget.position_m=0.04",
                  "--set",
                  "budget.cpu_us_per_tick=1",
                  "--bots",
                  "4"});
    EXPECT_EQ(budget.wait(kPatience), 0) << budget.errors();
    const std::string text = budget.output();
    for (const char* words : {"position: sag ",
                              "physics.error_budget_m: ",
                              "chosen",
                              "lod[0].position_bound_m: ",
                              "MORE than budget.cpu_us_per_tick 1",
                              "0.5 x: cost ",
                              "2 x: cost ",
                              " -> "}) {
        EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
    }
    Child refused("zoned", {"explain", minimal(), "--set", "budget.position_m=0.04"});
    EXPECT_EQ(refused.wait(kPatience), 2);
    EXPECT_NE(refused.errors().find("leaves nothing of budget.position_m"), std::string::npos)
        << refused.errors();
}

}  // namespace
}  // namespace zoned::testing_process
