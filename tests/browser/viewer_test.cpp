// The viewer in a real browser, on a live server.
#include "tests/browser/browser.h"
#include "tests/integration/process/fixture.h"

#include <chrono>
#include <csignal>
#include <thread>

namespace zoned::testing_browser {
namespace {

using testing_process::Child;
using testing_process::kPatience;
using testing_process::number_after;
using testing_process::read;
using testing_process::scratch_folder;

/// How many colours the middle of the canvas has, drawn anew: what is drawn is gone after its task.
constexpr const char* kColours =
    "(() => { const r = zoned.renderer; r.draw(); const gl = r.gl; const w = gl.drawingBufferWidth;"
    " const h = gl.drawingBufferHeight; const p = new Uint8Array(4 * w * h);"
    " gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); const seen = new Set();"
    " for (let i = 0; i < p.length; i += 4) seen.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]);"
    " return seen.size; })()";
constexpr const char* kWanderer =
    "[...zoned.entities.rows.values()].find(r => zoned.renderer.types[r.type].name === 'wanderer')";

class Viewer : public testing_process::Process {
  protected:
    void SetUp() override {
        if (!has_browser()) {
            GTEST_SKIP() << "chromium is not installed (config/packages.txt)";
        }
        serve();
        browser = std::make_unique<Browser>();
    }

    void serve() {
        server = start_server({"--set", "network.admin_port=" + std::to_string(admin_port)});
        admin_port = number_after(server->output(), "admin=");
    }

    static std::string token() { return read(scratch_folder() + "/admin.token").substr(0, 64); }

    [[nodiscard]] std::string address() const {
        return "http://127.0.0.1:" + std::to_string(admin_port) + "/";
    }

    void look() {
        browser->open(address() + "#token=" + token());
        ASSERT_TRUE(browser->wait_until("window.zoned?.counts().state === 'live'"))
            << server->errors();
        ASSERT_TRUE(browser->wait_until("zoned.entities.rows.size === 12"));
        ASSERT_TRUE(browser->wait_until("zoned.counts().frames > 2"));
    }

    void expect_no_errors() const {
        for (const std::string& error : browser->errors()) {
            ADD_FAILURE() << error;
        }
    }

