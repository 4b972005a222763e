#include "tests/harness/game_test.h"

#include <map>
#include <vector>

namespace zoned::harness {
namespace {

constexpr double kOutageFromS = 8.0;
constexpr double kOutageS = 5.0;
constexpr double kHealedS = kOutageFromS + kOutageS;
constexpr double kAfterS = 2.0;

/// Everything is cut for five seconds, UDP and TCP; the client comes back to its session.
class CatchUp : public GameTest {
  protected:
    CatchUp() {
        server.network.delay_s = 0.05;
        server.network.outage_every_s = kOutageFromS;  // the next one would be after the run
        server.network.outage_length_s = kOutageS;
        bots.bots = 1;
        bots.seconds = 15.5;
        bots.freeze = false;
        bots.audit = false;
        bots.mix = {{bot::Script::kIdle, 1.0}};
    }

    /// The traffic received in a stretch of the run.
    struct Stretch {
        double from_s = 0.0;
        double until_s = 0.0;
        double bytes = 0.0;  ///< datagrams and frames but audits, headers of datagrams counted
        std::uint64_t records = 0;
        std::uint64_t absolutes = 0;
    };

    void measure(std::vector<Stretch>& stretches, std::size_t& heard) {
        bool cut = false;
        report = run([&](VirtualServer& host, double now_s) {
            if (!cut && now_s >= kOutageFromS + 0.05) {
                cut = true;
                host.cut_streams();
            }
            if (!swarm || swarm->bots().empty() || swarm->bots().front()->view() == nullptr) {
                return;
            }
            const bot::Bot& bot = *swarm->bots().front();
            heard = std::max(heard, bot.view()->store().present_count());
            const link::DatagramStats& d = bot.client().datagrams();
            const link::SessionStats& s = bot.client().stats();
            const view::ViewStats& v = bot.view()->stats();
            Stretch now;
            now.bytes =
                static_cast<double>(d.bytes_in + 28 * d.in + s.frame_bytes_in - s.audit_bytes_in);
            now.records = v.records;
            now.absolutes = v.absolutes;
            for (Stretch& stretch : stretches) {
                Stretch& begin = begins[stretch.from_s];
                if (now_s < stretch.from_s) {
                    begin = now;
                } else if (now_s < stretch.until_s) {
                    stretch.bytes = now.bytes - begin.bytes;
                    stretch.records = now.records - begin.records;
                    stretch.absolutes = now.absolutes - begin.absolutes;
                }
            }
        });
    }

    std::map<double, Stretch> begins;
    measure::RunReport report;
};

TEST_F(CatchUp, InAWorldAtRestNothingIsSentAgain) {
    server.sets = {"scatter[0].count=198", "scatter[1].type=crate", "scatter[1].asleep=true"};
    std::vector<Stretch> s = {{0.0, 3.0}, {5.0, 5.0 + kAfterS}, {kHealedS, kHealedS + kAfterS}};
    std::size_t heard = 0;
    measure(s, heard);
    EXPECT_EQ(report.resumed, 1U);
    EXPECT_EQ(report.sessions_lost, 0U);
    EXPECT_EQ(heard, 200U);
    const Stretch& join = s[0];
    const Stretch& before = s[1];
    const Stretch& after = s[2];
    EXPECT_GE(join.records, 200U);
    // Crates rest and the avatar stands: no entity has moved.
    EXPECT_EQ(after.records, 0U);
    // Only signs of life come, and the resumed session's Welcome and its events.
    EXPECT_LT(after.bytes, before.bytes + 1500.0);
    EXPECT_EQ(report.view_resets, 0U);
    EXPECT_EQ(report.unknown_keyframes, 0U);
    RecordProperty("join_bytes", static_cast<int>(join.bytes));
    RecordProperty("steady_bytes", static_cast<int>(before.bytes));
    RecordProperty("catch_up_bytes", static_cast<int>(after.bytes));
}

TEST_F(CatchUp, InAMovingWorldOnlyWhatMovedIsSent) {
    server.sets = {"scatter[0].count=200",
                   "scatter[1].count=40",
                   "brain[0].state[0].transition[0].threshold=100000"};  // they never rest
    bots.audit = true;
    std::vector<Stretch> s = {{0.0, 3.0}, {5.0, 5.0 + kAfterS}, {kHealedS, kHealedS + kAfterS}};
    std::size_t heard = 0;
    measure(s, heard);
    EXPECT_EQ(report.resumed, 1U);
    EXPECT_TRUE(report.consistent) << reasons(report);
    const Stretch& before = s[1];
    const Stretch& after = s[2];
    // The usual updates of two seconds, each of the 40 once more for the missed time. Some come
    // twice (sent before the server knew which had arrived). Wanderers also pushed some crates.
    EXPECT_LT(after.records, before.records + 2 * 40 + 60);
    EXPECT_LT(after.bytes, s[0].bytes);
    EXPECT_EQ(report.unknown_keyframes, 0U);
    RecordProperty("join_bytes", static_cast<int>(s[0].bytes));
    RecordProperty("steady_bytes", static_cast<int>(before.bytes));
    RecordProperty("catch_up_bytes", static_cast<int>(after.bytes));
    RecordProperty("join_records", static_cast<int>(s[0].records));
    RecordProperty("steady_records", static_cast<int>(before.records));
    RecordProperty("catch_up_records", static_cast<int>(after.records));
}

}  // namespace
}  // namespace zoned::harness
