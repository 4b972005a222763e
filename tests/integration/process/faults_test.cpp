// Faults of a running server: rules that throw, a process that dies, a world that is large to tell,
// a config that its rules refuse. Each leaves what an operator needs to find its cause.
#include "tests/integration/process/admin_fixture.h"

#include <csignal>
#include <filesystem>
#include <sstream>
#include <tuple>

namespace zoned::testing_process {
namespace {

/// Two zones side by side; players appear in both.
const char* const kTwoZones = R"(
zones {
  zone { name: "west" min_x_m: -50 min_z_m: -50 max_x_m: 0 max_z_m: 50 }
  zone { name: "east" min_x_m: 0 min_z_m: -50 max_x_m: 50 max_z_m: 50 }
  ghost_margin_m: 115
}
)";

class Faulty : public Admin {
  protected:
    /// The minimal world in two zones, with more settings.
    void serve_two(const std::string& more, const std::vector<std::string>& sets = {}) {
        std::string text = read(minimal());
        const std::string grid = "zones { zone_grid { columns: 1 rows: 1 } }";
        const std::size_t at = text.find(grid);
        ASSERT_NE(at, std::string::npos);
        text.replace(at, grid.size(), kTwoZones);
        const std::string spawn = "spawn { x_m: 0 z_m: 0 }";
        text.replace(text.find(spawn), spawn.size(), "spawn { x_m: -20 z_m: 0 }\n");
        file = scratch_folder() + "/two.txtpb";
        std::ofstream(file) << text << more;
        server = start_server(sets, file);
        admin_port = static_cast<std::uint16_t>(number_after(server->output(), "admin="));
    }

    static std::vector<std::string> crash_files() {
        std::vector<std::string> out;
        for (const auto& entry : std::filesystem::directory_iterator(scratch_folder())) {
            if (entry.path().filename().string().starts_with("crash-")) {
                out.push_back(entry.path().string());
            }
        }
        return out;
    }

    /// The process died within that tick, whose inputs are on disk all the same.
    static void expect_last_inputs_of_tick(int tick) {
        Child replay("zoned", {"replay", "--info", scratch_folder() + "/ring"});
        EXPECT_EQ(replay.wait(kPatience), 1) << replay.errors();
        for (const std::string& text : {", 1 to " + std::to_string(tick) + "\n",
                                        std::string("last tick       not simulated to its end")}) {
            EXPECT_NE(replay.output().find(text), std::string::npos) << replay.output();
        }
    }

    static void forget_crashes() {
        for (const std::string& crash : crash_files()) {
            std::filesystem::remove(crash);
        }
    }

    std::string file;
};

TEST_F(Faulty, OneZoneStopsWhereItsRulesThrow) {
    const std::string recording = scratch_folder() + "/thrown.zrec";
    serve_two("testing { break_zone { zone: \"west\" at_tick: 150 } }\n",
              {"--set", "recording.file=\"" + recording + "\""});
    std::vector<std::string> arguments = play(6, 20);
    arguments.insert(arguments.end(), {"--no-audit", "--no-freeze"});
    players = std::make_unique<Child>("client-sim", arguments);
    ASSERT_TRUE(server->wait_for_errors(
        "zone 1 stopped at tick 150 in the pass rules: testing.break_zone", kPatience))
        << server->errors();
    EXPECT_NE(server->errors().find("testing.break_zone: this server makes faults on purpose"),
              std::string::npos);
    // Figures are younger than the stop within a second.
    for (int i = 0; i < 60 && said.find("stopped ") == std::string::npos; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        ASSERT_EQ(ctl({"status"}), 0) << complained;
    }
    expect_said({"stopped     zone 1 at tick 150 in the pass rules"});
    EXPECT_EQ(ctl({"metrics"}), 0) << complained;
    expect_said({"zoned_zones_stopped 1\n"});
    // The other zone goes on, and takes players.
    const int tick = number_after(ask("/api/v1/status"), "\"tick\": ");
    Child late("client-sim", play(2, 2));
    EXPECT_EQ(late.wait(kPatience), 0) << late.output() << late.errors();
    EXPECT_GT(number_after(ask("/api/v1/status"), "\"tick\": "), tick);
    players->wait(kPatience);
    EXPECT_NE(players->output().find("has stopped after a fault"), std::string::npos)
        << players->output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    // The exception is part of the simulation: a replay meets it too.
    Child replay("zoned", {"replay", recording});
    EXPECT_EQ(replay.wait(kPatience), 0) << replay.output() << replay.errors();
}

TEST_F(Faulty, TheServerEndsInOrderWhereItIsToldTo) {
    serve_two("testing { break_zone { at_tick: 30 } }\nrun { on_exception: STOP_SERVER }\n");
    EXPECT_EQ(server->wait(kPatience), 1) << server->errors();
    EXPECT_NE(server->errors().find("stopping: the rules of a zone threw"), std::string::npos)
        << server->errors();
    // The last inputs are kept, and meet the exception again.
    Child replay("zoned", {"replay", scratch_folder() + "/ring"});
    EXPECT_EQ(replay.wait(kPatience), 1) << replay.errors();
    EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos) << replay.errors();
}

