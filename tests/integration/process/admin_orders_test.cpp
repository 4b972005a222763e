// An operator tells a live server by zoned ctl, beyond sessions: the world, the log, the config;
// and the commands describe themselves.
#include "tests/integration/process/admin_fixture.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace zoned::testing_process {
namespace {

TEST_F(Admin, SpawnsAndMovesByCtlAndReplaysIt) {
    const std::string file = scratch_folder() + "/orders.zrec";
    // Without gravity a crate is where it was put, whenever one looks.
    serve({"--set", "recording.file=\"" + file + "\"", "--set", "physics.gravity_mps2=0"});
    EXPECT_EQ(ctl({"spawn", "crate", "--at", "3", "5", "-20"}), 0) << complained;
    expect_said({"spawned a crate: entity "});
    const int entity = number_after(said, "entity ");
    ASSERT_GT(entity, 0);
    EXPECT_EQ(ctl({"inspect", std::to_string(entity)}), 0) << complained;
    expect_said({"a crate in zone 1", "position    3.000, 5.000, -20.000 m"});
    EXPECT_EQ(ctl({"move", std::to_string(entity), "--to", "-7", "4", "9"}), 0) << complained;
    EXPECT_EQ(ctl({"inspect", std::to_string(entity)}), 0) << complained;
    expect_said({"position    -7.000, 4.000, 9.000 m"});
    EXPECT_EQ(ctl({"spawn", "player", "--at", "1", "5", "2", "--yaw", "90"}), 0) << complained;
    const int walker = number_after(said, "entity ");
    EXPECT_EQ(ctl({"--json", "inspect", std::to_string(walker)}), 0) << complained;
    expect_said({"\"orientation\": [\n  0.7071", ",\n  0,\n  0.7071"});  // w, x, y, z
    EXPECT_EQ(ctl({"spawn", "dragon", "--at", "0", "0", "0"}), 1);
    EXPECT_NE(complained.find("no type of that name"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"spawn", "crate", "--at", "900", "0", "0"}), 1);
    EXPECT_NE(complained.find("no running zone is there"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"move", "4000000", "--to", "0", "0", "0"}), 1);
    EXPECT_EQ(ctl({"spawn", "crate", "--at", "1", "2"}), 2);
    EXPECT_EQ(status_of(order("/api/v1/spawn", "{\"type\": \"crate\", \"position_m\": [1, 2]}")),
              400);
    EXPECT_EQ(
        status_of(order("/api/v1/spawn", "{\"type\": \"crate\", \"position_m\": [\"NaN\", 2, 3]}")),
        400);
    EXPECT_EQ(status_of(order("/api/v1/move", "{\"position_m\": [1, 2, 3]}")), 400);
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    Child replay("zoned", {"replay", file});
    EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos) << replay.output();
}

TEST_F(Admin, EndsBeginsAndCopiesTheRecordingByCtl) {
    const std::string file = scratch_folder() + "/begun.zrec";
    const std::string folder = scratch_folder() + "/recordings";
    serve({"--set", "recording.file=\"" + file + "\""});
    join(2);
    EXPECT_EQ(ctl({"snapshot", "--file", "early.zrec"}), 0) << complained;
    expect_said({folder + "/early.zrec holds ticks 1 to "});
    EXPECT_EQ(ctl({"record", "off"}), 0) << complained;
    expect_said({file + " holds ticks 1 to "});
    EXPECT_EQ(ctl({"record", "off"}), 2);
    EXPECT_NE(complained.find("nothing is recorded"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"spawn", "crate", "--at", "3", "5", "-20"}), 0) << complained;
    EXPECT_EQ(ctl({"record", "on", "--file", "later.zrec"}), 0) << complained;
    expect_said({"recording into " + folder + "/later.zrec, from tick "});
    EXPECT_GT(testing_process::number_after(said, "from tick "), 1);
    EXPECT_EQ(ctl({"record", "on"}), 2);
    EXPECT_EQ(ctl({"snapshot", "--file", "early.zrec"}), 2);
    EXPECT_NE(complained.find("exists already"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"snapshot", "--file", "../early.zrec"}), 2);
    EXPECT_EQ(ctl({"record", "on", "--file", ".zrec"}), 2);
    EXPECT_EQ(status_of(order("/api/v1/snapshot", "{\"file\": \"a/b\"}")), 400);
    EXPECT_EQ(ctl({"snapshot"}), 0) << complained;
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        ++files;
        Child replay("zoned", {"replay", entry.path().string()});
        EXPECT_EQ(replay.wait(kPatience), 0) << entry.path() << replay.errors();
    }
    EXPECT_EQ(files, 3U);
    Child replay("zoned", {"replay", file});
    EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
}

