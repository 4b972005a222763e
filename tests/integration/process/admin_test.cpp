// A live server under its operator: the admin interface over real sockets, and zoned ctl.
#include "tests/integration/process/admin_fixture.h"

#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

namespace zoned::testing_process {
namespace {

TEST_F(Admin, AnswersWhatMonitorsAskWithoutAToken) {
    serve();
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/healthz")), 200);
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/readyz")), 200);
    const std::string version = testing_admin::get(admin_port, "/version");
    EXPECT_NE(version.find("\"protocol_version\": "), std::string::npos) << version;
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/metrics")), 200);
    for (const char* closed : {"/api/v1/status",
                               "/api/v1/sessions",
                               "/api/v1/zones",
                               "/api/v1/entities/1",
                               "/api/v1/bans"}) {
        EXPECT_EQ(status_of(testing_admin::get(admin_port, closed)), 401) << closed;
        EXPECT_EQ(status_of(ask(closed)), 200) << ask(closed);
    }
}

TEST_F(Admin, KeepsItsTokenSecretAndAcrossRestarts) {
    serve();
    const std::string first = token();

    struct stat status {};

    ASSERT_EQ(::stat((scratch_folder() + "/admin.token").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U);
    EXPECT_EQ(server->errors().find(first), std::string::npos) << "the log holds the token";
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    serve();
    EXPECT_EQ(token(), first);
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    ASSERT_EQ(::chmod((scratch_folder() + "/admin.token").c_str(), 0644), 0);
    Child careless("zoned", {"serve", "--config", minimal(), "--set", state_set()});
    EXPECT_EQ(careless.wait(kPatience), 3);
    EXPECT_NE(careless.errors().find("chmod 600"), std::string::npos) << careless.errors();
    // The folder is that of all tests of this process.
    ASSERT_EQ(::chmod((scratch_folder() + "/admin.token").c_str(), 0600), 0);
}

TEST_F(Admin, MayBeSwitchedOff) {
    server = start_server({"--set", "network.admin=false"});
    EXPECT_EQ(number_after(server->output(), "admin="), 0);
}

TEST_F(Admin, SpeaksPrometheus) {
    serve();
    join(3);
    const std::string answer = testing_admin::get(admin_port, "/metrics");
    EXPECT_NE(answer.find("Content-Type: text/plain; version=0.0.4"), std::string::npos);
    const std::string text = answer.substr(answer.find("\r\n\r\n") + 4);
    for (const char* sample : {"\nzoned_sessions 3\n",
                               "\nzoned_ticks_total ",
                               "\nzoned_tick_seconds{quantile=\"0.99\"} ",
                               "\nzoned_zone_entities{zone=\"",
                               "\n# TYPE zoned_rules_total counter\n",
                               "\n# TYPE zoned_rules_value gauge\n",
                               "\nzoned_pass_seconds_total{pass=\"physics\"} ",
                               "\nzoned_datagram_bytes_total{direction=\"out\"} "}) {
        EXPECT_NE(text.find(sample), std::string::npos) << sample << text;
    }
    if (std::system("command -v promtool >/dev/null") != 0) {
        GTEST_SKIP() << "promtool is not installed (config/packages.txt)";
    }
    const std::string file = scratch_folder() + "/metrics.txt";
    std::ofstream(file) << text;
    const std::string command = "promtool check metrics <" + file + " >" + file + ".out 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << read(file + ".out");
}

TEST_F(Admin, RefusesForeignPagesAndBrokenOrders) {
    serve();
    EXPECT_EQ(
        status_of(order("/api/v1/say", "{\"text\": \"hi\"}", "Origin: http://evil.example\r\n")),
        403);
    EXPECT_EQ(status_of(order("/api/v1/say", "{\"text\": \"hi\"}")), 200);
    for (const auto& [target, body] : std::vector<std::pair<std::string, std::string>>{
             {"/api/v1/say", "{}"},
             {"/api/v1/say", "{\"text\": \"bell \\u0007\"}"},
             {"/api/v1/say", "{\"text\": \"" + std::string(1025, 'x') + "\"}"},
             {"/api/v1/kick", "{"},
             {"/api/v1/kick", "{}"},
             {"/api/v1/kick", "{\"client\": 1, \"name\": \"x\"}"},
             {"/api/v1/kick", "{\"nobody\": 1}"},
             {"/api/v1/ban", "{\"account\": \"\"}"},
             {"/api/v1/ban", "{\"account\": \"x\", \"hours\": -1}"},
             {"/api/v1/ban", "{\"account\": \"x\", \"hours\": \"NaN\"}"},
             {"/api/v1/drain", "{\"grace_s\": \"Infinity\"}"},
             {"/api/v1/log-level", "{\"level\": \"loud\"}"}}) {
        const std::string answer = order(target, body);
        EXPECT_EQ(status_of(answer), 400) << target << " " << body.substr(0, 60) << "\n" << answer;
        EXPECT_NE(answer.find("\"detail\": \""), std::string::npos);
    }
    EXPECT_EQ(status_of(order("/api/v1/kick", "{\"client\": 99}")), 404);
    EXPECT_EQ(status_of(order("/api/v1/unban", "{\"account\": \"x\"}")), 404);
    EXPECT_EQ(status_of(ask("/api/v1/entities/4000000000")), 404);
    EXPECT_EQ(status_of(ask("/api/v1/sessions?limit=0")), 400);
    EXPECT_EQ(status_of(ask("/api/v1/sessions?after=x")), 400);
    EXPECT_NE(ask("/api/v1/status").find("\"origin\": 1"), std::string::npos);
}

TEST_F(Admin, ShowsTheServerByCtl) {
    serve();
    join(2);
    EXPECT_EQ(ctl({"status"}), 0) << complained;
    expect_said({"world       minimal", "sessions    2 (most 2)", "log level   info"});
    EXPECT_EQ(ctl({"sessions"}), 0) << complained;
    expect_said({"development", "127.0.0.1:", "2 of 2 sessions"});
    for (int i = 0; i < 200 && number_after(ask("/api/v1/zones"), "\"viewers\": ") != 2; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(ctl({"zones"}), 0) << complained;
    expect_said({"state hash", "       2  "});  // viewers
    EXPECT_EQ(ctl({"inspect", "12"}), 0) << complained;
    expect_said({"entity      12, a wanderer in zone 1", "position    ", "wander"});
    EXPECT_EQ(ctl({"inspect", "4000000"}), 1);
    EXPECT_NE(complained.find("no entity 4000000"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"top", "--count", "2", "--every", "0.1"}), 0) << complained;
    expect_said({"state hash", "us a tick"});
    EXPECT_EQ(ctl({"metrics"}), 0) << complained;
    expect_said({"zoned_sessions 2\n"});
    EXPECT_EQ(ctl({"bans"}), 0) << complained;
    expect_said({"account"});
    EXPECT_EQ(ctl({"viewer"}), 0) << complained;
    EXPECT_EQ(said, "http://127.0.0.1:" + std::to_string(admin_port) + "/#token=" + token() + "\n");
    EXPECT_EQ(ctl({"--json", "sessions"}), 0) << complained;
    expect_said({"\"total\": 2", "\"account\": \"development\""});
    EXPECT_EQ(ctl({"--json", "inspect", "12"}), 0) << complained;
    expect_said({"\"type\": \"wanderer\""});
}

TEST_F(Admin, KicksByCtl) {
    serve();
    join(2);
    EXPECT_EQ(ctl({"kick", "--client", "1", "--reason", "be kind"}), 0) << complained;
    expect_said({"kicked 1 session\n"});
    EXPECT_TRUE(wait_for_sessions(1));
    EXPECT_EQ(ctl({"kick", "--client", "1"}), 1);
    EXPECT_NE(complained.find("no such session"), std::string::npos);
    EXPECT_EQ(ctl({"kick"}), 2);
    EXPECT_EQ(ctl({"kick", "--account", "development"}), 0) << complained;
    EXPECT_TRUE(wait_for_sessions(0));
    EXPECT_NE(players->wait(kPatience), 0);
    EXPECT_NE(players->output().find("be kind"), std::string::npos) << players->output();
}

TEST_F(Admin, BansByCtlAndAcrossRestarts) {
    serve();
    join(1);
    EXPECT_EQ(ctl({"ban", "development", "--reason", "no bots", "--hours", "2"}), 0) << complained;
    expect_said({"banned; 1 session ended"});
    EXPECT_TRUE(wait_for_sessions(0));
    EXPECT_EQ(ctl({"bans"}), 0);
    expect_said({"development", "UTC", "no bots"});
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    serve();
    Child refused("client-sim", play(1, 2));
    EXPECT_NE(refused.wait(kPatience), 0);
    EXPECT_NE(refused.output().find("banned: no bots"), std::string::npos) << refused.output();
    EXPECT_NE(ask("/api/v1/status").find("\"login_banned\": "), std::string::npos);
    EXPECT_EQ(ctl({"unban", "development"}), 0) << complained;
    EXPECT_EQ(ctl({"unban", "development"}), 1);
    join(1);
}

TEST_F(Admin, SaysToPlayersByCtl) {
    serve();
    join(2);
    EXPECT_EQ(ctl({"say", "the server restarts at noon"}), 0) << complained;
    expect_said({"said to 2 sessions"});
    EXPECT_EQ(ctl({"say", "you alone", "--client", "2"}), 0) << complained;
    expect_said({"said to 1 session\n"});
    EXPECT_EQ(ctl({"say", "hello", "--client", "77"}), 1);
}

TEST_F(Admin, ChangesLiveSettingsByCtl) {
    serve();
    EXPECT_EQ(ctl({"set", "network.max_clients=1"}), 0) << complained;
    join(1);
    Child second("client-sim", play(1, 2));
    EXPECT_NE(second.wait(kPatience), 0);
    EXPECT_NE(second.output().find("full"), std::string::npos) << second.output();
    EXPECT_EQ(ctl({"set", "network.max_clients=0"}), 2);
    EXPECT_NE(complained.find("network.max_clients"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"set", "network.max_clients=100000"}), 2);
    EXPECT_NE(complained.find("at most"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"set", "world.seed=9"}), 2);
    EXPECT_NE(complained.find("takes a restart"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"set", "session.grace_s=5"}), 0) << complained;
    EXPECT_EQ(ctl({"set", "session.grace_s=5"}), 0) << complained;
    expect_said({"nothing differs"});
}