TEST_F(Faulty, ACrashLeavesItsStackTickAndZone) {
    forget_crashes();
    for (const auto& [kind, name, signal] :
         {std::tuple{"CRASH", "SIGSEGV", SIGSEGV}, std::tuple{"ABORT", "SIGABRT", SIGABRT}}) {
        serve_two(std::string("testing { break_zone { zone: \"east\" at_tick: 40 kind: ") + kind +
                  " } }\n");
        EXPECT_EQ(server->wait(kPatience), 128 + signal) << server->errors();
        ASSERT_EQ(crash_files().size(), 1U);
        const std::string text = read(crash_files()[0]);
        for (const std::string& part : {std::string("signal: ") + name,
                                        std::string("place: zone 2, tick 40, pass rules"),
                                        std::string("stack:\n"),
                                        std::string("BrokenRules")}) {
            EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
        }
        EXPECT_NE(server->errors().find("the stack is in "), std::string::npos);
        expect_last_inputs_of_tick(40);
        // The next start says so.
        serve_two("");
        EXPECT_NE(server->errors().find("a run before this one crashed; " + crash_files()[0]),
                  std::string::npos)
            << server->errors();
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0);
        forget_crashes();
    }
}

TEST_F(Faulty, PlayersJoinAWorldThatIsThreeMebibytesToTell) {
    // Hills of 300 x 300 vertices, as a mesh.
    constexpr int kSide = 300;
    const std::string mesh = scratch_folder() + "/hills.obj";
    std::ofstream out(mesh);
    for (int k = 0; k < kSide; ++k) {
        for (int i = 0; i < kSide; ++i) {
            out << "v " << 0.2 * i - 30.0 << " " << 0.01 * ((i * 7 + k * 13) % 10) - 0.2 << " "
                << 0.2 * k - 30.0 << "\n";
        }
    }
    for (int k = 0; k + 1 < kSide; ++k) {
        for (int i = 0; i + 1 < kSide; ++i) {
            const int v = k * kSide + i + 1;
            out << "f " << v << " " << v + kSide << " " << v + kSide + 1 << "\nf " << v << " "
                << v + kSide + 1 << " " << v + 1 << "\n";
        }
    }
    out.close();
    const std::string config = scratch_folder() + "/large.txtpb";
    std::string text = read(minimal());
    const std::string walls = "statics {";
    text.replace(text.find(walls), walls.size(), "statics {\n  surface { file: \"" + mesh + "\" }");
    std::ofstream(config) << text;
    serve({}, config);
    Child bots("client-sim", play(4, 3));
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output() << bots.errors() << server->errors();
    EXPECT_NE(bots.output().find("bots 4 of 4 joined"), std::string::npos) << bots.output();
    const std::string metrics = testing_admin::get(admin_port, "/metrics");
    const std::string key = "zoned_frame_bytes_total{direction=\"out\"} ";
    EXPECT_GT(std::stod(metrics.substr(metrics.find(key) + key.size())), 4.0 * 2.5e6);
}

