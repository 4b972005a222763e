// A narrow path to real clients: the server's sending rate follows it.
#include "tests/integration/process/fixture.h"

namespace zoned::testing_process {
namespace {

double number_of(const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\":");
    return at == std::string::npos ? -1.0 : std::stod(json.substr(at + key.size() + 3));
}

class Bottleneck : public Process {
  protected:
    /// The report of bots behind 256 kbit/s each, in a world that always has more to say.
    std::string play_narrow(const std::string& congestion_control) {
        // Coded for each client, all of it would fit.
        const auto server = start_server({"--set",
                                          "replication.codec=SHARED",
                                          "--set",
                                          "replication.predictor=STATIC",
                                          "--set",
                                          "replication.budget_bytes_per_s=125000",
                                          "--set",
                                          "scatter[1].count=150",
                                          "--set",
                                          "brain[0].state[0].transition[0].threshold=100000",
                                          "--set",
                                          "lod[0].position_bound_m=0.01",
                                          "--set",
                                          "lod[1].position_bound_m=0.01",
                                          "--set",
                                          "replication.congestion_control=" + congestion_control});
        const std::string report = scratch_folder() + "/bottleneck.json";
        std::vector<std::string> arguments = play(2, 8);
        for (const char* more : {"--bottleneck-kbit-s",
                                 "256",
                                 "--delay-ms",
                                 "20",
                                 "--no-audit",
                                 "--no-freeze",
                                 "--report"}) {
            arguments.emplace_back(more);
        }
        arguments.push_back(report);
        Child client("client-sim", arguments);
        EXPECT_GE(client.wait(kPatience), 0) << client.errors();
        return read(report);
    }
};

// Virtual time holds the figures (integration_sandbox); a machine that others keep busy delays
// datagrams as a queue would, so that here only the difference is claimed.
TEST_F(Bottleneck, IsFilledWithAShorterQueueThanWithoutCongestionControl) {
    const std::string controlled = play_narrow("true");
    const std::string flooded = play_narrow("false");
    EXPECT_GT(number_of(controlled, "bottleneck_utilisation"), 0.5) << controlled;
    EXPECT_GT(number_of(flooded, "bottleneck_utilisation"), 0.5) << flooded;
    EXPECT_GT(number_of(flooded, "bottleneck_wait_ms_p50"), 150.0);
    EXPECT_LT(number_of(controlled, "bottleneck_wait_ms_p50"),
              0.5 * number_of(flooded, "bottleneck_wait_ms_p50"));
}

}  // namespace
}  // namespace zoned::testing_process
