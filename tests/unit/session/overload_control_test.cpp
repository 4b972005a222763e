#include "server/session/overload_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace zoned::session {
namespace {

constexpr double kLook_s = 0.25;
constexpr double kFloor = 20.0;

/// A server whose load is that of its world, and so much for each session, of which a part goes
/// with the bytes.
struct ModelServer {
    double idle = 0.1;
    double per_session = 1e-3;
    double per_kilobyte = 0.0;    ///< and session
    double usual_bytes = 1000.0;  ///< per session and second
    std::size_t sessions = 0;
    double now_s = 0.0;
    double max_load = 0.9;
    OverloadControl control;

    [[nodiscard]] double bytes() const { return std::min(usual_bytes, control.ceiling()); }

    [[nodiscard]] double load() const {
        return idle + static_cast<double>(sessions) * (per_session + per_kilobyte * 1e-3 * bytes());
    }

    void run(double seconds) {
        for (double end = now_s + seconds; now_s < end;) {
            now_s += kLook_s;
            control.measured(
                load(), sessions, static_cast<double>(sessions) * bytes(), kFloor, max_load, now_s);
        }
    }

    /// Logins a second for so long; how many were let in.
    std::size_t storm(std::size_t per_s, double seconds) {
        std::size_t in = 0;
        for (double end = now_s + seconds; now_s < end;) {
            for (std::size_t i = 0; i < static_cast<std::size_t>(per_s * kLook_s); ++i) {
                if (control.admits(sessions, max_load)) {
                    ++sessions;
                    ++in;
                }
            }
            run(kLook_s);
        }
        return in;
    }
};

TEST(OverloadControl, LetsEverybodyInWhereNothingWasMeasured) {
    OverloadControl control;
    for (std::size_t i = 0; i < 10000; ++i) {
        ASSERT_TRUE(control.admits(i, 0.9));
    }
    EXPECT_EQ(control.ceiling(), OverloadControl::kNoCeiling);
}

TEST(OverloadControl, FillsUpToTheMostLoadAndNotBeyond) {
    for (const std::size_t per_s : {40, 400, 4000}) {
        ModelServer server;
        server.run(5.0);
        server.storm(per_s, 40.0);
        // The load is idle + n c: (0.9 - 0.1) / 0.001 = 800 sessions. Before the first look after
        // the first login nothing is known of their cost: a look's worth may come too many.
        const double unknown = static_cast<double>(per_s) * kLook_s;
        EXPECT_GE(server.sessions, std::min<std::size_t>(720, per_s * 40)) << per_s;
        EXPECT_LE(static_cast<double>(server.sessions), std::max(801.0, unknown + 1.0)) << per_s;
        EXPECT_TRUE(server.control.refusing());
    }
}

TEST(OverloadControl, ExpectsWhatSessionsCostThatAreTooNewToShow) {
    ModelServer server;
    server.run(5.0);
    server.sessions = 100;
    server.run(20.0);
    // 100 cost 0.1: 400 more are expected to make 0.1 + 0.5.
    EXPECT_NEAR(server.control.expected(500), 0.6, 0.01);
    EXPECT_NEAR(server.control.load(), 0.2, 0.01);
}

TEST(OverloadControl, ExpectsLittleOfWhatFewSessionsCost) {
    ModelServer server;
    server.run(5.0);
    server.sessions = 2;
    server.per_session = 0.17;  // they join, and somebody builds on the same machine
    server.run(5.0);
    EXPECT_NEAR(server.control.load(), 0.44, 0.01);
    EXPECT_TRUE(server.control.admits(10, server.max_load));
    EXPECT_FALSE(server.control.admits(30, server.max_load));
}

TEST(OverloadControl, RefusesUntilTheLoadIsATenthBelow) {
    ModelServer server;
    server.run(5.0);
    server.sessions = 850;
    server.run(10.0);
    EXPECT_FALSE(server.control.admits(server.sessions, server.max_load));
    server.sessions = 720;  // 0.82, above 0.81
    server.run(10.0);
    EXPECT_TRUE(server.control.refusing());
    server.sessions = 690;  // 0.79
    server.run(10.0);
    EXPECT_FALSE(server.control.refusing());
    EXPECT_TRUE(server.control.admits(server.sessions, server.max_load));
}

TEST(OverloadControl, LetsSomebodyInWhereTheWorldAloneIsTooMuch) {
    ModelServer server;
    server.idle = 1.5;
    server.run(5.0);
    EXPECT_TRUE(server.control.admits(0, server.max_load));
    EXPECT_FALSE(server.control.admits(1, server.max_load));
}

TEST(OverloadControl, CutsBytesWhereTheLoadIsTooMuchAndGivesThemBack) {
    ModelServer server;
    server.per_session = 0.0;
    server.per_kilobyte = 1e-3;
    server.run(5.0);
    server.sessions = 1500;  // 1.6, were it not for the ceiling
    server.run(20.0);
    // Cuts end below (0.9 + 1) / 2. The last one began above it, took a fifth of what the bytes
    // cost, and the smoothed load showed it a second late: one more may have followed.
    EXPECT_LE(server.load(), 0.95 + 1e-9);
    EXPECT_GE(server.load(), 0.1 + 0.8 * 0.8 * 0.85);
    EXPECT_LT(server.control.ceiling(), server.usual_bytes);
    const double before = server.control.ceiling();
    server.run(60.0);
    // Between the two bounds it holds still.
    EXPECT_EQ(server.control.ceiling(), before);
    server.sessions = 200;
    server.run(20.0);
    EXPECT_EQ(server.control.ceiling(), OverloadControl::kNoCeiling);
}

TEST(OverloadControl, NeverCutsBelowTheFloor) {
    ModelServer server;
    server.per_session = 2e-3;  // bytes are not what costs
    server.run(5.0);
    server.sessions = 2000;
    server.run(60.0);
    EXPECT_EQ(server.control.ceiling(), kFloor);
}

}  // namespace
}  // namespace zoned::session
