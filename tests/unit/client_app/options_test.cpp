// The command line of client-sim: accepted options, refused ones and their messages.
#include "client-sim/app/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace zoned::app {
namespace {

struct Parsed {
    std::optional<Options> options;
    int exit_code = -1;
    std::string errors;
};

Parsed parse(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "client-sim");
    std::vector<char*> argv;
    for (std::string& argument : arguments) {
        argv.push_back(argument.data());
    }
    Parsed parsed;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    parsed.options = parse_options(static_cast<int>(argv.size()), argv.data(), parsed.exit_code);
    parsed.errors = testing::internal::GetCapturedStderr();
    testing::internal::GetCapturedStdout();
    return parsed;
}

Parsed parse_with(std::vector<std::string> more) {
    more.insert(more.begin(), {"--connect", "127.0.0.1:7777"});
    return parse(std::move(more));
}

TEST(Options, HaveSensibleDefaults) {
    const Parsed p = parse_with({});
    ASSERT_TRUE(p.options);
    EXPECT_EQ(p.options->host, "127.0.0.1");
    EXPECT_EQ(p.options->port, "7777");
    EXPECT_EQ(p.options->swarm.bots, 1u);
    EXPECT_TRUE(p.options->swarm.audit);
    EXPECT_TRUE(p.options->swarm.freeze);
    EXPECT_FALSE(p.options->conditioner.active());
    EXPECT_FALSE(p.options->insecure_dev);
    EXPECT_TRUE(p.options->pin.empty());
}

TEST(Options, ChooseTheViewAndWhatItDisplays) {
    Parsed p = parse_with({"--view", "interpolate", "--convergence", "hermite"});
    ASSERT_TRUE(p.options) << p.errors;
    EXPECT_EQ(p.options->swarm.view, view::ViewKind::kInterpolate);
    EXPECT_EQ(p.options->swarm.convergence, motion::ConvergenceMethod::kHermite);
    EXPECT_EQ(p.options->swarm.displayed_state, view::DisplayedState::kPredicted);
    p = parse_with({"--predictor", "none"});
    ASSERT_TRUE(p.options) << p.errors;
    EXPECT_EQ(p.options->swarm.view, view::ViewKind::kExtrapolate);
    EXPECT_EQ(p.options->swarm.displayed_state, view::DisplayedState::kPublished);
}

TEST(Options, TakeShareInPercentAndTimesInMilliseconds) {
    const Parsed p = parse_with({"--loss",        "5",          "--delay-ms",      "60",
                                 "--jitter-ms",   "20",         "--duplicate",     "2",
                                 "--reorder",     "5",          "--outage",        "10:0.5",
                                 "--seed",        "9",          "--bots",          "500",
                                 "--seconds",     "2.5",        "--ramp-per-s",    "50",
                                 "--convergence", "snap",       "--audit-every-s", "0.5",
                                 "--udp-sockets", "4",          "--behaviour",     "border:2,chat",
                                 "--no-freeze",   "--no-audit", "--quiet",         "--report",
                                 "r.json"});
    ASSERT_TRUE(p.options) << p.errors;
    const link::ConditionerSettings& c = p.options->conditioner;
    EXPECT_DOUBLE_EQ(c.loss, 0.05);
    EXPECT_DOUBLE_EQ(c.delay_s, 0.06);
    EXPECT_DOUBLE_EQ(c.jitter_s, 0.02);
    EXPECT_DOUBLE_EQ(c.duplicate, 0.02);
    EXPECT_DOUBLE_EQ(c.reorder, 0.05);
    EXPECT_DOUBLE_EQ(c.outage_every_s, 10.0);
    EXPECT_DOUBLE_EQ(c.outage_length_s, 0.5);
    EXPECT_EQ(c.seed, 9u);
    const SwarmSettings& s = p.options->swarm;
    EXPECT_EQ(s.bots, 500u);
    EXPECT_DOUBLE_EQ(s.seconds, 2.5);
    EXPECT_DOUBLE_EQ(s.ramp_per_s, 50.0);
    EXPECT_DOUBLE_EQ(s.audit_every_s, 0.5);
    EXPECT_EQ(s.convergence, motion::ConvergenceMethod::kSnap);
    EXPECT_EQ(s.mix.size(), 2u);
    EXPECT_FALSE(s.audit);
    EXPECT_FALSE(s.freeze);
    EXPECT_EQ(p.options->udp_sockets, 4);
    EXPECT_TRUE(p.options->quiet);
    EXPECT_EQ(p.options->report_file, "r.json");
}

