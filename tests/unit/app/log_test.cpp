// The log: areas with levels of their own, JSON that parses, floods that are cut, and what is told.
#include "server/app/log/log.h"

#include "server/app/log/session_log.h"
#include "server/app/runtime/counter_watch.h"
#include "server/app/runtime/start_log.h"
#include "server/config/expand/load_settings.h"
#include "tests/unit/json_reader.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

namespace zoned::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// What is logged within `work`.
template <class Work>
std::string logged(const config::LogSettings& settings, Work work) {
    std::ostringstream out;
    {
        const Log log(settings, &out);
        work();
    }
    return out.str();
}

TEST(Log, WritesEachAreaAtItsLevel) {
    config::LogSettings settings;
    settings.levels[static_cast<std::size_t>(LogArea::kSession)] = config::LogLevel::kError;
    const std::string text = logged(settings, [] {
        log_of(LogArea::kSession).info("hidden");
        log_of(LogArea::kTick).info("shown");
        EXPECT_EQ(log_level(), "mixed");
        EXPECT_TRUE(set_log_level(LogArea::kSession, "debug"));
        EXPECT_FALSE(set_log_level(LogArea::kSession, "loud"));
        log_of(LogArea::kSession).debug("now too");
        EXPECT_TRUE(set_log_level(LogArea::kCount, "warning"));
        EXPECT_EQ(log_level(), "warning");
        log_of(LogArea::kTick).info("hidden again");
    });
    EXPECT_THAT(text, HasSubstr("info tick: shown\n"));
    EXPECT_THAT(text, HasSubstr("debug session: now too\n"));
    EXPECT_THAT(text, Not(HasSubstr("hidden")));
}

TEST(Log, WritesJsonThatAnotherParserReads) {
    config::LogSettings settings;
    settings.json = true;
    const std::string text = logged(settings, [] {
        log_of(LogArea::kAdmin).warn("a \"quote\", a \\ and \n\t\x01 control, \xff no UTF-8, ü");
    });
    ASSERT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
    const auto line = json_text::parse(text);
    EXPECT_EQ(json_text::field(line, "level").string_value(), "warning");
    EXPECT_EQ(json_text::field(line, "area").string_value(), "admin");
    EXPECT_EQ(json_text::field(line, "message").string_value(),
              "a \"quote\", a \\ and \n\t\x01 control, \xEF\xBF\xBD no UTF-8, ü");
    EXPECT_EQ(json_text::field(line, "time").string_value().size(), 24U);
}

TEST(Log, CutsAFloodOfOneAreaAndSaysSo) {
    config::LogSettings settings;
    settings.lines_per_s = 10.0;
    const std::uint64_t before = Log::counts().left_out;
    const std::string text = logged(settings, [] {
        for (int i = 0; i < 1000; ++i) {
            log_of(LogArea::kSession).info("flood {}", i);
        }
        log_of(LogArea::kSession).error("an error all the same");
        log_of(LogArea::kTick).info("another area");
        std::this_thread::sleep_for(std::chrono::milliseconds(250));
        log_of(LogArea::kSession).info("after it");
    });
    const auto lines = std::count(text.begin(), text.end(), '\n');
    EXPECT_GE(lines, 20);
    EXPECT_LT(lines, 60);
    EXPECT_THAT(text, HasSubstr("an error all the same"));
    EXPECT_THAT(text, HasSubstr("another area"));
    EXPECT_THAT(text, HasSubstr("lines were left out"));
    EXPECT_THAT(text, HasSubstr("after it"));
    EXPECT_GE(Log::counts().left_out - before, 900U);
}

TEST(Log, HoldsAllLinesOnceItWasDrained) {
    std::ostringstream out;
    const Log log({}, &out);
    for (int i = 0; i < 50; ++i) {
        log_of(LogArea::kTick).info("line {}", i);
        Log::drain();
        EXPECT_THAT(out.str(), HasSubstr("line " + std::to_string(i) + "\n"));
    }
}

TEST(SessionLog, CleansWhatClientsChoose) {
    session::SessionNote note;
    note.kind = session::SessionNote::Kind::kJoined;
    note.client = ClientId(3);
    note.account = "ann";
    note.name = "\x1b[2J\nfake line";
    note.rights = mailbox::kRightPlay | mailbox::kRightAudit;
    const std::string text = logged({}, [&] {
        log_session(note);
        note.kind = session::SessionNote::Kind::kRefused;
        note.text = "the account is banned: \n\x07";
        log_session(note);
    });
    EXPECT_THAT(text, HasSubstr("session: client 3 (account ann, name ?[2J?fake line) of "));
    EXPECT_THAT(text, HasSubstr("joined, rights PLAY, AUDIT\n"));
    EXPECT_THAT(text, HasSubstr("warning session: a login from "));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
}