TEST_F(Faulty, CheckAsksTheRulesAboutTheirSettings) {
    const std::string config = scratch_folder() + "/rules.txtpb";
    std::ofstream(config) << read(minimal())
                          << "rules { name: \"no_such_setting\" value: \"1\" }\n";
    for (const char* command : {"check", "explain"}) {
        Child child("zoned", {command, config});
        EXPECT_EQ(child.wait(kPatience), 2) << command << child.errors();
        EXPECT_NE(child.errors().find("no_such_setting"), std::string::npos) << child.errors();
    }
    Child child("zoned", {"serve", "--config", config, "--set", state_set()});
    EXPECT_EQ(child.wait(kPatience), 2) << child.errors();
}

TEST_F(Faulty, CheckKnowsWhichMapsCannotBeBaked) {
    // Steps of 5 cm, of which Recast counts 8,191: 409 m.
    const std::string config = std::string(ZONED_SOURCE_DIR) + "/config/bridge.txtpb";
    const std::string high = "statics.box[0].y_m=450";
    for (const char* command : {"check", "explain"}) {
        Child child("zoned", {command, config, "--set", high});
        EXPECT_EQ(child.wait(kPatience), 2) << command << child.errors();
        EXPECT_NE(child.errors().find("zone 1: more than 8191 steps"), std::string::npos)
            << child.errors();
    }
    Child serve("zoned", {"serve", "--config", config, "--set", high, "--set", state_set()});
    EXPECT_EQ(serve.wait(kPatience), 2) << serve.errors();
    Child lower("zoned", {"check", config, "--set", "statics.box[0].y_m=400"});
    EXPECT_EQ(lower.wait(kPatience), 0) << lower.errors();
}

TEST_F(Faulty, TicketsOfStandardOutputOpenSessions) {
    const std::string base = scratch_folder() + "/signer";
    Child keygen("zoned", {"keygen", base});
    ASSERT_EQ(keygen.wait(kPatience), 0) << keygen.errors();
    server = start_server({"--set",
                           "session.dev_mode_loopback=false",
                           "--set",
                           "session.ticket_public_key_file=\"" + base + ".pub\""});
    const std::string tickets = scratch_folder() + "/tickets.txt";
    std::ofstream out(tickets);
    for (const char* account : {"ann", "bob"}) {
        Child ticket("zoned", {"ticket", "--key", base + ".key", "--account", account});
        ASSERT_EQ(ticket.wait(kPatience), 0) << ticket.errors();
        out << ticket.output();
    }
    out.close();
    std::vector<std::string> arguments = play(2, 2);
    arguments.insert(arguments.end(), {"--ticket", tickets, "--no-audit", "--no-freeze"});
    Child bots("client-sim", arguments);
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output() << bots.errors();
    EXPECT_NE(server->errors().find("(account bob, name bob) of "), std::string::npos)
        << server->errors();
}

TEST_F(Faulty, LogsInJsonWhoComesAndGoes) {
    server = start_server({"--set", "log.format=LOG_JSON"});
    Child bots("client-sim", play(1, 2));
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    std::istringstream lines(server->errors());
    std::string line;
    int count = 0;
    while (std::getline(lines, line)) {
        EXPECT_TRUE(line.starts_with("{\"time\":\"2") && line.ends_with("\"}")) << line;
        ++count;
    }
    EXPECT_GT(count, 4);
    for (const char* text :
         {"\"area\":\"session\",\"message\":\"client 1 (account development, name ",
          " joined, rights PLAY",
          " left: quit\"",
          "session.dev_mode_loopback: everybody on this machine"}) {
        EXPECT_NE(server->errors().find(text), std::string::npos) << text << server->errors();
    }
}

}  // namespace
}  // namespace zoned::testing_process
