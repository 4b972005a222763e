// ViewerFixture: a live server, and its viewer in a real browser.
#pragma once

#include "tests/browser/browser.h"
#include "tests/integration/process/fixture.h"

#include <csignal>

namespace zoned::testing_browser {

/// Expressions: number of the first entity of a type; where an entity is shown.
inline std::string first_of(const std::string& type) {
    return "[...zoned.entities.slotOf].find(([, slot]) => "
           "zoned.renderer.types[zoned.entities.type(slot)].name === '" +
           type + "')[0]";
}

inline std::string place_of(const std::string& entity) {
    return "zoned.entities.place(zoned.entities.slotOf.get(" + entity +
           "), zoned.clock.shown, zoned.clock.tickSeconds)";
}

class ViewerFixture : public testing_process::Process {
  protected:
    void SetUp() override {
        ASSERT_TRUE(has_browser()) << "chromium is not installed (config/packages.txt)";
        serve();
        browser = std::make_unique<Browser>();
    }

    void serve(const std::string& config = testing_process::minimal()) {
        server =
            start_server({"--set",
                          "recording.file=\"" + testing_process::scratch_folder() + "/run.zrec\"",
                          "--set",
                          "network.admin_port=" + std::to_string(admin_port),
                          "--report",
                          testing_process::scratch_folder() + "/report.json"},
                         config);
        admin_port = testing_process::number_after(server->output(), "admin=");
    }

    /// Another world of the config folder in place of the minimal one.
    void serve_world(const std::string& name) {
        serve_instead(ZONED_SOURCE_DIR "/config/" + name + ".txtpb");
    }

    void serve_instead(const std::string& config) {
        if (server) {
            server->signal(SIGTERM);
            EXPECT_EQ(server->wait(testing_process::kPatience), 0);
        }
        serve(config);
    }

    std::vector<std::string> players(int count, int seconds) const {
        std::vector<std::string> arguments = play(count, seconds);
        arguments.insert(arguments.end(), {"--no-audit", "--no-freeze"});
        return arguments;
    }

    void open_world(const std::string& name) {
        browser->open(address() + "#token=" + token());
        ASSERT_TRUE(browser->wait_until("window.zoned?.counts().state === 'live'",
                                        testing_process::kPatience));
        ASSERT_TRUE(browser->wait_until("document.title === '" + name + ": zoned'"));
        ASSERT_TRUE(browser->wait_until("zoned.counts().frames > 2", testing_process::kPatience));
    }

    static std::string token() {
        return testing_process::read(testing_process::scratch_folder() + "/admin.token")
            .substr(0, 64);
    }

    [[nodiscard]] std::string address() const {
        return "http://127.0.0.1:" + std::to_string(admin_port) + "/";
    }

    void look() {
        browser->open(address() + "#token=" + token());
        ASSERT_TRUE(browser->wait_until("window.zoned?.counts().state === 'live'"))
            << server->errors();
        ASSERT_TRUE(browser->wait_until("zoned.entities.size === 12"));
        ASSERT_TRUE(browser->wait_until("zoned.counts().frames > 2"));
    }

    /// A recording of the world that runs, shown in its place.
    void replay(const std::string& file) {
        browser->open("about:blank");  // a page that is open would complain that its server is gone
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(testing_process::kPatience), 0) << server->errors();
        server = std::make_unique<testing_process::Child>(
            "zoned", std::vector<std::string>{"replay", file, "--serve"});
        ASSERT_TRUE(server->wait_for_output("#token=", testing_process::kPatience))
            << server->errors();
        const std::string said = server->output();
        browser->open(said.substr(said.find("http://"), said.rfind('\n') - said.find("http://")));
    }

    void expect_no_errors() const {
        for (const std::string& error : browser->errors()) {
            ADD_FAILURE() << error;
        }
    }

    std::unique_ptr<testing_process::Child> server;
    std::unique_ptr<Browser> browser;
    int admin_port = 0;
};

}  // namespace zoned::testing_browser
