#include "tests/lint/coverage/coverage.h"

#include "tests/lint/coverage/config_setting.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

namespace zoned::lint {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

proto::config::Config config_of(const std::string& text) {
    proto::config::Config config;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &config)) << text;
    return config;
}

std::string file_text(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// ---------------------------------------------------------------- settings

std::string why_not(std::string_view text) {
    ConfigSetting setting;
    return read_setting(text, setting);
}

TEST(ReadSetting, FollowsTheSchemaFromItsRoot) {
    for (const char* text : {"type",
                             "type.soft.cloth",
                             "type.box.x_m",
                             "physics.method=JACOBI",
                             "physics.gravity_mps2=9.81",
                             "particles.cosmetic=false",
                             "brain.state.transition.sense=hunger",
                             "session.dev_rights=AUDIT"}) {
        EXPECT_EQ(why_not(text), "") << text;
    }
}

TEST(ReadSetting, NamesWhatTheSchemaLacks) {
    EXPECT_THAT(why_not("types.soft"), HasSubstr("`Config` has no field `types`"));
    EXPECT_THAT(why_not("type.soft.silk"), HasSubstr("`Soft` has no field `silk`"));
    EXPECT_THAT(why_not("type.mass_kg.unit"), HasSubstr("`mass_kg` holds no `unit`"));
    EXPECT_THAT(why_not("physics.method=JACOB"), HasSubstr("no value of `method`"));
    EXPECT_THAT(why_not("physics.substeps=-1"), HasSubstr("no value of `substeps`"));
    EXPECT_THAT(why_not("type.soft=CLOTH"), HasSubstr("no value of `soft`"));
    EXPECT_THAT(why_not("type.mass_kg="), HasSubstr("no value of `mass_kg`"));
    EXPECT_THAT(why_not(""), HasSubstr("no field"));
}

SettingUse use(const std::string& world, std::string_view text) {
    ConfigSetting setting;
    EXPECT_EQ(read_setting(text, setting), "");
    return use_of(config_of(world), setting);
}

TEST(UseOf, IsWrittenWhereTheWholePathIs) {
    EXPECT_EQ(use("type { name: 'a' } type { soft { cloth { } } }", "type.soft.cloth"),
              SettingUse::kWritten);
    EXPECT_EQ(use("type { soft { rope { } } } type { box { } }", "type.soft.cloth"),
              SettingUse::kNone);
    EXPECT_EQ(use("statics { box { } }", "type.box"), SettingUse::kNone)
        << "the last word alone stands elsewhere";
    EXPECT_EQ(use("type { assembly { joint { fixed { } } } }", "type.assembly.joint.fixed"),
              SettingUse::kWritten);
    EXPECT_EQ(use("session { dev_rights: PLAY dev_rights: AUDIT }", "session.dev_rights=AUDIT"),
              SettingUse::kWritten);
    EXPECT_EQ(use("session { dev_rights: PLAY }", "session.dev_rights=AUDIT"), SettingUse::kNone);
}

TEST(UseOf, ComparesValuesAsTheirType) {
    EXPECT_EQ(use("physics { gravity_mps2: 1.50 }", "physics.gravity_mps2=1.5"),
              SettingUse::kWritten);
    EXPECT_EQ(use("physics { gravity_mps2: 2 }", "physics.gravity_mps2=1.5"), SettingUse::kNone);
    EXPECT_EQ(use("ai { difficulty: 'hard' }", "ai.difficulty=hard"), SettingUse::kWritten);
}

TEST(UseOf, IsADefaultInBlocksThatTheWorldHas) {
    EXPECT_EQ(use("", "physics.method=SOFT_STEP"), SettingUse::kDefault);
    EXPECT_EQ(use("physics { }", "physics.method=SOFT_STEP"), SettingUse::kDefault);
    EXPECT_EQ(use("physics { method: JACOBI }", "physics.method=SOFT_STEP"), SettingUse::kNone);
    EXPECT_EQ(use("", "physics.method"), SettingUse::kNone) << "no value is asked for";
    EXPECT_EQ(use("ai { }", "ai.pathfinding.map=GRID"), SettingUse::kNone)
        << "without the block there are no paths";
    EXPECT_EQ(use("ai { pathfinding { } }", "ai.pathfinding.map=GRID"), SettingUse::kDefault);
    EXPECT_EQ(use("type { }", "type.soft.method=XPBD"), SettingUse::kNone);
    EXPECT_EQ(use("type { soft { } }", "type.soft.method=XPBD"), SettingUse::kDefault);
}

// ---------------------------------------------------------------- tests and benchmarks

TEST(AddTests, FindsTestsOfAllKinds) {
    std::set<std::string> tests;
    add_tests(
        "TEST(One, First) {}\nTEST_F(Two, Second) {}\n"
        "TEST_P(Three,\n       Third) {}\nINSTANTIATE_TEST_SUITE_P(Seeds, Three, Values(1));\n"
        "// TEST(Not, InAComment) {}\nconst char* kText = \"TEST(Not, InAText)\";\n"
        "TEST(One, DISABLED_Second) {}\nMY_TEST(Not, ATest) {}\n",
        tests);
    EXPECT_EQ(
        tests,
        (std::set<std::string>{"One.First", "Two.Second", "Three.Third", "Seeds/Three.Third"}));
}

TEST(AddBenchmarks, FindsTheNameOfEachRegistration) {
    std::set<std::string> benchmarks;
    add_benchmarks(
        "///     const Registration kThis({\"comment\", run});\n"
        "const Registration kA({\"soft\",\n \"cloth\", {\"s\"}, {}, run});\n"
        "const Registration kB(\n    {\"lod\", \"agents\"});\n"
        "const Registration kC(made_of_code()); const char* text = \"other\";\n",
        benchmarks);
    EXPECT_EQ(benchmarks, (std::set<std::string>{"lod", "soft"}));
}

// ---------------------------------------------------------------- the table

CoverageFacts facts() {
    CoverageFacts facts;
    facts.worlds["field"] = config_of("type { soft { cloth { } } } physics { substeps: 2 }");
    facts.worlds["plain"] = config_of("type { box { } }");
    facts.tests = {"Cloth.Hangs", "Cloth.Tears", "Wind.Blows", "Seeds/Wind.Blows"};
    facts.benchmarks = {"soft"};
    facts.programs["zoned"] = "add_subcommand(\"check\", \"\"); add_flag(\"--svg,-s\", o);";
    return facts;
}

const std::string kHead =
    "| state | meaning | items |\n"
    "|---|---|---|\n"
    "| x | there | 2 |\n"
    "| s | set | 1 |\n"
    "| l | library | 1 |\n"
    "| p | part | 1 |\n"
    "| - | missing | 1 |\n"
    "| n | no | 1 |\n"
    "| all | | 7 |\n\n"
    "| number | item | state | worlds | settings | tests | remark |\n"
    "|---|---|---|---|---|---|---|\n";
const std::string kRows =
    "| 1 | cloth | x | field | `type.soft.cloth`, `physics.substeps=2` | `Cloth.*` | |\n"
    "| 2 | checks | x | field, plain | `zoned check --svg` | `Wind.Blows` | |\n"
    "| 3 | Jacobi | s | | `physics.method=JACOBI` | `zoned-bench soft`, `Seeds/Wind.B*` | |\n"
    "| 4 | Verlet | l | | | `Cloth.Tears` | no setting |\n"
    "| 5 | boxes | p | plain | `type.box` | `Wind.*` | only boxes |\n"
    "| 8 | fog | - | | | | nobody made it |\n"
    "| 9 | ghosts | n | | | | not here |\n";
const ItemNumbers kNumbers{{1, 5}, {8, 9}};

std::vector<Finding> check(const std::string& text) {
    return check_coverage({"tests/coverage.md", text}, kNumbers, facts());
}

TEST(CheckCoverage, PassesATableThatIsTrue) {
    const std::vector<Finding> findings = check(kHead + kRows);
    EXPECT_TRUE(findings.empty()) << to_text(findings);
}

struct TableFault {
    const char* name;
    const char* was;
    const char* is;    ///< in its place
    int line;          ///< that a finding names
    const char* what;  ///< it says
};

class FaultInATable : public testing::TestWithParam<TableFault> {};

TEST_P(FaultInATable, IsFoundWithItsLineAndReason) {
    const TableFault& fault = GetParam();
    std::string text = kHead + kRows;
    const std::size_t at = text.find(fault.was);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, std::string_view(fault.was).size(), fault.is);
    EXPECT_THAT(check(text),
                Contains(AllOf(Field(&Finding::path, "tests/coverage.md"),
                               Field(&Finding::line, fault.line),
                               Field(&Finding::what, HasSubstr(fault.what)))));
}

