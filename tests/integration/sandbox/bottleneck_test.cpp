#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

constexpr double kBytesPerS = 32000.0;  // 256 kbit/s

/// A narrow path to each client, and a world with more to send than it carries: many walkers, sent
/// by positions alone and to the centimetre. Coded for each client they would take a third of it.
class NarrowPath : public GameTest {
  protected:
    NarrowPath() {
        server.sets = {"replication.predictor=STATIC",
                       "replication.codec=SHARED",
                       "replication.budget_bytes_per_s=125000",
                       "scatter[1].count=300",
                       "brain[0].state[0].transition[0].threshold=100000",  // they never rest
                       "lod[0].position_bound_m=0.01",
                       "lod[1].position_bound_m=0.01"};
        server.network.delay_s = 0.03;
        server.network.bottleneck_down_bytes_per_s = kBytesPerS;
        bots.bots = 2;
        bots.audit = false;
        bots.freeze = false;
    }

    /// Between two times of the run everything is measured on every path.
    struct Stretch {
        double from_s = 0.0;
        double until_s = 0.0;
        std::vector<link::BottleneckMeter> meters;
    };

    void measure(std::vector<Stretch>& spans,
                 const std::vector<std::pair<double, double>>& rates = {}) {
        std::size_t changed = 0;
        std::size_t begun = 0;
        run([&](VirtualServer& host, double now_s) {
            if (changed < rates.size() && now_s >= rates[changed].first) {
                for (link::Conditioner* path : host.paths_down()) {
                    path->set_bottleneck(now_s, rates[changed].second);
                }
                ++changed;
            }
            if (begun < spans.size() && now_s >= spans[begun].from_s) {
                for (link::Conditioner* path : host.paths_down()) {
                    path->restart_bottleneck_meter(now_s);
                }
                ++begun;
            }
            for (Stretch& span : spans) {
                if (span.meters.empty() && now_s >= span.until_s) {
                    for (link::Conditioner* path : host.paths_down()) {
                        span.meters.push_back(path->bottleneck(now_s));
                    }
                }
            }
        });
    }

    static void expect_good(const Stretch& span) {
        ASSERT_FALSE(span.meters.empty());
        for (const link::BottleneckMeter& meter : span.meters) {
            EXPECT_LT(meter.wait_s.percentile(0.95), 0.050) << "from " << span.from_s << " s on";
            EXPECT_GT(meter.utilisation(), 0.85) << "from " << span.from_s << " s on";
        }
    }
};

TEST_F(NarrowPath, IsFilledWithAShortQueue) {
    bots.seconds = 31.0;
    std::vector<Stretch> spans = {{5.0, 30.0, {}}};
    measure(spans);
    expect_good(spans[0]);
}

TEST_F(NarrowPath, IsFilledAgainFiveSecondsAfterItChanged) {
    bots.seconds = 51.0;
    std::vector<Stretch> spans = {{15.0, 20.0, {}}, {25.0, 35.0, {}}, {40.0, 50.0, {}}};
    // A span of measuring begins five seconds after a change of the rate; by then the new rate is
    // found.
    measure(spans, {{20.0, 2.0 * kBytesPerS}, {35.0, kBytesPerS}});
    for (const Stretch& span : spans) {
        expect_good(span);
    }
}

TEST_F(NarrowPath, IsFloodedWithoutCongestionControl) {
    server.sets.emplace_back("replication.congestion_control=false");
    bots.seconds = 11.0;
    std::vector<Stretch> spans = {{5.0, 10.0, {}}};
    measure(spans);
    for (const link::BottleneckMeter& meter : spans[0].meters) {
        // The queue is full: the other tests would show this if nothing were controlled.
        EXPECT_GT(meter.wait_s.percentile(0.5), 0.2);
        EXPECT_GT(meter.dropped, 100U);
    }
}

}  // namespace
}  // namespace zoned::harness
