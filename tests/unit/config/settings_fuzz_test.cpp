// Random damage to a config: reported, never a crash, and a good config stays good.
#include "tests/unit/config/config_helpers.h"
#include "shared/core/rng.h"

#include <fstream>
#include <sstream>

namespace zoned::config::test {
namespace {

std::string read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

/// Bytes flipped, cut, doubled or replaced by text that breaks parsers.
std::string damage(std::string text, core::Rng& rng) {
    static const char* const kPieces[] = {"{",
                                          "}",
                                          ":",
                                          "\"",
                                          "#",
                                          "[",
                                          "]",
                                          "-",
                                          "nan",
                                          "1e308",
                                          "99999999999999999999",
                                          "\n",
                                          "type",
                                          "zone_grid",
                                          "'",
                                          "count: 100000",
                                          "\\",
                                          "\xff",
                                          "<",
                                          ">",
                                          ";",
                                          "inf",
                                          "0"};
    const std::uint32_t times = 1 + rng.below(4);
    for (std::uint32_t i = 0; i < times && !text.empty(); ++i) {
        const std::size_t at = rng.below(static_cast<std::uint32_t>(text.size()));
        const std::size_t length = rng.below(20);
        switch (rng.below(5)) {
            case 0:
                text[at] = static_cast<char>(rng.below(256));
                break;
            case 1:
                text.erase(at, length);
                break;
            case 2:
                text.insert(
                    at, text.substr(rng.below(static_cast<std::uint32_t>(text.size())), length));
                break;
            case 3:
                text.insert(at, kPieces[rng.below(std::size(kPieces))]);
                break;
            default:
                text.replace(at, 1, std::string(1, static_cast<char>('0' + rng.below(10))));
        }
    }
    return text;
}

void expect_sound(const Outcome& out) {
    EXPECT_EQ(out.ok, out.errors.empty());
    for (const ConfigError& error : out.errors) {
        EXPECT_FALSE(error.text.empty());
        EXPECT_GE(error.line, 0);
    }
}

TEST(SettingsFuzz, SurvivesDamageToASmallConfig) {
    core::Rng rng(11);
    int good = 0;
    for (int i = 0; i < 3000; ++i) {
        const std::string text = damage(kValid, rng);
        const Outcome out = parse(text);
        expect_sound(out);
        good += out.ok ? 1 : 0;
    }
    // Some damage is harmless (in a number, say); if all or none were, the test would test nothing.
    EXPECT_GT(good, 20);
    EXPECT_LT(good, 2500);
}

TEST(SettingsFuzz, SurvivesDamageToTheValley) {
    const std::string valley = read(ZONED_SOURCE_DIR "/config/valley.txtpb");
    ASSERT_GT(valley.size(), 1000u);
    core::Rng rng(12);
    for (int i = 0; i < 150; ++i) {
        expect_sound(parse(damage(valley, rng)));
    }
}

TEST(SettingsFuzz, SurvivesDamagedAssignments) {
    const std::string sets[] = {"zones.zone[1].name=x",
                                "type[player].mass_kg=70",
                                "session.dev_rights=PLAY,AUDIT",
                                "testing.stall_zone={zone: \"west\" at_tick: 300}"};
    core::Rng rng(13);
    for (int i = 0; i < 4000; ++i) {
        expect_sound(parse(kValid, {damage(sets[rng.below(4)], rng)}));
    }
}

TEST(SettingsFuzz, SurvivesDeepNesting) {
    std::string deep;
    for (int i = 0; i < 100000; ++i) {
        deep += "a {";
    }
    expect_sound(parse(deep));
    expect_sound(parse(kValid, {"world=" + std::string(100000, '{')}));
}

}  // namespace
}  // namespace zoned::config::test
