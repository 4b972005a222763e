// PlayFixture: a live server, and the page to play on in a real browser.
#pragma once

#include "tests/browser/viewer_fixture.h"

#include <chrono>
#include <cmath>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace zoned::testing_browser {

class PlayFixture : public ViewerFixture {
  protected:
    void SetUp() override {
        ASSERT_TRUE(has_browser()) << "chromium is not installed (config/packages.txt)";
        start();
        browser = std::make_unique<Browser>();
    }

    void start(const std::vector<std::string>& more = {},
               const std::string& config = testing_process::minimal()) {
        std::vector<std::string> arguments{"--set",
                                           "network.admin_port=" + std::to_string(admin_port),
                                           "--set",
                                           "network.websocket_port=0"};
        for (const std::string& setting : more) {
            arguments.insert(arguments.end(), {"--set", setting});
        }
        server = start_server(arguments, config);
        admin_port = testing_process::number_after(server->output(), "admin=");
        websocket_port = testing_process::number_after(server->output(), "websocket=");
        ASSERT_GT(websocket_port, 0) << server->output();
    }

    /// Another server in place of the one that runs.
    void start_anew(const std::vector<std::string>& more,
                    const std::string& config = testing_process::minimal()) {
        browser->open("about:blank");  // an open page would complain that its server is gone
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(testing_process::kPatience), 0) << server->errors();
        start(more, config);
    }

    void open_page() {
        browser->open(address() + "play");
        ASSERT_TRUE(
            browser->wait_until("Boolean(window.zoned?.page.code)", testing_process::kPatience))
            << browser->evaluate("document.body.innerText");
    }

    void enter() {
        open_page();
        log_in("ann");
    }

    void log_in(const std::string& name) {
        browser->evaluate("(() => { document.getElementById('name').value = '" + name +
                          "'; document.getElementById('enter').requestSubmit(); })()");
        ASSERT_TRUE(
            browser->wait_until("zoned.counts().state === 2 && zoned.own() !== null && "
                                "zoned.counts().frames > 5",
                                testing_process::kPatience))
            << browser->evaluate("JSON.stringify(zoned.counts())") << server->errors();
    }

    /// x, y and z of a JSON array, or of nothing.
    static std::vector<double> numbers(std::string text) {
        for (char& c : text) {
            c = c == '[' || c == ']' || c == ',' ? ' ' : c;
        }
        std::istringstream in(text);
        std::vector<double> out;
        for (double v = 0.0; in >> v;) {
            out.push_back(v);
        }
        return out;
    }

    std::vector<double> own() {
        return numbers(browser->evaluate("JSON.stringify(zoned.own().position)"));
    }

    /// Where the server says that the avatar is.
    std::vector<double> truth() {
        return numbers(browser->evaluate(
            "fetch('api/v1/entities/' + zoned.own().id, {headers: {Authorization: 'Bearer " +
            token() + "'}}).then((a) => a.json()).then((e) => JSON.stringify(e.position_m))"));
    }

    static double distance(const std::vector<double>& a, const std::vector<double>& b) {
        return a.size() == 3 && b.size() == 3 ? std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2])
                                              : 1e9;
    }

    void hold(const std::string& code, const std::string& name, double seconds) {
        browser->key(code, name, true);
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
        browser->key(code, name, false);
    }

    double stat(const std::string& name) {
        return std::stod(browser->evaluate("zoned.stats()." + name));
    }

    /// The avatar stands: page and server say where.
    void wait_until_both_agree() {
        double apart = 1e9;
        for (int i = 0; i < 50 && apart > 0.01; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            apart = distance(own(), truth());
        }
        EXPECT_LT(apart, 0.01);
    }

    /// The page's own verdict, by the rules for bots.
    std::string verdict() { return browser->evaluate("zoned.stats().verdict"); }

    /// The person's client is judged as each bot's is, by at least so many states.
    void expect_consistent_page(int states) {
        // States that came while the page was being built are old, and weigh less and less.
        EXPECT_TRUE(browser->wait_until("zoned.stats().judged >= " + std::to_string(states) +
                                            " && zoned.stats().verdict === 'consistent'",
                                        testing_process::kPatience))
            << verdict();
        EXPECT_EQ(stat("beyond"), 0.0);
        EXPECT_EQ(stat("missing") + stat("extra") + stat("wrongValues"), 0.0);
    }

    /// Waits until the bots have ended, and reads their verdict.
    static void expect_consistent(testing_process::Child& bots) {
        EXPECT_EQ(bots.wait(2.0 * testing_process::kPatience), 0) << bots.output();
        EXPECT_NE(bots.output().find("verdict: consistent"), std::string::npos) << bots.output();
    }

    int websocket_port = 0;
};

}  // namespace zoned::testing_browser
