// The viewer in a real browser, on a live server.
#include "tests/browser/viewer_fixture.h"

#include <cstdio>
#include <fstream>
#include <sstream>

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
    // Close to the wanderer, so that nothing else is under the pointer. On a busy machine it has
    // walked away from where the click goes to: then it is clicked again, as people do.
    const std::string wanderer = place_of(first_of("wanderer"));
    const std::string chosen =
        "/^wanderer \\d+$/.test(document.getElementById('chosen').textContent)";
    for (int i = 0; i < 10 && browser->evaluate(chosen) != "true"; ++i) {
        browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = " + wanderer +
                          "; c.distance = 8; c.pitch = 1.2; })()");
        std::istringstream numbers(browser->evaluate("(() => { const a = zoned.renderer.project(" +
                                                     wanderer + "); return a.x + ' ' + a.y; })()"));
        double x = 0.0;
        double y = 0.0;
        ASSERT_TRUE(numbers >> x >> y);
        browser->click(x, y);
        browser->wait_until(chosen, 2.0);
    }
    EXPECT_EQ(browser->evaluate(chosen), "true")
        << browser->evaluate("document.getElementById('details').textContent");
    EXPECT_TRUE(
        browser->wait_until("document.getElementById('explain').textContent.includes('walk')"));
    EXPECT_TRUE(browser->wait_until("zoned.overlay.details?.agent.brain === 'wander'"));
    browser->screenshot(scratch_folder() + "/clicked.png");
    expect_no_errors();
}

/// A shape has at most so many corners of triangles: the round one has five strips around its axis.
constexpr double kShapeCorners = 3.0 * (5 * 2 * 8 - 2 * 8);

/// A box or a door has two triangles on each of its sides, and the ground has two; lines have ends.
constexpr const char* kMostStaticCorners =
    "36 * (zoned.renderer.geometry.boxes.reduce((sum, chunk) => sum + chunk.length / 10, 0)"
    " + zoned.renderer.scene.doors.length) + 6 + zoned.renderer.lines.count";

/// How many corners and points the graphics card is given for one picture, "corners points": what a
/// frame costs, whatever the machine.
constexpr const char* kDrawnPerFrame =
    "(() => { const gl = zoned.renderer.gl; let corners = 0; let points = 0; const methods ="
    " { drawArrays: a => { if (a[0] === gl.POINTS) points += a[2]; else corners += a[2]; },"
    " drawElements: a => { corners += a[1]; }, drawArraysInstanced: a => { corners += a[2] * a[3]; "
    "},"
    " drawElementsInstanced: a => { corners += a[1] * a[4]; } };"
    " for (const [name, count] of Object.entries(methods)) { gl[name] = (...a) => { count(a);"
    " return WebGL2RenderingContext.prototype[name].apply(gl, a); }; }"
    " zoned.draw(); for (const name in methods) delete gl[name];"
    " return corners + ' ' + points; })()";

struct Drawn {
    double corners = 0.0;
    double points = 0.0;
};

/// Most are points, so that a picture's cost is bounded whatever the number of entities.
TEST_F(Viewer, DrawsACityOfSixThousandPeople) {
    serve_world("city");
    open_world("city");
    ASSERT_TRUE(browser->wait_until("zoned.entities.size > 6000", kPatience));
    EXPECT_TRUE(browser->wait_until("zoned.counts().first_picture_ms > 0"));
    EXPECT_GT(std::stoi(browser->evaluate(kColours)), 6);
    const auto drawn = [&] {
        Drawn of;
        std::istringstream(browser->evaluate(kDrawnPerFrame)) >> of.corners >> of.points;
        return of;
    };
    const auto number = [&](const std::string& of) {
        return std::stod(browser->evaluate(of));
    };
    const auto hide_all = [&](const std::string& change) {
        browser->evaluate("zoned.renderer.types.forEach((type, i) => zoned.renderer.hiddenTypes." +
                          change + "(i))");
    };
    const double people = number("zoned.entities.size");
    // From above the whole city, where most are points; then in the middle of a street.
    for (const bool in_street : {false, true}) {
        if (in_street) {
            browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = " +
                              place_of(first_of("stroller")) + "; c.distance = 6; })()");
        }
        const Drawn all = drawn();
        const double shapes = number("zoned.renderer.mostShapes");
        hide_all("add");
        const Drawn without = drawn();
        hide_all("delete");
        EXPECT_EQ(without.points, 0.0);
        EXPECT_LE(without.corners, number(kMostStaticCorners));
        EXPECT_LE(shapes, 1000.0);
        EXPECT_LE(all.corners - without.corners, shapes * kShapeCorners);
        EXPECT_GT(all.points, in_street ? 0.0 : 1000.0);
        EXPECT_LE(all.points, people);
        if (in_street) {
            EXPECT_GT(all.corners, without.corners) << "the nearest are shapes";
        }
    }
    EXPECT_GE(std::stod(browser->evaluate("zoned.renderer.scale")), 0.5);
    browser->screenshot(scratch_folder() + "/city.png");
    expect_no_errors();
}

