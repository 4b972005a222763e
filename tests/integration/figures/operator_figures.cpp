// Figures promised to operators, measured on a running server: it is run by hand, on a machine
// with nothing else to do (build/operator-figures; tests/bench/README.md holds the figures).
#include "tests/integration/process/admin_fixture.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

namespace zoned::testing_process {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The number after a key of a JSON text or of metrics; fails the test where there is none.
double figure(const std::string& text, const std::string& key) {
    const std::size_t at = text.find(key);
    EXPECT_NE(at, std::string::npos) << key << " is not in\n" << text;
    return at == std::string::npos ? 0.0 : std::strtod(text.c_str() + at + key.size(), nullptr);
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty()
               ? 0.0
               : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Prints a figure beside what is promised, and fails the test where it falls short.
void tell(const char* what,
          double value,
          double promised,
          const char* unit,
          bool at_least = false) {
    std::printf("figure: %-58s %9.3f %s, promised %s %g\n",
                what,
                value,
                unit,
                at_least ? "at least" : "at most",
                promised);
    if (at_least) {
        EXPECT_GE(value, promised) << what;
    } else {
        EXPECT_LE(value, promised) << what;
    }
}

/// This process, and what it starts from now on, runs on cores of [begin, end) alone.
void stay_on_cores(int begin, int end) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    for (int core = begin; core < end; ++core) {
        CPU_SET(core, &cores);
    }
    EXPECT_EQ(::sched_setaffinity(0, sizeof(cores), &cores), 0);
}

/// A viewer without a browser: it opens the stream and takes what comes.
class Spectator {
  public:
    Spectator(std::uint16_t port, const std::string& token) : socket_(port) {
        socket_.send(
            "GET /api/v1/spectate HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\n"
            "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Protocol: zoned, " +
            token + "\r\n\r\n");
        EXPECT_TRUE(socket_.receive_until("\r\n\r\n").starts_with("HTTP/1.1 101"));
        reader_ = std::thread([this] {
            for (std::size_t got = 1; !ends_.load() && got > 0; bytes_ += got) {
                got = socket_.receive_some();
            }
        });
    }

    ~Spectator() {
        ends_.store(true);
        reader_.join();
        EXPECT_GT(bytes_, 100000U) << "the viewer saw nothing";
    }

    Spectator(const Spectator&) = delete;
    Spectator& operator=(const Spectator&) = delete;

  private:
    testing_admin::RawSocket socket_;
    std::atomic<bool> ends_{false};
    std::size_t bytes_ = 0;
    std::thread reader_;
};

class OperatorFigures : public Admin {
  protected:
    void TearDown() override {
        stay_on_cores(0, static_cast<int>(std::thread::hardware_concurrency()));
        Admin::TearDown();
    }

    void serve_valley(std::vector<std::string> more = {}) {
        more.insert(more.end(), {"--report", report()});
        serve(std::move(more), ZONED_SOURCE_DIR "/config/valley.txtpb");
    }

    static std::string report() { return scratch_folder() + "/report.json"; }

    void play_with(int bots, int seconds) {
        std::vector<std::string> arguments = play(bots, seconds);
        arguments.insert(arguments.end(), {"--no-audit", "--no-freeze"});
        players = std::make_unique<Child>("client-sim", arguments);
        // A thousand take their time to log in, each with a handshake of TLS.
        bool joined = false;
        for (int i = 0; i < 5 && !joined; ++i) {
            joined = wait_for_sessions(bots);
        }
        ASSERT_TRUE(joined) << players->errors();
    }

    /// The figures of ten seconds that began after this call; scrapes every second meanwhile, or
    /// not at all.
    [[nodiscard]] std::string next_turns(bool scrapes = true) const {
        for (int second = 0; second < 21; ++second) {
            std::this_thread::sleep_for(std::chrono::seconds(1));
            if (scrapes) {
                EXPECT_EQ(status_of(ask("/metrics")), 200);
            }
        }
        return ask("/metrics");
    }

