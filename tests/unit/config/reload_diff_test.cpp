// Reload: agents may change in a world that runs, and nothing else.
#include "server/config/expand/reload_diff.h"

#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

TEST(Reload, TakesOtherBrains) {
    const Outcome running = parse(kValid);
    const Outcome fresh = parse(
        with("compare: BELOW threshold: 20", "compare: BELOW threshold: 30"), {"ai.far_m=99"});
    ASSERT_TRUE(fresh.ok);
    const auto agents = new_brains(running.settings, fresh.settings);
    ASSERT_TRUE(agents.ok()) << agents.error();
    EXPECT_EQ((*agents)->far_m, 99.0F);
    EXPECT_EQ((*agents)->brains[0].states[0].transitions[0].threshold, 30.0F);
    EXPECT_EQ((*agents)->brain_of_type, (std::vector<std::uint16_t>{0, 0, 1}));
    ASSERT_EQ((*agents)->compiled.size(), 1U);
}

TEST(Reload, RefusesAllElseAndSaysWhat) {
    const Outcome running = parse(kValid);
    const auto refusal = [&](const std::string& from, const std::string& to) {
        const Outcome fresh = parse(with(from, to));
        EXPECT_TRUE(fresh.ok) << format_errors("test", fresh.errors);
        const auto agents = new_brains(running.settings, fresh.settings);
        return agents.ok() ? std::string() : agents.error();
    };
    EXPECT_EQ(refusal("z_m: 2 }", "z_m: 2 }\n# a remark"), "");
    EXPECT_NE(refusal("spawn { x_m: 1 z_m: 2 }", "spawn { x_m: 1 z_m: 3 }").find("spawn[0].z_m"),
              std::string::npos);
    EXPECT_NE(refusal("box { x_m: 1", "box { x_m: 2").find("type[1].box.x_m"), std::string::npos);
    EXPECT_NE(refusal("  ghost_margin_m: 60", "  ghost_margin_m: 61").find("zones.ghost_margin_m"),
              std::string::npos);
    EXPECT_NE(refusal("  brain: \"guard\"\n", "").find("'guard' loses its brain"),
              std::string::npos);
}

}  // namespace
}  // namespace zoned::config::test
