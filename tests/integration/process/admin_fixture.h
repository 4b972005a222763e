// Admin: a fixture with a live server, its admin interface over real sockets, and zoned ctl.
#pragma once

#include "tests/integration/process/fixture.h"
#include "tests/unit/admin/raw_socket.h"

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace zoned::testing_process {

using testing_admin::status_of;

class Admin : public Process {
  protected:
    void serve(std::vector<std::string> more = {}, const std::string& config = minimal()) {
        server = start_server(std::move(more), config);
        admin_port = static_cast<std::uint16_t>(number_after(server->output(), "admin="));
        ASSERT_NE(admin_port, 0);
        // Figures come with the first ticks.
        for (int i = 0; i < 500 && status_of(ask("/readyz")) != 200; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    /// Bots that play until they are thrown out, or for a minute.
    void join(int bots) {
        std::vector<std::string> arguments = play(bots, 60);
        arguments.insert(arguments.end(), {"--no-audit", "--no-freeze"});
        players = std::make_unique<Child>("client-sim", arguments);
        EXPECT_TRUE(wait_for_sessions(bots)) << players->errors() << server->errors();
    }

    bool wait_for_sessions(int count) const {
        for (int i = 0; i < 600; ++i) {
            const std::string body = ask("/api/v1/status");
            if (number_after(body, "\"sessions\": ") == count) {
                return true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        return false;
    }

    static std::string token() { return read(scratch_folder() + "/admin.token").substr(0, 64); }

    static std::string bearer() { return "Authorization: Bearer " + token() + "\r\n"; }

    [[nodiscard]] std::string ask(const std::string& target) const {
        return testing_admin::get(admin_port, target, bearer());
    }

    [[nodiscard]] std::string order(const std::string& target,
                                    const std::string& body,
                                    const std::string& more = "") const {
        return testing_admin::send_raw(
            admin_port,
            "POST " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + bearer() +
                "Content-Type: application/json\r\n" + more +
                "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    }

    /// Runs `zoned ctl`; its output is in `said` and `complained`.
    int ctl(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"ctl", "--state", scratch_folder()});
        Child child("zoned", arguments);
        const int code = child.wait(kPatience);
        said = child.output();
        complained = child.errors();
        return code;
    }

    void expect_said(const std::vector<std::string>& texts) const {
        for (const std::string& text : texts) {
            EXPECT_NE(said.find(text), std::string::npos) << text << " is not in\n" << said;
        }
    }

    std::unique_ptr<Child> server;
    std::unique_ptr<Child> players;
    std::uint16_t admin_port = 0;
    std::string said;
    std::string complained;
};

}  // namespace zoned::testing_process