    std::unique_ptr<Child> server;
    std::unique_ptr<Browser> browser;
    int admin_port = 0;
};

TEST_F(Viewer, ShowsAWorldThatMoves) {
    look();
    EXPECT_GT(std::stoi(browser->evaluate(kColours)), 6);
    // NPCs that nobody sees move from event to event; players move all the time.
    std::vector<std::string> arguments = play(2, 120);
    arguments.insert(arguments.end(), {"--no-audit", "--no-freeze"});
    const Child players("client-sim", arguments);
    EXPECT_TRUE(browser->wait_until("zoned.entities.rows.size === 14", kPatience))
        << players.errors();
    const std::string at =
        "[...zoned.entities.rows.values()].find(r => (r.flags & 2) !== 0)?.p.join()";
    const std::string before = browser->evaluate(at);
    EXPECT_TRUE(browser->wait_until(at + " !== '" + before + "'"));
    const std::string updates = browser->evaluate("zoned.counts().updates");
    EXPECT_TRUE(browser->wait_until("zoned.counts().updates > 20 + " + updates));
    EXPECT_EQ(browser->evaluate("document.title"), "minimal: zoned");
    EXPECT_EQ(browser->evaluate("location.hash"), "") << "the token stays in the address";
    browser->screenshot(scratch_folder() + "/viewer.png");
    EXPECT_GT(read(scratch_folder() + "/viewer.png").size(), 10000U);
    expect_no_errors();
}

TEST_F(Viewer, ExplainsWhatIsClicked) {
    look();
    // Close to the wanderer, so that nothing else is under the pointer.
    browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = [..." +
                      std::string(kWanderer) + ".p]; c.distance = 8; c.pitch = 1.2; })()");
    const std::string place = "(() => { const a = zoned.renderer.project(" +
                              std::string(kWanderer) + "); return a.x + ' ' + a.y; })()";
    std::istringstream numbers(browser->evaluate(place));
    double x = 0.0;
    double y = 0.0;
    ASSERT_TRUE(numbers >> x >> y);
    browser->click(x, y);
    EXPECT_TRUE(browser->wait_until(
        "/^wanderer \\d+, zone 1/.test(document.getElementById('details').textContent)"))
        << browser->evaluate("document.getElementById('details').textContent");
    EXPECT_TRUE(
        browser->wait_until("document.getElementById('details').textContent.includes('wander')"));
    browser->screenshot(scratch_folder() + "/clicked.png");
    expect_no_errors();
}

TEST_F(Viewer, DrawsACityOfSixThousandPeople) {
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    Child city("zoned",
               {"serve",
                "--config",
                ZONED_SOURCE_DIR "/config/city.txtpb",
                "--set",
                testing_process::state_set(),
                "--set",
                "network.admin_port=" + std::to_string(admin_port)});
    ASSERT_TRUE(city.wait_for_output("ready ", 2.0 * kPatience)) << city.errors();
    browser->open(address() + "#token=" + token());
    ASSERT_TRUE(browser->wait_until("window.zoned?.entities.rows.size > 6000", kPatience));
    // Each frame is sorted, uploaded and drawn to its end, in software on most test machines.
    const std::string frame_ms = browser->evaluate(
        "(() => { const r = zoned.renderer; const p = new Uint8Array(4); const t ="
        " performance.now(); for (let i = 0; i < 10; ++i) { r.place(zoned.entities, 0); r.draw();"
        " r.gl.readPixels(0, 0, 1, 1, r.gl.RGBA, r.gl.UNSIGNED_BYTE, p); }"
        " return (performance.now() - t) / 10; })()");
    RecordProperty("frame_ms", frame_ms);
    EXPECT_LT(std::stod(frame_ms), 1000.0);
    browser->screenshot(scratch_folder() + "/city.png");
    expect_no_errors();
}

TEST_F(Viewer, FollowsTheThemeAndFitsAPhone) {
    look();
    const std::string ground =
        "(() => { const r = zoned.renderer; r.draw(); const p = new Uint8Array(4);"
        " r.gl.readPixels(0, 0, 1, 1, r.gl.RGBA, r.gl.UNSIGNED_BYTE, p); return p[0]; })()";
    browser->set_dark(false);
    EXPECT_GT(std::stoi(browser->evaluate(ground)), 180);
    browser->set_dark(true);
    EXPECT_LT(std::stoi(browser->evaluate(ground)), 60);
    browser->set_size(360, 640);
    EXPECT_TRUE(browser->wait_until("document.documentElement.scrollWidth <= 360"));
    browser->evaluate("document.getElementById('above').click()");
    EXPECT_EQ(browser->evaluate("zoned.renderer.camera.above"), "true");
    EXPECT_EQ(browser->evaluate("document.getElementById('above').getAttribute('aria-pressed')"),
              "true");
    expect_no_errors();
}

TEST_F(Viewer, ComesBackAfterARestart) {
    look();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    EXPECT_TRUE(browser->wait_until("zoned.counts().state !== 'live'"));
    serve();
    EXPECT_TRUE(browser->wait_until("zoned.counts().state === 'live'"));
    const std::string updates = browser->evaluate("zoned.counts().updates");
    EXPECT_TRUE(browser->wait_until("zoned.counts().updates > 5 + " + updates));
}

TEST_F(Viewer, AsksForATokenAndShowsNothingWithAWrongOne) {
    browser->open(address());
    EXPECT_TRUE(browser->wait_until("!document.getElementById('login').hidden"));
    browser->evaluate(
        "(() => { document.getElementById('token').value = 'wrong';"
        " document.querySelector('#login button').click(); })()");
    EXPECT_TRUE(browser->wait_until("zoned.counts().state.startsWith('no connection')"));
    EXPECT_EQ(browser->evaluate("zoned.entities.rows.size"), "0");
}

}  // namespace
}  // namespace zoned::testing_browser