config::Settings minimal_with(const std::vector<std::string>& sets) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", sets, settings, errors))
        << config::format_errors("minimal", errors);
    return settings;
}

TEST(StartLog, TellsWhoMayDoWhatInDevelopmentMode) {
    std::string all;
    for (const std::string& text : unusual_of(minimal_with(
             {"session.dev_mode_loopback=true", "session.dev_rights=[PLAY,AUDIT,FREEZE]"}))) {
        all += text + "\n";
    }
    EXPECT_THAT(all, HasSubstr("with the rights PLAY, AUDIT, FREEZE"));
    EXPECT_THAT(all, HasSubstr("FREEZE stops the world for all"));
    EXPECT_THAT(all, HasSubstr("network.bind_address: :: takes connections from all networks"));
    EXPECT_THAT(all, HasSubstr("clients must pin the certificate"));
}

TEST(StartLog, TellsOfFaultsOnPurposeAndOfAnOpenAdminServer) {
    std::string all;
    for (const std::string& text : unusual_of(
             minimal_with({"testing.hide_entity={}", "network.admin_address=\"0.0.0.0\""}))) {
        all += text + "\n";
    }
    EXPECT_THAT(all, HasSubstr("testing.hide_entity: this server makes faults on purpose"));
    EXPECT_THAT(all, HasSubstr("lets other machines reach the admin server"));
}

TEST(CounterWatch, TellsOfAZoneInWhichPlayersGather) {
    LoopStats loop;
    const session::HostStats host;
    const net::TlsStats tls;
    const net::UdpStats udp;
    config::Settings settings;
    settings.tick_rate_hz = 20.0;
    settings.zones.resize(4);
    settings.zones[2].name = "market";
    loop.zones.resize(4);
    const auto told_within = [&](double market_ms, double others_ms, double from_s, double to_s) {
        for (ZoneSample& zone : loop.zones) {
            zone.step_ns = static_cast<std::uint64_t>(1e6 * others_ms);
        }
        loop.zones[2] = {0, 0, 0, 90, static_cast<std::uint64_t>(1e6 * market_ms), 0};
        return logged({}, [&] {
            CounterWatch watch;
            for (double s = from_s; s < to_s; s += 1.0) {
                watch.look({loop, host, tls, udp, 0, &settings}, s);
            }
        });
    };
    // A tick has 50 ms.
    const std::string text = told_within(40.0, 5.0, 0.0, 300.0);
    EXPECT_THAT(text, HasSubstr("zone market takes "));
    EXPECT_THAT(text, HasSubstr("90 players gather there"));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << "and not each second";
    EXPECT_EQ(told_within(20.0, 1.0, 0.0, 300.0), "") << "it has time enough";
    EXPECT_EQ(told_within(40.0, 30.0, 0.0, 300.0), "") << "all have much to do";
    EXPECT_EQ(told_within(40.0, 5.0, 0.0, 4.0), "") << "a crowd that passes";
}

TEST(CounterWatch, TellsWhatGrowsAtOnceAndThenSeldom) {
    LoopStats loop;
    session::HostStats host;
    net::TlsStats tls;
    net::UdpStats udp;
    CounterWatch watch;
    const std::string text = logged({}, [&] {
        watch.look({loop, host, tls, udp}, 0.0);
        tls.queue_overflow = 1;
        loop.dropped_ticks = 4;
        host.rejected["replayed"] = 7;
        host.rejected["login_ticket"] = 9;
        watch.look({loop, host, tls, udp}, 1.0);
        tls.queue_overflow = 5;
        watch.look({loop, host, tls, udp}, 2.0);
        watch.look({loop, host, tls, udp}, 12.0);
    });
    EXPECT_THAT(text, HasSubstr("warning network: 1 connections were closed"));
    EXPECT_THAT(text, HasSubstr("warning network: 4 connections were closed"));
    EXPECT_THAT(text, HasSubstr("5 since the start"));
    EXPECT_THAT(text, HasSubstr("warning tick: 4 ticks were left out"));
    EXPECT_THAT(text, HasSubstr("info network: not carried out, by reason: replayed 7\n"));
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
}

}  // namespace
}  // namespace zoned::app