TEST(Options, KnowNamesAndAddressesOfBothFamilies) {
    const Parsed six = parse({"--connect", "[::1]:7777"});
    ASSERT_TRUE(six.options) << six.errors;
    EXPECT_EQ(six.options->host, "::1");
    const Parsed name = parse({"--connect", "game.example.org:65535"});
    ASSERT_TRUE(name.options) << name.errors;
    EXPECT_EQ(name.options->host, "game.example.org");
    EXPECT_EQ(name.options->port, "65535");
}

TEST(Options, RefuseWithTwoAndSayWhatTheyWant) {
    struct Case {
        std::vector<std::string> arguments;
        const char* words;
    };

    const Case cases[] = {
        {{}, "--connect"},
        {{"--connect", "nowhere"}, "HOST:PORT"},
        {{"--connect", ":7777"}, "HOST:PORT"},
        {{"--connect", "host:"}, "HOST:PORT"},
        {{"--connect", "host:0"}, "1..65535"},
        {{"--connect", "host:65536"}, "1..65535"},
        {{"--connect", "host:http"}, "1..65535"},
        {{"--connect", "h:1", "--bots", "0"}, "--bots"},
        {{"--connect", "h:1", "--bots", "many"}, "--bots"},
        {{"--connect", "h:1", "--seconds", "-3"}, "--seconds"},
        {{"--connect", "h:1", "--loss", "101"}, "--loss"},
        {{"--connect", "h:1", "--behaviour", "dance"}, "--behaviour"},
        {{"--connect", "h:1", "--convergence", "magic"}, "--convergence"},
        {{"--connect", "h:1", "--view", "psychic"}, "--view"},
        {{"--connect", "h:1", "--predictor", "ballistic"}, "--predictor"},
        {{"--connect", "h:1", "--view", "interpolate", "--predictor", "none"}, "--predictor"},
        {{"--connect", "h:1", "--outage", "5"}, "EVERY:LENGTH"},
        {{"--connect", "h:1", "--outage", "1:2"}, "LENGTH < EVERY"},
        {{"--connect", "h:1", "--outage", "5:1s"}, "EVERY:LENGTH"},
        {{"--connect", "h:1", "--pin", "abcd"}, "64 hex digits"},
        {{"--connect", "h:1", "--pin", std::string(64, 'g')}, "64 hex digits"},
        {{"--connect", "h:1", "--pin", std::string(66, 'a')}, "64 hex digits"},
        {{"--connect", "h:1", "--ca", "/nonexistent.pem"}, "--ca"},
        {{"--connect", "h:1", "--ticket", "/nonexistent.ticket"}, "/nonexistent.ticket"},
        {{"--connect", "h:1", "--no-such-option"}, "--no-such-option"},
    };
    for (const Case& c : cases) {
        const Parsed p = parse(c.arguments);
        EXPECT_FALSE(p.options) << c.words;
        EXPECT_EQ(p.exit_code, kBadUsage) << c.words;
        EXPECT_NE(p.errors.find(c.words), std::string::npos) << c.words << "\n" << p.errors;
    }
}

TEST(Options, EndWithZeroAfterHelp) {
    const Parsed p = parse({"--help"});
    EXPECT_FALSE(p.options);
    EXPECT_EQ(p.exit_code, kGood);
}

TEST(Options, ReadThePin) {
    const Parsed p = parse_with({"--pin", "00ff" + std::string(60, 'A')});
    ASSERT_TRUE(p.options) << p.errors;
    ASSERT_EQ(p.options->pin.size(), 32u);
    EXPECT_EQ(p.options->pin[0], 0x00);
    EXPECT_EQ(p.options->pin[1], 0xFF);
    EXPECT_EQ(p.options->pin[31], 0xAA);
}

TEST(Options, WantATicketForEachBot) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / "zoned_tickets";
    std::filesystem::create_directories(folder);
    // One ticket as bytes, and two lines of base64: "abc" and "abcd".
    std::ofstream(folder / "a", std::ios::binary) << std::string("\x01\x02 raw\xFF", 7);
    std::ofstream(folder / "b") << "YWJj\nYWJjZA==\n";
    const Parsed good = parse_with({"--bots", "3", "--ticket", folder.string()});
    ASSERT_TRUE(good.options) << good.errors;
    EXPECT_EQ(good.options->swarm.tickets,
              (std::vector<std::string>{std::string("\x01\x02 raw\xFF", 7), "abc", "abcd"}));
    const Parsed few = parse_with({"--bots", "4", "--ticket", folder.string()});
    EXPECT_FALSE(few.options);
    EXPECT_NE(few.errors.find("3 tickets for 4 bots"), std::string::npos) << few.errors;
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace zoned::app
