// The viewer in a real browser, on a live server.
#include "tests/browser/viewer_fixture.h"

namespace zoned::testing_browser {
namespace {

using testing_process::Child;
using testing_process::kPatience;
using testing_process::read;
using testing_process::scratch_folder;

/// How many colours the middle of the canvas has, drawn anew: what is drawn is gone after its task.
constexpr const char* kColours =
    "(() => { zoned.draw(); const gl = zoned.renderer.gl; const w = gl.drawingBufferWidth;"
    " const h = gl.drawingBufferHeight; const p = new Uint8Array(4 * w * h);"
    " gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); const seen = new Set();"
    " for (let i = 0; i < p.length; i += 4) seen.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]);"
    " return seen.size; })()";

class Viewer : public ViewerFixture {};

TEST_F(Viewer, ShowsAWorldThatMoves) {
    look();
    EXPECT_GT(std::stoi(browser->evaluate(kColours)), 6);
    // NPCs that nobody sees move from event to event; players move all the time.
    const Child bots("client-sim", players(2, 120));
    EXPECT_TRUE(browser->wait_until("zoned.entities.size === 14", kPatience)) << bots.errors();
    const std::string at =
        "(() => { const e = zoned.entities; const found = [...e.slotOf].find("
        "([, slot]) => (e.flags(slot) & 2) !== 0); return found && " +
        place_of("found[0]") + ".join(); })()";
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
    const std::string wanderer = place_of(first_of("wanderer"));
    browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = " + wanderer +
                      "; c.distance = 8; c.pitch = 1.2; })()");
    const std::string place =
        "(() => { const a = zoned.renderer.project(" + wanderer + "); return a.x + ' ' + a.y; })()";
    std::istringstream numbers(browser->evaluate(place));
    double x = 0.0;
    double y = 0.0;
    ASSERT_TRUE(numbers >> x >> y);
    browser->click(x, y);
    EXPECT_TRUE(browser->wait_until(
        "/^wanderer \\d+$/.test(document.getElementById('chosen').textContent)"))
        << browser->evaluate("document.getElementById('details').textContent");
    EXPECT_TRUE(
        browser->wait_until("document.getElementById('explain').textContent.includes('walk')"));
    EXPECT_TRUE(browser->wait_until("zoned.overlay.details?.agent.brain === 'wander'"));
    browser->screenshot(scratch_folder() + "/clicked.png");
    expect_no_errors();
}

TEST_F(Viewer, DrawsACityOfSixThousandPeople) {
    serve_world("city");
    browser->open(address() + "#token=" + token());
    ASSERT_TRUE(browser->wait_until("window.zoned?.entities.size > 6000", kPatience));
    // Each frame is sorted, uploaded and drawn to its end, in software on most test machines.
    const std::string frame_ms = browser->evaluate(
        "(() => { const r = zoned.renderer; const p = new Uint8Array(4); const t ="
        " performance.now(); for (let i = 0; i < 10; ++i) { zoned.entities.changed = true;"
        " zoned.draw(); r.gl.readPixels(0, 0, 1, 1, r.gl.RGBA, r.gl.UNSIGNED_BYTE, p); }"
        " return (performance.now() - t) / 10; })()");
    RecordProperty("frame_ms", frame_ms);
    EXPECT_LT(std::stod(frame_ms), 1000.0);
    browser->screenshot(scratch_folder() + "/city.png");
    expect_no_errors();
}

TEST_F(Viewer, FindsFollowsAndFilters) {
    look();
    const std::string crate = browser->evaluate(first_of("crate"));
    browser->evaluate(
        "(() => { const f = document.getElementById('find'); f.focus(); f.value = '" + crate +
        "'; f.dispatchEvent(new Event('input')); document.querySelector('#found button').click();"
        " })()");
    EXPECT_EQ(browser->evaluate("zoned.counts().chosen"), crate);
    EXPECT_EQ(browser->evaluate("document.getElementById('follow').getAttribute('aria-pressed')"),
              "true");
    EXPECT_TRUE(
        browser->wait_until("Math.hypot(...zoned.renderer.camera.target.map((v, i) => v - " +
                            place_of(crate) + "[i])) < 0.01"));
    // Nothing of a hidden type is drawn or picked.
    const std::string pick =
        "zoned.renderer.pick(zoned.entities, zoned.clock, zoned.renderer.project(" +
        place_of(crate) + ").x, zoned.renderer.project(" + place_of(crate) + ").y) >= 0";
    EXPECT_EQ(browser->evaluate(pick), "true");
    browser->evaluate(
        "[...document.querySelectorAll('#types label')].filter(l => "
        "l.textContent.includes('crate'))"
        ".forEach(l => l.querySelector('input').click())");
    EXPECT_EQ(browser->evaluate(pick), "false");
    expect_no_errors();
}

TEST_F(Viewer, ChartsShowFigures) {
    look();
    const Child bots("client-sim", players(4, 120));
    ASSERT_TRUE(browser->wait_until("zoned.entities.size === 16", kPatience)) << bots.errors();
    browser->evaluate("document.getElementById('charts-button').click()");
    ASSERT_TRUE(browser->wait_until("zoned.charts.charts.size === 5"));
    EXPECT_TRUE(browser->wait_until("zoned.charts.charts.get('passes').data.labels.length > 3"));
    const auto largest = [&](const std::string& chart) {
        return "Math.max(...zoned.charts.charts.get('" + chart +
               "').data.datasets.filter(d => d.label !== 'bound').flatMap(d => d.data))";
    };
    EXPECT_TRUE(browser->wait_until(largest("passes") + " > 0"));
    EXPECT_TRUE(browser->wait_until(largest("traffic") + " > 0"));
    EXPECT_TRUE(browser->wait_until(largest("errors") + " > 0"));
    EXPECT_TRUE(browser->wait_until(largest("sessions") + " === 4"));
    EXPECT_LE(std::stod(browser->evaluate(largest("errors"))), 5.0) << "in multiples of the bound";
    browser->screenshot(scratch_folder() + "/charts.png");
    expect_no_errors();
}

TEST_F(Viewer, ShowsWhatAClientWasSentBesideTheTruth) {
    look();
    const Child bots("client-sim", players(4, 120));
    ASSERT_TRUE(browser->wait_until("zoned.entities.size === 16", kPatience)) << bots.errors();
    browser->evaluate("zoned.choose(" + first_of("player") + ")");
    ASSERT_TRUE(browser->wait_until("zoned.overlay.details?.view?.length >= 12"));
    ASSERT_TRUE(browser->wait_until("zoned.overlay.details.view.some(v => v.shown)"));
    EXPECT_EQ(browser->evaluate("zoned.overlay.details.view.filter(v => v.shown).every(v => "
                                "v.error_m <= 3 * v.bound_m + 0.5)"),
              "true");
    EXPECT_TRUE(browser->evaluate("document.getElementById('facts').textContent").find("allowed") !=
                std::string::npos);
    browser->screenshot(scratch_folder() + "/sent.png");
    expect_no_errors();
}

TEST_F(Viewer, StopsAndStepsTheWorldInDevelopment) {
    look();
    EXPECT_EQ(browser->evaluate("document.getElementById('pace').hidden"), "false");
    browser->evaluate("document.getElementById('pause').click()");
    ASSERT_TRUE(browser->wait_until(
        "document.getElementById('pause').getAttribute('aria-pressed') === 'true'"));
    std::string tick;
    for (int i = 0; i < 50 && tick != browser->evaluate("zoned.entities.tick"); ++i) {
        tick = browser->evaluate("zoned.entities.tick");
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
    }
    ASSERT_EQ(browser->evaluate("zoned.entities.tick"), tick);
    browser->evaluate("document.getElementById('step').click()");
    EXPECT_TRUE(browser->wait_until("zoned.entities.tick === 1 + " + tick));
    browser->evaluate("document.getElementById('pause').click()");
    EXPECT_TRUE(browser->wait_until("zoned.entities.tick > 10 + " + tick));
    expect_no_errors();
}

TEST_F(Viewer, DrawsHillsMachinesAndCloth) {
    serve_world("hills");
    open_world("hills");
    EXPECT_TRUE(browser->wait_until(
        "zoned.renderer.geometry.surfaces.length > 0 && zoned.renderer.geometry.drawn.length === "
        "zoned.renderer.geometry.surfaces.length",
        kPatience));
    EXPECT_GT(std::stoi(browser->evaluate(kColours)), 30);
    browser->screenshot(scratch_folder() + "/hills.png");
    serve_world("machines");
    open_world("machines");
    EXPECT_TRUE(browser->wait_until("zoned.layers.joints.length > 0"));
    browser->screenshot(scratch_folder() + "/machines.png");
    serve_world("cloth");
    open_world("cloth");
    EXPECT_TRUE(browser->wait_until(
        "[...zoned.renderer.softs.values()].some(s => s.faces && s.faces.length > 0)"));
    browser->screenshot(scratch_folder() + "/cloth.png");
    for (const std::string& error : browser->errors()) {
        // Between two servers nobody listens.
        EXPECT_NE(error.find("ERR_CONNECTION_REFUSED"), std::string::npos) << error;
    }
}

TEST_F(Viewer, FollowsTheThemeAndFitsAPhone) {
    look();
    const std::string ground =
        "(() => { const r = zoned.renderer; zoned.draw(); const p = new Uint8Array(4);"
        " r.gl.readPixels(0, r.canvas.height - 60, 1, 1, r.gl.RGBA, r.gl.UNSIGNED_BYTE, p);"
        " return p[0]; })()";
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
    EXPECT_EQ(browser->evaluate("zoned.entities.size"), "0");
}

}  // namespace
}  // namespace zoned::testing_browser