TEST_F(Viewer, PicturesAreAsLargeAsTheUserSays) {
    look();
    const auto choose_size = [&](const std::string& size) {
        browser->evaluate("(() => { const s = document.getElementById('size'); s.value = '" + size +
                          "'; s.dispatchEvent(new Event('change')); })()");
    };
    const std::string share = "zoned.renderer.canvas.width / zoned.renderer.canvas.clientWidth";
    choose_size("half");
    EXPECT_TRUE(browser->wait_until("Math.abs(" + share + " - 0.5) < 0.01"));
    choose_size("full");
    EXPECT_TRUE(browser->wait_until("Math.abs(" + share + " - 1) < 0.01"));
    // Frames that come late change an automatic size alone, and never below half.
    browser->evaluate("(() => { for (let i = 0; i < 500; ++i) zoned.renderer.adapt(100); })()");
    browser->evaluate("zoned.draw()");
    EXPECT_EQ(browser->evaluate("Math.abs(" + share + " - 1) < 0.01"), "true");
    choose_size("automatic");
    browser->evaluate(
        "(() => { for (let i = 0; i < 500; ++i) zoned.renderer.adapt(100); "
        "zoned.draw(); window.late = " +
        share +
        "; for (let i = 0; i < 2000; ++i) "
        "zoned.renderer.adapt(10); zoned.draw(); window.early = " +
        share + "; })()");
    EXPECT_EQ(browser->evaluate("Math.abs(window.late - 0.5) < 0.01"), "true");
    EXPECT_EQ(browser->evaluate("Math.abs(window.early - 1) < 0.01"), "true");
    expect_no_errors();
}

/// Near ones are shapes and far ones points; both lie where the entity is projected to.
TEST_F(Viewer, PointsLieWhereTheirEntitiesAre) {
    look();
    browser->evaluate("document.getElementById('pause').click()");
    ASSERT_TRUE(browser->wait_until(
        "document.getElementById('pause').getAttribute('aria-pressed') === 'true'"));
    const std::string crate = browser->evaluate(first_of("crate"));
    // The colour of the chosen entity is no other's.
    browser->evaluate("(() => { zoned.choose(" + crate +
                      "); for (const key of Object.keys("
                      "zoned.overlay.shown)) zoned.overlay.shown[key] = false; })()");
    const std::string yellow =
        "(() => { const r = zoned.renderer; const gl = r.gl; r.fixedScale = 1; r.lines.circle = () "
        "=> {}; zoned.draw(); const w = gl.drawingBufferWidth, h = gl.drawingBufferHeight; const p "
        "="
        " new Uint8Array(4 * w * h); gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); let"
        " [n, x, y] = [0, 0, 0]; for (let i = 0; i < p.length; i += 4) if (p[i] > 120 && p[i + 1] >"
        " 110 && p[i + 2] < 0.5 * p[i]) { ++n; x += (i / 4) % w; y += h - 1 - Math.floor(i / 4 / "
        "w);"
        " } const at = r.project(" +
        place_of(crate) +
        "); return n > 0 && Math.hypot(x / n - at.x, "
        "y / n - at.y) < 4; })()";
    for (const char* distance : {"6", "30", "400"}) {
        browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = " +
                          place_of(crate) + "; c.distance = " + distance + "; c.pitch = 1.2; })()");
        EXPECT_EQ(browser->evaluate(yellow), "true") << distance << " m away";
    }
    browser->evaluate("document.getElementById('pause').click()");
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
    // The banner has four times as many vertices as nodes, each where its nodes are.
    EXPECT_TRUE(browser->wait_until(
        "[...zoned.renderer.softs.values()].some(s => s.places.length > 4 * s.nodes.length && "
        "[0, 1, 2].every(k => { const at = list => list.filter((_, i) => i % 3 === k); "
        "return Math.max(...at(s.places)) < Math.max(...at(s.nodes)) + 0.1 && "
        "Math.min(...at(s.places)) > Math.min(...at(s.nodes)) - 0.1; }))"));
    browser->screenshot(scratch_folder() + "/cloth.png");
    for (const std::string& error : browser->errors()) {
        // Between two servers nobody listens.
        EXPECT_NE(error.find("ERR_CONNECTION_REFUSED"), std::string::npos) << error;
    }
}