/// The value of a metric without labels; below 0: there is none.
double metric(const std::string& metrics, const std::string& name) {
    const std::size_t at = metrics.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::stod(metrics.substr(at + name.size() + 2));
}

TEST_F(Admin, RefusesLoginsWhileTheLoadIsMoreThanMayBe) {
    serve();
    join(10);
    double load = 0.0;
    for (int i = 0; i < 200 && load <= 0.0; ++i) {
        load = metric(ask("/metrics"), "zoned_load");
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    ASSERT_GT(load, 0.0);
    // Far below what ten players cost, on any machine.
    EXPECT_EQ(ctl({"set", "network.max_load=" + std::to_string(std::max(1e-4, 0.1 * load))}), 0)
        << complained;
    Child refused("client-sim", play(1, 2));
    EXPECT_NE(refused.wait(kPatience), 0);
    EXPECT_NE(refused.output().find("the server is busy: its 10 clients"), std::string::npos)
        << refused.output();
    EXPECT_EQ(metric(ask("/metrics"), "zoned_logins_refused_for_load"), 1.0);
    const std::string line = "overload: logins are refused";
    for (int i = 0; i < 100 && server->errors().find(line) == std::string::npos; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    EXPECT_NE(server->errors().find(line), std::string::npos);
    EXPECT_EQ(ctl({"set", "network.max_load=1000"}), 0) << complained;
    Child taken("client-sim", play(1, 2));
    EXPECT_EQ(taken.wait(kPatience), 0) << taken.output();
    EXPECT_EQ(metric(ask("/metrics"), "zoned_logins_refused_for_load"), 0.0);
}

TEST_F(Admin, DrainsByCtlAndStops) {
    serve();
    join(2);
    EXPECT_EQ(ctl({"drain", "--grace", "3"}), 0) << complained;
    expect_said({"draining 2 sessions"});
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/readyz")), 503);
    EXPECT_EQ(status_of(testing_admin::get(admin_port, "/healthz")), 200);
    Child late("client-sim", play(1, 2));
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    EXPECT_NE(late.wait(kPatience), 0);
    EXPECT_NE(late.output().find("draining"), std::string::npos) << late.output();
    EXPECT_NE(server->errors().find("stopping: drained"), std::string::npos);
}

TEST_F(Admin, NamesWhatIsMissingInCtl) {
    Child nobody("zoned", {"ctl", "--state", scratch_folder() + "/none", "status"});
    EXPECT_EQ(nobody.wait(kPatience), 3);
    EXPECT_NE(nobody.errors().find("--state"), std::string::npos) << nobody.errors();
    serve();
    const std::string wrong = scratch_folder() + "/wrong.token";
    std::ofstream(wrong) << std::string(64, '0') << "\n";
    EXPECT_EQ(ctl({"--token-file", wrong, "status"}), 3);
    EXPECT_NE(complained.find("not this server's"), std::string::npos) << complained;
    EXPECT_EQ(ctl({"--admin", "127.0.0.1:1", "status"}), 3);
    EXPECT_NE(complained.find("no server answers at 127.0.0.1:1"), std::string::npos) << complained;
    // A port that speaks something else.
    EXPECT_EQ(ctl({"--admin", "127.0.0.1:" + std::to_string(tcp_port), "status"}), 3);
}

TEST_F(Admin, ChangesNoBitOfTheWorld) {
    const std::string file = scratch_folder() + "/watched.zrec";
    serve({"--set", "recording.file=\"" + file + "\""});
    join(2);
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(status_of(ask("/api/v1/entities/" + std::to_string(1 + i % 14))), 200);
        EXPECT_EQ(status_of(ask("/metrics")), 200);
        EXPECT_EQ(status_of(ask("/api/v1/status")), 200);
    }
    EXPECT_EQ(ctl({"say", "hello"}), 0);
    EXPECT_EQ(ctl({"kick", "--client", "1"}), 0);
    EXPECT_TRUE(wait_for_sessions(1));
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    // The replay has no admin server: every tick's hash must be what it was beside one.
    Child replay("zoned", {"replay", file});
    EXPECT_EQ(replay.wait(kPatience), 0) << replay.errors();
    EXPECT_NE(replay.output().find("every hash agrees"), std::string::npos) << replay.output();
}

}  // namespace
}  // namespace zoned::testing_process