constexpr TableFault kNames[] = {
    {"World", "| x | field |", "| x | fiel |", 13, "item 1: there is no world config/fiel.txtpb"},
    {"SecondWorld", "field, plain", "field, plane", 14, "no world config/plane.txtpb"},
    {"Setting", "type.soft.cloth", "type.soft.silk", 13, "`Soft` has no field `silk`"},
    {"Value", "method=JACOBI", "method=JACOBY", 15, "`JACOBY` is no value of `method`"},
    {"UnusedSetting", "type.soft.cloth", "type.soft.rope", 13, "does not use `type.soft.rope`"},
    {"OtherValue", "substeps=2", "substeps=3", 13, "does not use `physics.substeps=3`"},
    {"OneOfTwoWorlds", "| x | field |", "| x | field, plain |", 13, "plain.txtpb does not use"},
    {"PartInAWorld", "type.box", "type.sphere", 17, "does not use `type.sphere`"},
    {"UsedAfterAll", "physics.method=JACOBI", "type.box", 15, "plain.txtpb uses it"},
    {"Program", "zoned check", "zone check", 14, "no program `zone`"},
    {"Command", "zoned check", "zoned chec", 14, "zoned has no `chec`"},
    {"Option", "check --svg", "check --sv", 14, "zoned has no `--sv`"},
    {"TestName", "Cloth.Tears", "Cloth.Tear", 16, "no test `Cloth.Tear`"},
    {"SuiteName", "Cloth.*", "Clot.*", 13, "no test `Clot.*`"},
    {"StarWithoutSuite", "Cloth.*", "Clo*", 13, "no test `Clo*`"},
    {"Instance", "Seeds/Wind.B*", "Seed/Wind.B*", 15, "no test `Seed/Wind.B*`"},
    {"Benchmark", "zoned-bench soft", "zoned-bench sof", 15, "no benchmark `zoned-bench sof`"},
};
constexpr TableFault kForms[] = {
    {"Missing",
     "| 4 | Verlet | l | | | `Cloth.Tears` | no setting |\n",
     "",
     0,
     "item 4 is missing"},
    {"Twice", "| 4 | Verlet", "| 3 | Verlet", 16, "item 3: stands in line 15 already"},
    {"Beyond", "| 9 | ghosts", "| 10 | ghosts", 19, "item 10: is none of this table"},
    {"Between", "| 8 | fog", "| 6 | fog", 18, "item 6: is none of this table"},
    {"NoNumber", "| 9 | ghosts", "| nine | ghosts", 19, "`nine` is no number of an item"},
    {"NoState", "| x | field, plain", "| y | field, plain", 14, "item 2: `y` is no state"},
    {"OtherState", "| n | | | | not", "| all | | | | not", 19, "item 9: `all` is no state"},
    {"MoreCells", "`Cloth.Tears` | no", "`Cloth.Tears` | and | no", 16, "a row of 8 cells"},
    {"FewerCells", "`Cloth.Tears` | no", "`Cloth.Tears`, no", 16, "a row of 6 cells"},
    {"OpenRow", "| not here |", "| not here", 19, "a row of a table begins and ends with |"},
    {"NoName", "| fog |", "| |", 18, "has no name"},
    {"NoWorld", "| x | field |", "| x | |", 13, "names no world"},
    {"NoSetting", "`zoned check --svg`", "", 14, "names no setting"},
    {"NoTest", "`Wind.Blows`", "", 14, "names no test"},
    {"NoRemark", "| only boxes |", "| |", 17, "does not say what is missing"},
    {"WorldOfASetting", "| s | |", "| s | plain |", 15, "names a world"},
    {"WorldOfTheLibrary", "| l | |", "| l | plain |", 16, "names a world"},
    {"SettingOfTheLibrary", "| l | | |", "| l | | `type.box` |", 16, "names a setting"},
    {"TestOfNothing",
     "| - | | | |",
     "| - | | | `Wind.*` |",
     18,
     "names a test of what is not there"},
    {"Count", "| there | 2 |", "| there | 3 |", 3, "there are 2 items of `x`, not 3"},
    {"Sum", "| all | | 7 |", "| all | | 8 |", 9, "there are 7 items of `all`, not 8"},
    {"NoCount", "| s | set | 1 |\n", "", 0, "the head does not count `s`"},
    {"CountOfNoState", "| n | no | 1 |", "| m | no | 1 |", 8, "`m` is no state"},
    {"CountTwice", "| s | set | 1 |", "| s | set | 1 |\n| s | set | 1 |", 5, "counted twice"},
    {"CountOfNoNumber", "| set | 1 |", "| set | one |", 4, "`one` is no number of items"},
};