/// Many walk through a gate to one place, around each other.
constexpr const char* kGate = R"(
world { name: "gate" seed: 9 tick_rate_hz: 30 min_x_m: -40 min_z_m: -30 max_x_m: 40 max_z_m: 30 }
zones { zone_grid { columns: 1 rows: 1 } ghost_margin_m: 70 }
ai { suspend_offscreen: false pathfinding { cell_m: 0.5 crowding { jam_per_m2: 1.6 } } }
statics {
  box { x_m: 0 y_m: 1 z_m: -16 size { x_m: 0.5 y_m: 2 z_m: 28 } }
  box { x_m: 0 y_m: 1 z_m: 16 size { x_m: 0.5 y_m: 2 z_m: 28 } }
}
point_of_interest { name: "there" x_m: 26 z_m: 0 radius_m: 12 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 30 } nimbus_m { normal: 30 } character { speed_mps: 3 } }
type { name: "walker" base: "player" brain: "walk" }
brain { name: "walk" state { name: "go" action: GO point_of_interest: "there" } }
scatter { type: "walker" count: 100 seed: 5 region { min_x_m: -30 min_z_m: -20 max_x_m: -20 max_z_m: 20 } statics_allowed: false }
spawn { x_m: -38 z_m: -28 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
network { tcp_port: 0 udp_port: 0 }
session { dev_mode_loopback: true }
)";

TEST_F(Viewer, DrawsDoorsAndPlatformsWhereRulesHaveMovedThem) {
    const std::string folder = scratch_folder();
    std::ofstream(folder + "/gates.lua")
        << "function on_join() set_door('gate', true, 0.5) move_platform('lift', 1, 0.5) end\n";
    std::ofstream(folder + "/gates.txtpb") << R"(
world { name: "gates" }
zones { zone_grid { columns: 1 rows: 1 } }
spawn { x_m: 0 z_m: -9 }
lod { position_bound_m: 0.05 orientation_bound_rad: 0.1 }
script { file: "gates.lua" avatar: "player" }
door { name: "post" moved_by: RULES box { x_m: 9 y_m: 1 z_m: 0 size { x_m: 1 y_m: 2 z_m: 1 } } }
door { name: "gate" moved_by: RULES box { x_m: 5 y_m: 1 z_m: 0 size { x_m: 1 y_m: 2 z_m: 3 } } }
platform {
  name: "ferry" speed_mps: 1
  box { x_m: -9 y_m: 0.15 z_m: 0 size { x_m: 2 y_m: 0.2 z_m: 2 } }
  stop { x_m: -9 y_m: 0.15 z_m: 8 }
}
platform {
  name: "lift" moved_by: RULES speed_mps: 2
  box { x_m: -5 y_m: 0.15 z_m: 0 size { x_m: 2 y_m: 0.2 z_m: 2 } }
  stop { x_m: -5 y_m: 4.15 z_m: 0 }
}
type {
  name: "player" kind: CHARACTER
  capsule { radius_m: 0.4 length_m: 1 } mass_kg: 80 aura_m { normal: 60 } nimbus_m { normal: 60 } character { }
}
session { dev_mode_loopback: true }
)";
    serve_instead(folder + "/gates.txtpb");
    ASSERT_GT(admin_port, 0);
    open_world("gates");
    const std::string shut = "zoned.renderer.shutDoors";
    const std::string lift = "Number(zoned.renderer.movedTo.split(',')[11])";  // y of the second
    EXPECT_TRUE(browser->wait_until(shut + " === 'post,gate'"));
    EXPECT_TRUE(browser->wait_until("Math.abs(" + lift + " - 0.15) < 1e-5"))
        << browser->evaluate(lift);
    const Child bot("client-sim", players(1, 60));
    EXPECT_TRUE(browser->wait_until(shut + " === 'post'", kPatience)) << bot.errors();
    EXPECT_TRUE(browser->wait_until("Math.abs(" + lift + " - 4.15) < 1e-5", kPatience))
        << browser->evaluate(lift);
    // A page that is opened later shows the same.
    open_world("gates");
    EXPECT_TRUE(browser->wait_until(shut + " === 'post'"));
    EXPECT_TRUE(browser->wait_until("Math.abs(" + lift + " - 4.15) < 1e-5"));
    expect_no_errors();
}

