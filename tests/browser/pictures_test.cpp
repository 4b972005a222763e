// The pictures of the front page, made of live worlds. They are written where ZONED_PICTURES says,
// in a test run to the scratch folder.
#include "tests/browser/browser.h"
#include "tests/browser/viewer_fixture.h"

#include <cstdlib>

namespace zoned::testing_browser {
namespace {

class Pictures : public ViewerFixture {
  protected:
    void SetUp() override {
        ViewerFixture::SetUp();
        if (!HasFatalFailure()) {
            browser->set_size(1000, 560);
        }
    }

    void look_at(double x, double y, double z, double distance, double yaw, double pitch) {
        browser->evaluate("(() => { const c = zoned.renderer.camera; c.target = [" +
                          std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z) +
                          "]; c.distance = " + std::to_string(distance) + "; c.yaw = " +
                          std::to_string(yaw) + "; c.pitch = " + std::to_string(pitch) + "; })()");
    }

    /// At full size, however slow the machine is.
    void shoot(const std::string& name) {
        browser->evaluate(
            "(() => { const r = zoned.renderer; r.adapt = () => {}; r.scale = 1; r.mostShapes ="
            " 1000; })()");
        const std::string frames = browser->evaluate("zoned.counts().frames");
        ASSERT_TRUE(browser->wait_until("zoned.counts().frames > 5 + " + frames));
        const char* folder = std::getenv("ZONED_PICTURES");
        const std::string file =
            (folder != nullptr ? folder : testing_process::scratch_folder()) + "/" + name;
        browser->screenshot(file);
        EXPECT_GT(testing_process::read(file).size(), 20000U);
        EXPECT_LT(testing_process::read(file).size(), 250000U);
    }
};

TEST_F(Pictures, CityWithAnAgentThatExplainsItself) {
    serve_world("city");
    open_world("city");
    const testing_process::Child bots("client-sim", players(20, 120));
    ASSERT_TRUE(browser->wait_until("zoned.entities.size > 6100", testing_process::kPatience));
    ASSERT_TRUE(browser->wait_until(
        "(() => { const e = zoned.entities; return [...e.slotOf.values()].filter(s => (e.flags(s) &"
        " 2) !== 0).length >= 20; })()",
        testing_process::kPatience))
        << bots.errors();
    // An agent that walks near a player: such a one is simulated, and has a path.
    const std::string agent = browser->evaluate(
        "(() => { const e = zoned.entities; const walks = [...e.slotOf].filter(([, s]) => "
        "zoned.renderer.types[e.type(s)].character && (e.flags(s) & 7) === 0 && "
        "Math.hypot(e.velocity(s, 0), e.velocity(s, 2)) > 0.5);"
        " return walks[0][0]; })()");
    browser->evaluate("zoned.choose(" + agent + ")");
    ASSERT_TRUE(browser->wait_until("zoned.overlay.details?.agent !== undefined"));
    const std::string place = browser->evaluate(place_of(agent) + ".join(' ')");
    std::istringstream numbers(place);
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
    ASSERT_TRUE(numbers >> x >> y >> z) << place;
    look_at(x, y, z, 75.0, 0.7, 0.5);
    shoot("city.png");
}

TEST_F(Pictures, ValleyInTheDarkWithCharts) {
    serve_world("valley");
    browser->set_dark(true);
    open_world("valley");
    const testing_process::Child bots("client-sim", players(60, 120));
    ASSERT_TRUE(browser->wait_until(
        "(() => { const e = zoned.entities; return [...e.slotOf.values()].filter(s => (e.flags(s) &"
        " 2) !== 0).length >= 60; })()",
        testing_process::kPatience))
        << bots.errors();
    browser->evaluate("document.getElementById('charts-button').click()");
    ASSERT_TRUE(browser->wait_until("zoned.charts.charts.get('passes')?.data.labels.length > 12",
                                    testing_process::kPatience));
    look_at(0.0, 0.0, 0.0, 260.0, 0.9, 0.45);
    shoot("valley.png");
}

}  // namespace
}  // namespace zoned::testing_browser