TEST_F(Admin, RecordsFromAnyTickOnAndReplaysThat) {
    serve({"--set", "recording.ring_s=0.5"});
    join(3);
    std::this_thread::sleep_for(std::chrono::seconds(2));
    // The first inputs are gone by now: what is written begins with a state beside the last ones.
    for (int tries = 0; ctl({"snapshot", "--file", "last.zrec"}) != 0 && tries < 20; ++tries) {
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    EXPECT_EQ(ctl({"record", "on", "--file", "late.zrec"}), 0) << complained;
    const int first = static_cast<int>(testing_process::number_after(said, "from tick "));
    EXPECT_GT(first, 6);
    join(2);
    EXPECT_EQ(ctl({"snapshot", "--file", "copy.zrec"}), 0) << complained;
    EXPECT_EQ(ctl({"record", "off"}), 0) << complained;
    expect_said({"late.zrec holds ticks " + std::to_string(first) + " to "});
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    const std::string late = scratch_folder() + "/recordings/late.zrec";
    for (const char* name : {"late.zrec", "copy.zrec", "last.zrec"}) {
        const std::string file = scratch_folder() + "/recordings/" + name;
        Child replay("zoned", {"replay", file, "--threads", "2"});
        EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
        EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos);
        Child begins("zoned", {"replay", file, "--info"});
        EXPECT_EQ(begins.wait(kPatience), 0) << begins.errors();
        EXPECT_NE(begins.output().find("with the state of tick"), std::string::npos) << name;
    }
    Child info("zoned", {"replay", late, "--info"});
    EXPECT_EQ(info.wait(kPatience), 0) << info.errors();
    EXPECT_NE(info.output().find("with the state of tick " + std::to_string(first - 1)),
              std::string::npos)
        << info.output();
    // A cut keeps the state where it begins with it, and nowhere else.
    const std::string part = scratch_folder() + "/part.zrec";
    for (const int from : {first, first + 5}) {
        const std::string last = std::to_string(first + 9);
        Child cut("zoned",
                  {"replay", late, "--from", std::to_string(from), "--to", last, "--out", part});
        EXPECT_EQ(cut.wait(kPatience), 0) << cut.errors();
        Child replay("zoned", {"replay", part});
        EXPECT_EQ(replay.wait(kPatience), from == first ? 0 : 1) << replay.errors();
    }
    // The checker is checked: one changed byte of the state is found.
    std::fstream damaged(late, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(static_cast<std::streamoff>(std::filesystem::file_size(part) / 2));
    damaged.put('!');
    damaged.close();
    Child replay("zoned", {"replay", late});
    EXPECT_EQ(replay.wait(kPatience), 3) << replay.output();
    EXPECT_NE(replay.errors().find("does not match its checksum"), std::string::npos)
        << replay.errors();
}

TEST_F(Admin, TellsTheBytesSpentOnAnEntity) {
    serve();
    EXPECT_EQ(ctl({"inspect", "12"}), 0) << complained;
    expect_said({"sent        0 bytes in 0 records"});
    join(2);
    for (int i = 0; i < 100 && (ctl({"--json", "inspect", "12"}) != 0 ||
                                number_after(said, "\"sent_bytes\": ") <= 0);
         ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    EXPECT_GT(number_after(said, "\"sent_bytes\": "), 0) << said;
    EXPECT_GT(number_after(said, "\"sent_records\": "), 0) << said;
}

TEST_F(Admin, ChangesTheLogLevelByCtl) {
    serve();
    EXPECT_EQ(ctl({"log-level", "debug"}), 0) << complained;
    EXPECT_EQ(ctl({"status"}), 0);
    expect_said({"log level   debug"});
    EXPECT_EQ(ctl({"log-level", "error", "--area", "session"}), 0) << complained;
    EXPECT_EQ(ctl({"status"}), 0);
    expect_said({"log level   mixed", "session error"});
    // Joins are no errors: the area is silent now.
    join(1);
    EXPECT_EQ(server->errors().find(" joined"), std::string::npos) << server->errors();
    EXPECT_EQ(ctl({"log-level", "info", "--area", "session"}), 0) << complained;
    EXPECT_EQ(ctl({"kick", "--client", "1"}), 0) << complained;
    EXPECT_TRUE(wait_for_sessions(0));
    EXPECT_TRUE(server->wait_for_errors(" left: ", kPatience)) << server->errors();
    EXPECT_EQ(ctl({"log-level", "loud"}), 2);
    EXPECT_EQ(ctl({"log-level", "info", "--area", "nowhere"}), 2);
    EXPECT_EQ(status_of(order("/api/v1/log-level", "{\"level\": \"info\", \"area\": \"nowhere\"}")),
              400);
}

/// A server whose config is a copy that the test changes.
class Reloaded : public Admin {
  protected:
    void serve_copy() {
        config = scratch_folder() + "/reloaded.txtpb";
        write(read(minimal()));
        serve({}, config);
    }

    void write(const std::string& text) const { std::ofstream(config) << text; }

    /// The text of the config with another piece.
    [[nodiscard]] static std::string with(const std::string& from, const std::string& to) {
        std::string text = read(minimal());
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    }

    std::string config;
};

TEST_F(Reloaded, TakesWhatCanChangeAndNamesWhatWaits) {
    serve_copy();
    EXPECT_EQ(ctl({"reload"}), 0) << complained;
    expect_said({"nothing differs"});
    // A brain, a limit, and a setting that takes a restart.
    write(with("threshold: 10", "threshold: 11") +
          "network { max_clients: 1 }\nrun { max_catch_up_ticks: 9 }\n");
    EXPECT_EQ(ctl({"reload"}), 0) << complained;
    expect_said({"2 settings changed: ",
                 "network.max_clients 20000 -> 1",
                 "threshold 10 -> 11",
                 "1 waits for a restart: run.max_catch_up_ticks 3 -> 9"});
    join(1);
    Child second("client-sim", play(1, 2));
    EXPECT_NE(second.wait(kPatience), 0);
    EXPECT_NE(second.output().find("full"), std::string::npos) << second.output();
    // A reload alone says otherwise of the changes that wait, whoever asked for it.
    EXPECT_EQ(ctl({"set", "session.grace_s=9"}), 0) << complained;
    EXPECT_NE(ask("/api/v1/status").find("run.max_catch_up_ticks"), std::string::npos);
    write(read(minimal()));
    server->signal(SIGHUP);
    for (int i = 0; i < 200 && ask("/api/v1/status").find("run.max_catch") != std::string::npos;
         ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    EXPECT_EQ(ask("/api/v1/status").find("run.max_catch_up_ticks"), std::string::npos);
    write(read(minimal()) + "run { max_catch_up_ticks: 9 }\n");
    EXPECT_EQ(ctl({"--json", "reload"}), 0) << complained;
    expect_said({"\"path\": \"run.max_catch_up_ticks\"", "\"live\": false"});
}

TEST_F(Reloaded, TakesNothingOfABadConfig) {
    serve_copy();
    write(with("session {", "session { grace_s: 99999 "));
    EXPECT_EQ(ctl({"reload"}), 2);
    EXPECT_NE(complained.find("grace_s"), std::string::npos) << complained;
    EXPECT_NE(complained.find("everything stays as it was"), std::string::npos) << complained;
    write(read(minimal()));
    EXPECT_EQ(ctl({"reload"}), 0) << complained;
    expect_said({"nothing differs"});
    // Signals do the same as ctl.
    write(with("session {", "session { grace_s: 7 "));
    server->signal(SIGHUP);
    EXPECT_TRUE(server->wait_for_errors("session.grace_s 30 -> 7", kPatience)) << server->errors();
}

TEST_F(Admin, SpeaksTlsWhereOthersCanAsk) {
    serve({"--set", "network.admin_address=\"0.0.0.0\""});
    EXPECT_NE(server->errors().find("lets other machines reach the admin server"),
              std::string::npos)
        << server->errors();
    EXPECT_EQ(read(scratch_folder() + "/admin.address"),
              "https://127.0.0.1:" + std::to_string(admin_port) + "\n");
    EXPECT_EQ(ctl({"status"}), 0) << complained;
    expect_said({"world       minimal"});
    EXPECT_EQ(ctl({"viewer"}), 0);
    expect_said({"https://127.0.0.1:"});
    // Plain requests get no answer, and are counted.
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/healthz")), 0);
    EXPECT_EQ(ctl({"metrics"}), 0) << complained;
    expect_said({"zoned_admin_refused_total{reason=\"tls_handshake\"} "});
    // Without the certificate, and with another one, nobody is trusted.
    const std::string address = "https://127.0.0.1:" + std::to_string(admin_port);
    EXPECT_EQ(ctl({"--admin", address, "status"}), 3);
    EXPECT_NE(complained.find("not trusted"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"--admin", address, "--certificate", scratch_folder() + "/none", "status"}), 3);
    EXPECT_EQ(ctl({"--admin", "127.0.0.1:" + std::to_string(admin_port), "status"}), 3);
    EXPECT_EQ(ctl({"--admin",
                   address,
                   "--certificate",
                   scratch_folder() + "/admin.certificate",
                   "status"}),
              0)
        << complained;
}

TEST_F(Admin, DescribesItsWholeInterface) {
    serve();
    const std::string description = testing_admin::get(admin_port, "/api/v1/openapi.json");
    ASSERT_EQ(status_of(description), 200);
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/api")), 200);
    // Each path that is described is there; an entity or a piece 12 may be missing.
    const std::string kNothing = "there is nothing at";
    EXPECT_NE(ask("/api/v1/nowhere").find(kNothing), std::string::npos);
    int described = 0;
    for (std::size_t at = description.find("\n    \"/"); at != std::string::npos;
         at = description.find("\n    \"/", at + 1)) {
        std::string path = description.substr(at + 6, description.find('"', at + 6) - at - 6);
        const std::size_t id = path.find("{id}");
        if (id != std::string::npos) {
            path.replace(id, 4, "12");
        }
        EXPECT_EQ(ask(path).find(kNothing), std::string::npos) << path;
        ++described;
    }
    EXPECT_GE(described, 20);
    for (const char* path :
         {"/metrics",       "/healthz",         "/readyz",           "/version",
          "/api/v1/status", "/api/v1/sessions", "/api/v1/zones",     "/api/v1/entities/{id}",
          "/api/v1/bans",   "/api/v1/kick",     "/api/v1/ban",       "/api/v1/unban",
          "/api/v1/say",    "/api/v1/spawn",    "/api/v1/move",      "/api/v1/drain",
          "/api/v1/set",    "/api/v1/reload",   "/api/v1/log-level", "/api/v1/spectate"}) {
        EXPECT_NE(description.find("\"" + std::string(path) + "\""), std::string::npos) << path;
    }
}

TEST(CommandLine, CompletesInBash) {
    Child completion("zoned", {"completion", "bash"});
    EXPECT_EQ(completion.wait(kPatience), 0) << completion.errors();
    const std::string script = scratch_folder() + "/zoned.bash";
    std::ofstream(script) << completion.output();
    const auto complete = [&](const std::string& words, int at) {
        const std::string out = scratch_folder() + "/completed";
        const std::string command = "bash -c 'source " + script + "; COMP_WORDS=(" + words +
                                    "); COMP_CWORD=" + std::to_string(at) +
                                    "; _zoned; echo \"${COMPREPLY[*]}\"' >" + out;
        EXPECT_EQ(std::system(command.c_str()), 0) << command;
        return read(out);
    };
    EXPECT_EQ(complete("zoned ser", 1), "serve\n");
    EXPECT_NE(complete("zoned serve --s", 2).find("--set"), std::string::npos);
    EXPECT_EQ(complete("zoned ctl --state x unb", 4), "unban\n");
    EXPECT_EQ(complete("zoned ctl log-level deb", 3), "debug\n");
    EXPECT_EQ(complete("zoned ctl log-level info --area ses", 5), "session\n");
    EXPECT_NE(complete("zoned ctl kick --", 3).find("--reason"), std::string::npos);
}

TEST(CommandLine, HasAManualPage) {
    Child manual("zoned", {"manual"});
    EXPECT_EQ(manual.wait(kPatience), 0) << manual.errors();
    for (const char* text : {".TH ZONED 1", "zoned ctl kick", "\\-\\-reason", ".SH EXIT STATUS"}) {
        EXPECT_NE(manual.output().find(text), std::string::npos) << text;
    }
    const std::string page = scratch_folder() + "/zoned.1";
    std::ofstream(page) << manual.output();
    // groff tells what it does not understand.
    const std::string command =
        "groff -man -ww -rLL=80n -Tutf8 -Z " + page + " 2>" + page + ".errors >/dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(read(page + ".errors"), "");
}

}  // namespace
}  // namespace zoned::testing_process