TEST_F(Viewer, DrawsTheFlowFieldToAGoalThatManyShare) {
    const std::string config = scratch_folder() + "/gate.txtpb";
    std::ofstream(config) << kGate;
    serve_instead(config);
    open_world("gate");
    browser->evaluate("(() => { zoned.choose(" + first_of("walker") +
                      "); [...document.querySelectorAll('#layers label')].filter(l =>"
                      " l.textContent.includes('flow field')).forEach(l =>"
                      " l.querySelector('input').click()); })()");
    ASSERT_TRUE(browser->wait_until("zoned.overlay.flow.length > 6000", kPatience))
        << browser->evaluate("document.getElementById('facts').textContent");
    const std::string said =
        "document.getElementById('facts').textContent.includes('leads to its goal')";
    EXPECT_TRUE(browser->wait_until(said));
    // It stays there while the panel is filled anew.
    EXPECT_FALSE(browser->wait_until("!" + said, 2.0));
    // Left of the wall the steps lead right, through the gate.
    EXPECT_EQ(browser->evaluate("(() => { const f = zoned.overlay.flow; let [right, all] = [0, 0];"
                                " for (let i = 0; i < f.length; i += 6) { if (f[i] > -15 && f[i] <"
                                " -5 && Math.abs(f[i + 2]) < 8) { ++all; right += f[i + 3] > f[i] ?"
                                " 1 : 0; } } return all > 100 && right > 0.9 * all; })()"),
              "true");
    browser->screenshot(scratch_folder() + "/flow.png");
    expect_no_errors();
}

TEST_F(Viewer, GoesToAnyTickOfARecording) {
    look();
    {
        Child bots("client-sim", players(2, 5));
        EXPECT_NE(bots.wait(kPatience), -1) << bots.output();
    }
    ASSERT_NO_FATAL_FAILURE(replay(scratch_folder() + "/run.zrec"));
    ASSERT_TRUE(browser->wait_until("window.zoned?.counts().state === 'live'"));
    EXPECT_EQ(browser->evaluate("document.getElementById('replay').hidden"), "false");
    const int last = std::stoi(browser->evaluate("document.getElementById('slider').max"));
    ASSERT_GT(last, 100);
    ASSERT_TRUE(browser->wait_until("zoned.entities.tick > 3"));
    browser->evaluate("document.getElementById('pause').click()");
    ASSERT_TRUE(browser->wait_until(
        "document.getElementById('pause').getAttribute('aria-pressed') === 'true'"));
    const auto slide = [&](int tick) {
        browser->evaluate("(() => { const s = document.getElementById('slider'); s.value = " +
                          std::to_string(tick) +
                          "; s.dispatchEvent(new Event('input')); s.dispatchEvent(new "
                          "Event('change')); })()");
        EXPECT_TRUE(browser->wait_until("zoned.entities.tick === " + std::to_string(tick)))
            << browser->evaluate("zoned.entities.tick");
    };
    const std::string wanderer = browser->evaluate(first_of("wanderer"));
    slide(last - 5);
    EXPECT_TRUE(browser->wait_until("document.getElementById('slider-tick').textContent === '" +
                                    std::to_string(last - 5) + " of " + std::to_string(last) + "'"))
        << browser->evaluate("document.getElementById('slider-tick').textContent");
    // The nearer the eye, the truer is its place.
    const std::string place = "zoned.entities.place(zoned.entities.slotOf.get(" + wanderer +
                              "), zoned.entities.tick, zoned.clock.tickSeconds)";
    browser->evaluate("(() => { window.late = " + place + "; })()");
    slide(1);
    slide(last - 5);
    EXPECT_TRUE(
        browser->wait_until("Math.hypot(..." + place + ".map((v, i) => v - window.late[i])) < 0.1"))
        << browser->evaluate(place) << " was " << browser->evaluate("window.late");
    browser->screenshot(scratch_folder() + "/replay.png");
    expect_no_errors();
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
