// A viewer that is left open: what it hears in a day makes it no larger, and it shows the world
// afterwards as it did before.
#include "tests/browser/viewer_fixture.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace zoned::testing_browser {
namespace {

using testing_process::kPatience;

constexpr int kUpdatesOfAnHour = 30 * 3600;

/// Hours that the viewer is open for: ZONED_VIEWER_HOURS asks for more than a test has time for.
int hours_open() {
    const char* asked = std::getenv("ZONED_VIEWER_HOURS");
    return asked != nullptr ? std::max(std::atoi(asked), 2) : 2;
}

/// Keeps some messages of each kind as they came, and counts objects of the graphics card from now
/// on.
constexpr const char* kListen = R"((() => {
  window.heard = [];
  const { on } = zoned.stream;
  for (const name of ['entities', 'layer']) {
    const take = on[name].bind(on);
    on[name] = (...given) => {
      take(...given);
      if (heard.length < 60) {
        heard.push({ take, given: given.map((v) => (v instanceof ArrayBuffer ? v.slice(0) : v)) });
      }
    };
  }
  window.made = 0;
  const { gl } = zoned.renderer;
  for (const kind of ['Buffer', 'Texture', 'VertexArray', 'Framebuffer', 'Program', 'Shader']) {
    for (const [word, by] of [['create', 1], ['delete', -1]]) {
      const call = gl[word + kind].bind(gl);
      gl[word + kind] = (...given) => { window.made += by; return call(...given); };
    }
  }
})())";

/// Lets the page take so many updates, as if they had come: ticks go on, and with each something
/// is removed whose place something new takes.
std::string take_updates(int count) {
    return "(() => { let id = 1e6 + (window.taken ?? 0); for (let i = 0; i < " +
           std::to_string(count) + R"(; ++i) {
  const { take, given } = heard[i % heard.length];
  const buffer = given.at(-1);
  const words = new Uint32Array(buffer, 0, buffer.byteLength >> 2);
  words[1] = zoned.entities.tick + 1;
  take(...given);
  const crate = new Uint32Array(4 + 1 + 11);
  crate.set([2, words[1], 1, 1, 900, 900]);
  crate[6 + 3] = words[1];
  crate[6 + 8] = ++id;
  zoned.entities.take(crate.buffer);
  zoned.entities.fade(0.92);
  if (i % 5000 === 0) zoned.draw();
} window.taken = (window.taken ?? 0) + )" +
           std::to_string(count) + "; })()";
}

/// Figures and details as the page asks for them, many times.
constexpr const char* kAsk = R"((async () => {
  const figures = await zoned.stream.getJson('api/v1/charts');
  const details = await zoned.stream.getJson('api/v1/inspect/' + zoned.counts().chosen);
  for (let i = zoned.charts.samples < 150 ? 0 : 140; i < 150; ++i) {
    figures.time_s += 1;
    figures.ticks += 30;
    zoned.charts.take(structuredClone(figures));
    for (let k = 0; k < 10; ++k) zoned.panel.show(details);
  }
})())";

class ViewerForADay : public ViewerFixture {};

TEST_F(ViewerForADay, GrowsByNothing) {
    serve_world("cloth");
    open_world("cloth");
    browser->evaluate("zoned.choose([...zoned.entities.slotOf.keys()][0])");
    browser->evaluate("document.getElementById('charts-button').click()");
    ASSERT_TRUE(browser->wait_until("zoned.charts.charts.size === 5"));
    browser->evaluate(kListen);
    ASSERT_TRUE(browser->wait_until("heard.length === 60", kPatience));
    const std::string shown = browser->evaluate("zoned.entities.size");
    browser->evaluate("zoned.stream.socket.onmessage = null");
    ASSERT_EQ(browser->evaluate("[2, 4].every((kind) => heard.some((m) => "
                                "new Uint32Array(m.given.at(-1), 0, 1)[0] === kind))"),
              "true")
        << "entities and soft bodies";
    browser->evaluate(take_updates(kUpdatesOfAnHour));
    browser->evaluate(kAsk);
    const Browser::Memory before = browser->memory();
    const std::string made = browser->evaluate("made");
    const int hours = hours_open();
    for (int hour = 1; hour < hours; ++hour) {
        browser->evaluate(take_updates(kUpdatesOfAnHour));
        browser->evaluate(kAsk);
    }
    ASSERT_EQ(browser->evaluate("taken"), std::to_string(hours * kUpdatesOfAnHour));
    const Browser::Memory after = browser->memory();
    std::printf("heap %.2f MB, after %d more hours %.2f MB; nodes %.0f and %.0f\n",
                1e-6 * before.heap_bytes,
                hours - 1,
                1e-6 * after.heap_bytes,
                before.nodes,
                after.nodes);
    // Less than an object, of 12 bytes at least, for each update of one hour. The browser's own
    // bookkeeping stays far below.
    EXPECT_LE(after.heap_bytes - before.heap_bytes, 1e6);
    EXPECT_LE(after.nodes, before.nodes + 200.0) << "a panel's rows and charts' legends";
    EXPECT_EQ(browser->evaluate("made"), made) << "objects of the graphics card are never given up";
    EXPECT_EQ(browser->evaluate("zoned.entities.capacity"), "1024");
    EXPECT_EQ(browser->evaluate("Math.max(...[...zoned.charts.charts.values()].map("
                                "(c) => c.data.labels.length))"),
              "120");
    // The stream is opened again, and the page shows what it would show anew.
    browser->evaluate("zoned.stream.restart(zoned.stream.token)");
    EXPECT_TRUE(browser->wait_until("zoned.entities.size === " + shown, kPatience))
        << browser->evaluate("zoned.entities.size");
    expect_no_errors();
}

TEST_F(ViewerForADay, DrawsAgainAfterTheGraphicsCardWasAway) {
    look();
    browser->evaluate(
        "(() => { window.old = true; window.lost = "
        "zoned.renderer.gl.getExtension('WEBGL_lose_context'); lost.loseContext(); })()");
    ASSERT_TRUE(browser->wait_until(
        "document.getElementById('figures').textContent.startsWith('the picture is gone')"));
    browser->evaluate("lost.restoreContext()");
    ASSERT_TRUE(
        browser->wait_until("!window.old && window.zoned?.counts().state === 'live'", kPatience));
    EXPECT_TRUE(browser->wait_until("zoned.entities.size === 12 && zoned.counts().frames > 2"));
    EXPECT_EQ(browser->evaluate("zoned.renderer.gl.isContextLost()"), "false");
}

}  // namespace
}  // namespace zoned::testing_browser
