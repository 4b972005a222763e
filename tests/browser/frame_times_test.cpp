// How fast the viewer draws: figures for people, run by hand on a machine with nothing else to do
// (tests/bench/README.md holds them).
#include "tests/browser/viewer_fixture.h"

#include <cstdio>
#include <sstream>

namespace zoned::testing_browser {
namespace {

using testing_process::kPatience;

class FrameTimes : public ViewerFixture {};

/// Median time of frames that are drawn to their end, at a size of the picture, ms.
std::string frame_ms(double size) {
    return "(() => { const r = zoned.renderer; r.fixedScale = " + std::to_string(size) +
           "; const p = new Uint8Array(4); const times = []; for (let i = 0; i < 30; ++i) {"
           " const t = performance.now(); zoned.draw();"
           " r.gl.readPixels(0, 0, 1, 1, r.gl.RGBA, r.gl.UNSIGNED_BYTE, p);"
           " times.push(performance.now() - t); } times.sort((a, b) => a - b);"
           " r.fixedScale = 0; return times[15]; })()";
}

TEST_F(FrameTimes, OfACityOfSixThousandPeople) {
    serve_world("city");
    open_world("city");
    ASSERT_TRUE(browser->wait_until("zoned.entities.size > 6000", kPatience));
    const double first_ms = std::stod(browser->evaluate("zoned.counts().first_picture_ms"));
    // The page paces itself: it draws what the machine can.
    browser->evaluate(
        "(() => { const t = performance.now(); const n = zoned.counts().frames;"
        " setTimeout(() => { window.paced = 1000 * (zoned.counts().frames - n) /"
        " (performance.now() - t); }, 3000); })()");
    ASSERT_TRUE(browser->wait_until("window.paced > 0"));
    const double paced = std::stod(browser->evaluate("window.paced"));
    const double scale = std::stod(browser->evaluate("zoned.renderer.scale"));
    const double whole_ms = std::stod(browser->evaluate(frame_ms(1.0)));
    const double half_ms = std::stod(browser->evaluate(frame_ms(0.5)));
    std::printf(
        "city: first picture %.0f ms after the page was opened; %.1f frames a second at %.2f of "
        "full size; a frame to its end takes %.1f ms, %.1f ms at half size\n",
        first_ms,
        paced,
        scale,
        whole_ms,
        half_ms);
    EXPECT_LT(first_ms, 1000.0);
    EXPECT_GT(paced, 30.0);
    EXPECT_GE(scale, 0.5);
    EXPECT_LT(half_ms, 33.0);
}

}  // namespace
}  // namespace zoned::testing_browser