    void stop() {
        server->signal(SIGTERM);
        EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    }
};

TEST_F(OperatorFigures, ViewerScrapesAndLogCostATickNothing) {
    // The server has a core of its own: what is asked is its own work, not that of the players and
    // of the viewer's reader, who are on the same machine here.
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    stay_on_cores(cores - 1, cores);
    serve_valley();
    stay_on_cores(0, std::max(1, cores - 1));
    ASSERT_NO_FATAL_FAILURE(play_with(200, 600));
    std::vector<double> wall[2];
    std::vector<double> cpu[2];
    // By turns: a machine that slows down slows both.
    for (int round = 0; round < 10; ++round) {
        for (const bool looks : {false, true}) {
            EXPECT_EQ(ctl({"log-level", looks ? "debug" : "error"}), 0) << complained;
            const auto viewer = looks ? std::make_unique<Spectator>(admin_port, token()) : nullptr;
            const std::string metrics = next_turns(looks);
            wall[looks].push_back(1e3 * figure(metrics, "zoned_turn_seconds{quantile=\"0.99\"} "));
            cpu[looks].push_back(1e3 *
                                 figure(metrics, "zoned_turn_cpu_seconds{quantile=\"0.99\"} "));
        }
    }
    const auto say = [](const char* what, const std::vector<double>* p99) {
        std::printf("%s p99 without %.2f ms, with %.2f ms\n",
                    what,
                    quantile(p99[0], 0.5),
                    quantile(p99[1], 0.5));
        return quantile(p99[1], 0.5) / quantile(p99[0], 0.5);
    };
    tell("tick p99 with viewer, scrapes and log, CPU time", say("CPU", cpu), 1.05, "times");
    tell("tick p99 with viewer, scrapes and log, by the wall", say("wall", wall), 1.05, "times");

    std::vector<double> scrapes;
    for (int i = 0; i < 200; ++i) {
        const auto begin = Clock::now();
        EXPECT_EQ(status_of(ask("/metrics")), 200);
        scrapes.push_back(1e3 * seconds_since(begin));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    std::printf(
        "scrape: p50 %.2f ms, p99 %.2f ms\n", quantile(scrapes, 0.5), quantile(scrapes, 0.99));
    tell("a scrape with its connection, median", quantile(scrapes, 0.5), 5.0, "ms");
    stop();
}

TEST_F(OperatorFigures, AReloadHoldsUpNoTick) {
    serve_valley();
    ASSERT_NO_FATAL_FAILURE(play_with(200, 120));
    // A reload reads the config on another thread: no turn of the loop takes a period more.
    const double before = 1e3 * figure(next_turns(), "zoned_turn_seconds{quantile=\"1\"} ");
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(ctl({"reload"}), 0) << complained;
    }
    const double after = 1e3 * figure(next_turns(), "zoned_turn_seconds{quantile=\"1\"} ");
    const double period = 1e3 / figure(ask("/api/v1/status"), "\"tick_rate_hz\": ");
    std::printf("longest turn of ten seconds: %.2f ms, with reloads %.2f ms\n", before, after);
    tell("a reload, as the longest turn of the loop", after / period, 1.0, "ticks");
    stop();
}

TEST_F(OperatorFigures, RecordingCostsLittleAndReplaysFast) {
    const std::string file = scratch_folder() + "/valley.zrec";
    serve_valley({"--set", "recording.file=\"" + file + "\""});
    ASSERT_NO_FATAL_FAILURE(play_with(200, 40));
    EXPECT_NE(players->wait(100.0), -1) << players->output();
    const std::string metrics = ask("/metrics");
    const double tick_s = figure(metrics, "zoned_tick_cpu_seconds_sum ");
    stop();
    const std::string text = read(report());
    const double writer_s = 1e-3 * figure(text, "\"recording_cpu_ms\": ");
    std::printf("recording: %.2f s of the writer beside %.2f s of ticks\n", writer_s, tick_s);
    tell("recording, of tick time", 100.0 * writer_s / tick_s, 2.0, "%");
    Child replay("zoned", {"replay", file});
    EXPECT_EQ(replay.wait(600.0), 0) << replay.errors();
    const std::string result = replay.output();
    const std::size_t at = result.rfind(", ");
    ASSERT_NE(at, std::string::npos) << result;
    tell("replay of valley with 200 bots",
         std::strtod(result.c_str() + at + 2, nullptr),
         5.0,
         "times real time",
         true);
}

TEST_F(OperatorFigures, DrainsAThousandSessions) {
    serve({"--set", "network.max_clients=2000"});
    ASSERT_NO_FATAL_FAILURE(play_with(1000, 600));
    const auto begin = Clock::now();
    EXPECT_EQ(ctl({"drain", "--grace", "5"}), 0) << complained;
    EXPECT_EQ(server->wait(kPatience), 0) << server->errors();
    tell("drain of 1,000 sessions with a grace of 5 s", seconds_since(begin), 10.0, "s");
}

}  // namespace
}  // namespace zoned::testing_process
