// How well the page to play on draws and predicts: figures for people, run by hand on a machine
// with nothing else to do (tests/bench/README.md holds them).
#include "tests/browser/play_fixture.h"
#include "tests/browser/slow_path.h"

#include <cstdio>
#include <optional>

namespace zoned::testing_browser {
namespace {

using testing_process::kPatience;

/// Two quantiles of an array of numbers, as a text of the page.
std::string quantiles(const std::string& numbers) {
    return "(() => { const s = [..." + numbers +
           "].sort((a, b) => a - b); const at = (p) => s[Math.min(s.length - 1, Math.floor(p * "
           "s.length))]; return `p50 ${at(0.5).toFixed(4)} p99 ${at(0.99).toFixed(4)} max "
           "${s.at(-1).toFixed(4)} of ${s.length}`; "
           "})()";
}

class PlayFigures : public PlayFixture {
  protected:
    /// Keys as of a person that walks, turns and jumps.
    void wander(double seconds) {
        const std::vector<std::pair<std::string, std::string>> keys{
            {"KeyW", "w"}, {"KeyA", "a"}, {"KeyS", "s"}, {"KeyD", "d"}};
        for (int i = 0; 0.7 * i < seconds; ++i) {
            const auto& [code, name] = keys[static_cast<std::size_t>(i * i + i / 3) % keys.size()];
            browser->evaluate("zoned.controls.turn(" + std::to_string(150 * (i % 5 - 2)) + ", 0)");
            hold(code, name, 0.6);
            if (i % 4 == 3) {
                hold("Space", " ", 0.1);
            }
        }
    }

    /// Corrections of the own avatar over a path of the page's WebSocket.
    void print_corrections(const std::string& name, const SlowPath::PathSettings& path) {
        start_anew({});
        const SlowPath slow(websocket_port, path);
        browser->ignore_policies();
        open_page();
        browser->evaluate("zoned.page.told.websocket_port = " + std::to_string(slow.port()));
        log_in("ann");
        std::this_thread::sleep_for(std::chrono::seconds(3));  // the clock settles
        browser->evaluate(
            "(() => { window.corrections = []; let seen = zoned.stats().corrections; "
            "setInterval(() => { const s = zoned.stats(); if (s && s.corrections !== seen) { seen "
            "= s.corrections; window.corrections.push(s.correctionM); } }, 20); })()");
        const double missing = stat("inputsMissing");
        const double inputs = stat("inputs");
        wander(60.0);
        std::printf(
            "correction over WebSocket, %s: %s m; round trip %.0f ms, lead %.0f ms, "
            "inputs missing %.2f %%; %.0f states judged, %.0f beyond their bound; %s\n",
            name.c_str(),
            browser->evaluate(quantiles("window.corrections")).c_str(),
            stat("rttMs"),
            stat("leadMs"),
            100.0 * (stat("inputsMissing") - missing) / (stat("inputs") - inputs),
            stat("judged"),
            stat("beyond"),
            verdict().c_str());
        EXPECT_GT(stat("corrections"), 50.0);
        expect_no_errors();
    }
};

TEST_F(PlayFigures, FrameTimesOfThreeHundredEntities) {
    // Walkers and crates, each seen from anywhere.
    std::vector<std::string> crowd{"scatter[1].count=290",
                                   "type[0].nimbus_m.normal=200",
                                   "type[1].aura_m.normal=200",
                                   "type[2].aura_m.normal=200"};
    for (int i = 0; i < 3; ++i) {
        const std::string spawn = "spawn[" + std::to_string(i) + "].";
        crowd.insert(crowd.end(), {spawn + "x_m=-40", spawn + "z_m=-40"});
    }
    start_anew(crowd);
    enter();
    ASSERT_TRUE(browser->wait_until("zoned.counts().entities >= 300", kPatience));
    // From a corner all are before the eye.
    browser->evaluate(
        "(() => { zoned.controls.yaw = Math.PI / 4; zoned.renderer.fixedScale = 0.5; "
        "window.spans = []; let before = 0; const note = (now) => { if (before) { "
        "window.spans.push(now - before); } before = now; requestAnimationFrame(note); }; "
        "setTimeout(() => requestAnimationFrame(note), 3000); })()");
    ASSERT_TRUE(browser->wait_until("window.spans.length >= 600", kPatience));
    const std::string paced = browser->evaluate(quantiles("window.spans"));
    const std::string whole = browser->evaluate(
        "(() => { const { gl } = zoned.renderer; const pixel = new Uint8Array(4); window.times = "
        "[]; for (let i = 0; i < 300; ++i) { const t = performance.now(); zoned.frame(); "
        "gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); "
        "window.times.push(performance.now() - t); } return " +
        quantiles("window.times") + "; })()");
    std::printf(
        "play, %s entities at half size: from frame to frame %s ms; a frame to its end %s "
        "ms\n",
        browser->evaluate("zoned.counts().entities").c_str(),
        paced.c_str(),
        whole.c_str());
    expect_no_errors();
}

TEST_F(PlayFigures, CorrectionsOnAShortPath) {
    print_corrections("short path", {});
}

TEST_F(PlayFigures, CorrectionsOnALongPath) {
    print_corrections("120 ms", {0.060});
}

TEST_F(PlayFigures, CorrectionsOnALongPathWithLoss) {
    print_corrections("120 ms, 5 % sent again", {0.060, 0.05});
}

}  // namespace
}  // namespace zoned::testing_browser
