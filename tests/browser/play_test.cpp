// A person plays in a real browser on a live server, among bots.
#include "tests/browser/play_fixture.h"

#include <cstdio>

namespace zoned::testing_browser {
namespace {

using testing_process::Child;
using testing_process::kPatience;
using testing_process::scratch_folder;

/// Expression: distance, slot and place of the nearest car's body, or undefined.
const std::string kNearestCar =
    "[...zoned.entities.slotOf.values()].filter((slot) => zoned.page.seats[zoned.entities.type("
    "slot)] > 0).map((slot) => { const at = zoned.entities.place(slot, zoned.entities.tick, 1 / "
    "30); const [x, , z] = zoned.own().position; return [Math.hypot(at[0] - x, at[2] - z), slot, "
    "at]; }).sort((a, b) => a[0] - b[0])[0]";

class Play : public PlayFixture {
  protected:
    /// By W, with a look at it again and again.
    void walk_to_nearest_car() {
        browser->key("KeyW", "w", true);
        const std::string near =
            "(() => { const car = " + kNearestCar +
            "; const [x, , z] = zoned.own().position; zoned.controls.yaw = Math.atan2(car[2][0] - "
            "x, car[2][2] - z); return Math.hypot(car[2][0] - x, car[2][2] - z) < 2.5; })()";
        EXPECT_TRUE(browser->wait_until(near));
        browser->key("KeyW", "w", false);
    }
};

TEST_F(Play, KeysMoveTheAvatarAsTheServerSaysAmongFiftyBots) {
    // Shots would send the avatar elsewhere, which is no error of its prediction.
    std::vector<std::string> peaceful = play(50, 25);
    peaceful.insert(peaceful.end(), {"--behaviour", "wander"});
    Child bots("client-sim", peaceful);
    enter();
    EXPECT_TRUE(browser->wait_until("zoned.counts().entities >= 50", kPatience)) << bots.errors();
    // Upright types are turned about the vertical axis alone.
    EXPECT_EQ(browser->evaluate(
                  "(() => { const types = zoned.page.client.types(); return "
                  "[...zoned.entities.slotOf.values()].filter((slot) => "
                  "types[zoned.entities.type(slot)].upright).every((slot) => { const [x, , z] = "
                  "zoned.entities.orientation(slot); return Math.abs(x) + Math.abs(z) < 1e-3; }); "
                  "})()"),
              "true");
    const std::vector<double> before = own();
    const int frames = std::stoi(browser->evaluate("zoned.counts().frames"));
    // Towards the middle of the world, wherever the avatar was born: walls stop nobody there.
    browser->evaluate(
        "(() => { const [x, , z] = zoned.own().position; zoned.controls.yaw = Math.atan2(-x, -z); "
        "})()");
    hold("KeyW", "w", 1.5);
    hold("KeyD", "d", 1.0);
    EXPECT_GT(distance(own(), before), 2.0);
    wait_until_both_agree();
    const double ground = own().at(1);
    browser->key("Space", " ", true);
    EXPECT_TRUE(browser->wait_until("zoned.own().position[1] > " + std::to_string(ground + 0.3)));
    browser->key("Space", " ", false);
    EXPECT_TRUE(browser->wait_until("zoned.stats().corrections > 20", kPatience));
    expect_consistent(bots);
    expect_consistent_page(500);
    std::printf("play: %s\n", browser->evaluate("JSON.stringify(zoned.stats())").c_str());
    EXPECT_TRUE(browser->wait_until(
        "document.getElementById('figures').textContent.includes('0 beyond their bound: "
        "consistent')"));
    // Where a starved browser's input was missing, the server played the one before it once more:
    // 5 m/s for a tick of 1/30 s, at most in the other direction.
    EXPECT_LT(stat("correctionM_p99"), 0.01 + stat("inputsMissing") * 2.0 * 5.0 / 30.0);
    EXPECT_LT(stat("displayedM_p50"), 0.3);
    EXPECT_GT(stat("displayedM_p50"), 0.0);
    EXPECT_EQ(stat("malformed"), 0.0);
    EXPECT_GT(std::stoi(browser->evaluate("zoned.counts().frames")), frames + 20);
    browser->screenshot(scratch_folder() + "/play.png");
    EXPECT_GT(testing_process::read(scratch_folder() + "/play.png").size(), 10000U);
    expect_no_errors();
}

TEST_F(Play, VerdictFindsFaultsOfTheServer) {
    const std::vector<std::pair<std::string, std::string>> faults{
        {"testing.corrupt_position.probability=0.2", "bound: "},
        {"testing.hide_entity.probability=0.5", "missing: "},
        {"testing.wrong_clock=0.01", "shared environment: "}};
    for (const auto& [setting, reason] : faults) {
        start_anew({setting, "environment.clock[0].name=day", "environment.clock[0].period=24"});
        enter();
        EXPECT_TRUE(browser->wait_until("zoned.stats().verdict.includes('" + reason + "')"))
            << setting << ": " << browser->evaluate("JSON.stringify(zoned.stats())");
        EXPECT_EQ(verdict().rfind("inconsistent", 0), 0U) << verdict();
    }
    expect_no_errors();
}

TEST_F(Play, RidesTheNearestVehicleAndDrivesItByTheSameKeys) {
    start_anew({}, ZONED_SOURCE_DIR "/config/machines.txtpb");
    enter();
    ASSERT_TRUE(browser->wait_until(kNearestCar + " !== undefined", kPatience));
    walk_to_nearest_car();
    hold("KeyR", "r", 0.05);
    ASSERT_TRUE(browser->wait_until("zoned.own().carried"))
        << browser->evaluate("document.getElementById('lines').textContent");
    // It looks to where the car points, and goes ahead.
    browser->evaluate("(() => { const [x, y, z, w] = zoned.entities.orientation(" + kNearestCar +
                      "[1]); zoned.controls.yaw = Math.atan2(2 * (x * z + w * y), 1 - 2 * (x * x "
                      "+ y * y)); })()");
    const std::vector<double> before = own();
    // The seat is where no prediction was: the state after it says nothing of driving.
    const std::string begun = browser->evaluate("zoned.stats().corrections");
    EXPECT_TRUE(browser->wait_until("zoned.stats().corrections > 2 + " + begun));
    browser->evaluate(
        "(() => { window.worst = 0; setInterval(() => { window.worst = Math.max(window.worst, "
        "zoned.stats()?.correctionM ?? 0); }, 30); })()");
    hold("KeyW", "w", 2.0);
    const std::vector<double> after = own();
    const double worst = std::stod(browser->evaluate("window.worst"));
    std::printf(
        "play: drove %.1f m, corrected by %.2f m at most\n", distance(after, before), worst);
    EXPECT_GT(distance(after, before), 3.0);
    // A rider is predicted straight on from its newest state; the client does not simulate cars.
    EXPECT_LT(worst, 1.0);
    EXPECT_LT(distance(after, truth()), 3.0);  // of a moment later
    hold("KeyR", "r", 0.05);
    EXPECT_TRUE(browser->wait_until("!zoned.own().carried"));
    wait_until_both_agree();
    expect_consistent_page(100);
    // Far from all vehicles the key says so.
    browser->evaluate("zoned.page.seats.fill(0)");
    hold("KeyR", "r", 0.05);
    EXPECT_TRUE(browser->wait_until(
        "document.getElementById('lines').textContent.includes('nothing near to ride on')"));
    expect_no_errors();
}

/// The curtain's middle sinks between its two pins, and those are where the world's file has them.
TEST_F(Play, SeesSoftBodiesAsTheyAreDeformed) {
    start_anew({}, ZONED_SOURCE_DIR "/config/cloth.txtpb");
    enter();
    const std::string curtain =
        "(() => { const type = zoned.page.client.types().findIndex(({ name }) => name === "
        "'curtain'); const soft = [...zoned.renderer.softs.values()].find((s) => s.type === type); "
        "if (!soft) { return null; } const at = (i) => [...soft.places.subarray(3 * i, 3 * i + "
        "3)]; "
        "return [at(0), at(8), at(16)].flat(); })()";
    ASSERT_TRUE(browser->wait_until(curtain + " !== null", kPatience));
    EXPECT_TRUE(browser->wait_until(
        "(() => { const p = " + curtain + "; return p[4] < p[1] - 0.02; })()", kPatience))
        << browser->evaluate("JSON.stringify(" + curtain + ")");
    const std::vector<double> row = numbers(browser->evaluate("JSON.stringify(" + curtain + ")"));
    ASSERT_EQ(row.size(), 9U);
    // The bound of its shape, of its place, and of its turn at 2.4 m from the centre.
    const double bound = 0.07 + 0.05 + 0.1 * 2.4;
    EXPECT_LT(std::hypot(row[0] + 10.0, row[1] - 2.8, row[2] + 6.0), bound);
    EXPECT_LT(std::hypot(row[6] + 6.0, row[7] - 2.8, row[8] + 6.0), bound);
    EXPECT_EQ(browser->evaluate("[...zoned.renderer.softs.values()].every(({ places, faces }) => "
                                "faces.length > 0 && places.every(Number.isFinite))"),
              "true");
    EXPECT_EQ(browser->evaluate("zoned.renderer.lines.count > 0"), "true") << "the rope";
    browser->screenshot(scratch_folder() + "/soft.png");
    expect_no_errors();
}

TEST_F(Play, ChatsAndComesBackAfterACut) {
    enter();
    hold("Enter", "Enter", 0.05);
    ASSERT_TRUE(browser->wait_until("!document.getElementById('say').hidden"));
    browser->evaluate(
        "(() => { document.getElementById('text').value = 'good day'; "
        "document.getElementById('say').requestSubmit(); })()");
    EXPECT_TRUE(browser->wait_until(
        "document.getElementById('lines').textContent.includes('ann: good day')"))
        << browser->evaluate("document.getElementById('lines').textContent");
    const std::string id = browser->evaluate("zoned.own().id");
    browser->evaluate("zoned.cut()");
    EXPECT_TRUE(browser->wait_until("zoned.stats().resumed === 1 && zoned.counts().state === 2",
                                    kPatience));
    EXPECT_EQ(browser->evaluate("zoned.own().id"), id);
    // Shots, pushes and what is out of reach end in no error of the page.
    browser->evaluate("['shoot', 'push', 'pick_up', 'throw', 'view'].forEach(zoned.act)");
    browser->evaluate("document.getElementById('leave').click()");
    EXPECT_TRUE(browser->wait_until("!document.getElementById('enter').hidden"));
    expect_no_errors();
}

TEST_F(Play, PagesOfOtherSitesCannotConnect) {
    // A page without an address has the origin "null".
    browser->evaluate(
        "(() => { const s = new WebSocket('ws://127.0.0.1:" + std::to_string(websocket_port) +
        "/', ['zoned']); s.onopen = () => { window.outcome = 'open'; }; "
        "s.onclose = () => { window.outcome = window.outcome || 'closed'; }; })()");
    EXPECT_TRUE(browser->wait_until("window.outcome === 'closed'"));
    open_page();
    EXPECT_EQ(
        browser->evaluate("fetch('metrics').then((a) => a.text()).then((t) => "
                          "t.includes('zoned_websocket_refused_total{reason=\"origin\"} 1'))"),
        "true");
    // The page's own origin may, by each of its names.
    enter();
}

TEST_F(Play, SaysWhyALoginIsRefused) {
    open_page();
    browser->evaluate(
        "(() => { document.getElementById('name').value = 'x'; zoned.page.told.websocket_port = "
        "location.port; "
        "document.getElementById('enter').requestSubmit(); })()");
    EXPECT_TRUE(browser->wait_until(
        "document.getElementById('trouble').textContent.includes('lost or refused')", kPatience))
        << browser->evaluate("document.getElementById('trouble').textContent");
}

}  // namespace
}  // namespace zoned::testing_browser
