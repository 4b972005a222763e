// Monitoring: the rules and the dashboard that come with the server name figures that it has.
#include "tests/integration/process/fixture.h"

#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <regex>
#include <set>

namespace zoned::testing_process {
namespace {

const std::string kMonitoring = ZONED_SOURCE_DIR "/docker/monitoring";

int promtool(const std::vector<std::string>& arguments, std::string& output) {
    Child tool("/usr/bin/promtool", arguments);
    const int code = tool.wait(kPatience);
    output = tool.output() + tool.errors();
    return code;
}

/// Names of figures in a text, without what a summary adds to them.
std::set<std::string> figures_in(const std::string& text) {
    static const std::regex kName("\\b(zoned|process)_[a-z0-9_]+");
    std::set<std::string> names;
    for (std::sregex_iterator at(text.begin(), text.end(), kName), end; at != end; ++at) {
        names.insert(std::regex_replace(at->str(), std::regex("_(sum|count)$"), ""));
    }
    return names;
}

class Monitoring : public Process {};

TEST_F(Monitoring, RulesAreGoodAndFireOnTheirFaults) {
    if (!std::filesystem::exists("/usr/bin/promtool")) {
        GTEST_SKIP() << "promtool is not installed (config/packages.txt)";
    }
    std::string output;
    EXPECT_EQ(promtool({"check", "config", kMonitoring + "/prometheus.yml"}, output), 0) << output;
    EXPECT_EQ(promtool({"test", "rules", kMonitoring + "/alerts_test.yml"}, output), 0) << output;
}

TEST_F(Monitoring, EveryFigureOfRulesAndDashboardIsOneOfTheServers) {
    const std::string report = scratch_folder() + "/server.json";
    // In a cluster, whose figures others have not; it is alone in its realm.
    const auto server = start_server({"--report", report, "--set", "cluster.name=\"castle\""});
    Child client("client-sim", play(2, 2));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    Child metrics("zoned", {"ctl", "--state", scratch_folder(), "metrics"});
    ASSERT_EQ(metrics.wait(kPatience), 0) << metrics.errors();
    std::size_t named = 0;
    for (const char* file : {"/alerts.yml", "/alerts_test.yml", "/grafana/dashboards/zoned.json"}) {
        for (const std::string& name : figures_in(read(kMonitoring + file))) {
            EXPECT_NE(metrics.output().find("# TYPE " + name + " "), std::string::npos)
                << file << " names " << name;
            ++named;
        }
    }
    EXPECT_GT(named, 30U);
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
}

}  // namespace
}  // namespace zoned::testing_process
