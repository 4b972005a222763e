// The script of a config: its source goes into the text, and it changes live.
#include "server/config/expand/script_config.h"

#include "server/config/expand/load_settings.h"
#include "server/config/expand/reload_plan.h"
#include "server/config/text/read_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace zoned::config {
namespace {

using ::testing::HasSubstr;

class ScriptOfAConfig : public ::testing::Test {
  protected:
    void SetUp() override {
        std::filesystem::create_directories(folder);
        ASSERT_EQ(read_text(ZONED_SOURCE_DIR "/config/minimal.txtpb", minimal), "");
    }

    void TearDown() override { std::filesystem::remove_all(folder); }

    /// The mistake of the minimal world with this block; empty: none.
    std::string mistakes_with(const std::string& block) {
        std::ofstream(folder / "world.txtpb") << minimal << "\n" << block << "\n";
        std::vector<ConfigError> errors;
        load_settings((folder / "world.txtpb").string(), {}, settings, errors);
        return format_errors("world", errors);
    }

    void put_script(const std::string& source) { std::ofstream(folder / "game.lua") << source; }

    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("zoned-script-" + std::to_string(::getpid()));
    std::string minimal;
    Settings settings;
};

TEST_F(ScriptOfAConfig, IsReadBesideTheConfigAndHeldByItsText) {
    put_script("function on_tick() end\n");
    ASSERT_EQ(mistakes_with("script { file: \"game.lua\" instructions_per_call: 5000 memory_mb: 2 "
                            "errors_allowed: 7 on_errors: SCRIPT_STOP_ZONE }"),
              "");
    ASSERT_TRUE(settings.script.has_value());
    EXPECT_EQ(settings.script->name, "game.lua");
    EXPECT_EQ(settings.script->source, "function on_tick() end\n");
    EXPECT_EQ(settings.script->avatar, "player");
    EXPECT_EQ(settings.script->limits.instructions_per_call, 5000u);
    EXPECT_EQ(settings.script->limits.memory_bytes, 2U << 20U);
    EXPECT_EQ(settings.script->errors_allowed, 7u);
    EXPECT_EQ(settings.script->on_errors, scripting::ErrorPolicy::kStopZone);
    // A recording needs no file.
    std::filesystem::remove(folder / "game.lua");
    Settings again;
    std::vector<ConfigError> errors;
    ASSERT_TRUE(parse_settings(settings.text, {}, again, errors)) << format_errors("", errors);
    EXPECT_EQ(again.script, settings.script);
    EXPECT_EQ(script_of(settings.text), settings.script);
}

TEST_F(ScriptOfAConfig, IsNoneWhereTheConfigHasNone) {
    ASSERT_EQ(mistakes_with(""), "");
    EXPECT_FALSE(settings.script.has_value());
    EXPECT_FALSE(script_of(settings.text).has_value());
}

TEST_F(ScriptOfAConfig, NamesWhatIsWrong) {
    EXPECT_THAT(mistakes_with("script { }"), HasSubstr("a script needs a file"));
    EXPECT_THAT(mistakes_with("script { file: \"none.lua\" }"), HasSubstr("script.file"));
    put_script("");
    EXPECT_THAT(mistakes_with("script { file: \"game.lua\" instructions_per_call: 10 }"),
                HasSubstr("script.instructions_per_call"));
    EXPECT_THAT(mistakes_with("script { file: \"game.lua\" memory_mb: 0 }"),
                HasSubstr("script.memory_mb"));
    put_script(std::string(2U << 20U, ' '));
    EXPECT_THAT(mistakes_with("script { file: \"game.lua\" }"), HasSubstr("longer than 1 MiB"));
}

TEST_F(ScriptOfAConfig, ChangesLiveHoweverFarBehindTheChange) {
    const std::string head = "-- " + std::string(500, 'x') + "\n";
    put_script(head + "function on_tick() end\n");
    ASSERT_EQ(mistakes_with("script { file: \"game.lua\" }"), "");
    const Settings running = settings;
    put_script(head + "function on_tick() print(now()) end\n");
    ASSERT_EQ(mistakes_with("script { file: \"game.lua\" }"), "");
    const auto plan = plan_reload(running, settings);
    ASSERT_TRUE(plan.ok()) << plan.error();
    ASSERT_EQ(plan->changes.size(), 1u);
    EXPECT_EQ(plan->changes[0].path, "script.text");
    EXPECT_TRUE(plan->changes[0].live);
    EXPECT_LT(plan->changes[0].after.size(), 100u);
    ASSERT_NE(plan->brains, nullptr);
    EXPECT_EQ(plan->merged->script, settings.script);
}

TEST_F(ScriptOfAConfig, ComesAndGoesByARestart) {
    ASSERT_EQ(mistakes_with(""), "");
    const Settings running = settings;
    put_script("");
    ASSERT_EQ(mistakes_with("script { file: \"game.lua\" }"), "");
    const auto plan = plan_reload(running, settings);
    ASSERT_FALSE(plan.ok());
    EXPECT_THAT(plan.error(), HasSubstr("take a restart"));
}

}  // namespace
}  // namespace zoned::config