std::string name_of(const testing::TestParamInfo<TableFault>& fault) {
    return fault.param.name;
}

void PrintTo(const TableFault& fault, std::ostream* out) {
    *out << fault.name;
}

INSTANTIATE_TEST_SUITE_P(Names, FaultInATable, testing::ValuesIn(kNames), name_of);
INSTANTIATE_TEST_SUITE_P(Forms, FaultInATable, testing::ValuesIn(kForms), name_of);

// ---------------------------------------------------------------- the repository

/// Calls visit(text) for the sources below a folder.
template <class Visit>
void for_each_source(const fs::path& folder, Visit&& visit) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.path().extension() == ".cpp") {
            visit(file_text(entry.path()));
        }
    }
}

CoverageFacts facts_of(const fs::path& root) {
    CoverageFacts facts;
    for (const std::string folder : {"", "methods/"}) {
        for (const fs::directory_entry& entry : fs::directory_iterator(root / "config" / folder)) {
            if (entry.path().extension() == ".txtpb") {
                facts.worlds[folder + entry.path().stem().string()] =
                    config_of(file_text(entry.path()));
            }
        }
    }
    for_each_source(root / "tests",
                    [&facts](const std::string& text) { add_tests(text, facts.tests); });
    for_each_source(root / "tests/bench",
                    [&facts](const std::string& text) { add_benchmarks(text, facts.benchmarks); });
    for_each_source(root / "server/app/commands",
                    [&facts](const std::string& text) { facts.programs["zoned"] += text; });
    for_each_source(root / "client-sim/app",
                    [&facts](const std::string& text) { facts.programs["client-sim"] += text; });
    return facts;
}

TEST(Coverage, IsTrueOfWorldsSettingsAndTests) {
    // Items 184 to 195 belong to network topologies, those from 246 to the product as a whole.
    const ItemNumbers numbers{{1, 183}, {196, 245}};
    const fs::path root(ZONED_SOURCE_DIR);
    const std::vector<Finding> findings = check_coverage(
        {"tests/coverage.md", file_text(root / "tests/coverage.md")}, numbers, facts_of(root));
    EXPECT_TRUE(findings.empty()) << to_text(findings);
}

TEST(Coverage, IsCheckedAgainstWhatTheRepositoryHolds) {
    // A wrong folder would leave facts out, and each of them is missed by some row.
    const CoverageFacts facts = facts_of(ZONED_SOURCE_DIR);
    EXPECT_TRUE(facts.worlds.contains("valley"));
    EXPECT_TRUE(facts.tests.contains("CheckCoverage.PassesATableThatIsTrue"));
    EXPECT_TRUE(facts.tests.contains("Names/FaultInATable.IsFoundWithItsLineAndReason"));
    EXPECT_FALSE(facts.tests.contains("One.First")) << "a text of this file";
    EXPECT_TRUE(facts.benchmarks.contains("soft"));
}

}  // namespace
}  // namespace zoned::lint
