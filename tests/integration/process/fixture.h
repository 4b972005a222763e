// Process: a fixture that starts the server as users do, and gives arguments for its clients.
#pragma once

#include "tests/integration/process/child.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace zoned::testing_process {

// Sanitizer builds on a busy machine start slowly: waits are generous, and cost nothing when all
// goes well.
inline constexpr double kPatience = 60.0;

inline std::string minimal() {
    return ZONED_SOURCE_DIR "/config/minimal.txtpb";
}

inline std::string state_set() {
    return "session.state_folder=\"" + scratch_folder() + "\"";
}

inline std::string read(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

/// A server on the minimal world with free ports.
class Process : public ::testing::Test {
  protected:
    std::unique_ptr<Child> start_server(std::vector<std::string> more = {},
                                        const std::string& config = minimal()) {
        // A test machine may be busy with other tests: that is no reason to refuse a login.
        std::vector<std::string> arguments{
            "serve", "--config", config, "--set", state_set(), "--set", "network.max_load=1000"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        auto server = std::make_unique<Child>("zoned", arguments);
        EXPECT_TRUE(server->wait_for_output("ready ", kPatience)) << server->errors();
        tcp_port = number_after(server->output(), "tcp=");
        return server;
    }

    std::vector<std::string> play(int bots,
                                  int seconds,
                                  const std::string& host = "127.0.0.1") const {
        return {"--connect",
                host + ":" + std::to_string(tcp_port),
                "--bots",
                std::to_string(bots),
                "--seconds",
                std::to_string(seconds)};
    }

    int tcp_port = -1;
};

}  // namespace zoned::testing_process
