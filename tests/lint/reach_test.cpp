#include "tests/lint/reach.h"

#include <gtest/gtest.h>

namespace zoned::lint {
namespace {

std::string include(const std::string& path) {
    return "#include \"" + path + "\"\n";
}

/// Two programs of one header and source each, and further files.
std::vector<SourceFile> tree(std::vector<SourceFile> more) {
    std::vector<SourceFile> files{
        {"client-sim/app/run.cpp", include("client-sim/app/run.h")},
        {"client-sim/app/run.h", "// Runs.\n"},
        {"client-sim/main.cpp", include("client-sim/app/run.h")},
        {"server/app/serve.cpp", include("server/app/serve.h") + include("server/zone/zone.h")},
        {"server/app/serve.h", "// Serves.\n"},
        {"server/main.cpp", include("server/app/serve.h")},
        {"server/zone/zone.cpp", include("server/zone/zone.h")},
        {"server/zone/zone.h", "// A zone.\n"},
    };
    files.insert(files.end(), more.begin(), more.end());
    return files;
}

std::vector<std::string> unreached(std::vector<SourceFile> more) {
    std::vector<std::string> paths;
    for (const Finding& finding : check_reached(tree(std::move(more)))) {
        paths.push_back(finding.path);
    }
    return paths;
}

using Paths = std::vector<std::string>;

TEST(CheckReached, FollowsIncludesFromBothPrograms) {
    EXPECT_EQ(unreached({}), Paths{});
}

TEST(CheckReached, FindsWhatOnlyTestsInclude) {
    EXPECT_EQ(unreached({{"server/zone/idle.cpp", include("server/zone/idle.h")},
                         {"server/zone/idle.h", include("shared/core/only.h")},
                         {"shared/core/only.h", "// Only.\n"},
                         {"tests/unit/idle_test.cpp", include("server/zone/idle.h")}}),
              (Paths{"server/zone/idle.cpp", "server/zone/idle.h", "shared/core/only.h"}));
}

TEST(CheckReached, DoesNotTakeAnIncludingSourceForAReachedOne) {
    // It includes what is reached, but nothing that is reached declares what it defines.
    EXPECT_EQ(unreached({{"server/zone/idle.cpp",
                          include("server/zone/idle.h") + include("server/zone/zone.h")},
                         {"server/zone/idle.h", "// Idle.\n"}}),
              (Paths{"server/zone/idle.cpp", "server/zone/idle.h"}));
}

TEST(CheckReached, GivesASourceWithoutAHeaderOfItsNameToTheOneWithTheMostWordsOfIt) {
    const SourceFile part{"server/zone/zone_step_part.cpp",
                          include("server/zone/ghosts.h") + include("server/zone/zone.h") +
                              include("server/zone/zone_step.h")};
    const SourceFile ghosts{"server/zone/ghosts.h", "// Ghosts.\n"};
    const SourceFile step{"server/zone/zone_step.h", "// The step.\n"};
    EXPECT_EQ(
        unreached({part, ghosts, step}),
        (Paths{
            "server/zone/ghosts.h", "server/zone/zone_step.h", "server/zone/zone_step_part.cpp"}))
        << "zone.h is reached, zone_step.h is not";
    const SourceFile user{"server/zone/zone_user.cpp",
                          include("server/zone/zone.h") + include("server/zone/zone_step.h")};
    EXPECT_EQ(unreached({part, ghosts, step, user}), Paths{});
}

TEST(CheckReached, TakesTheRegisteredRulesAsAWhole) {
    EXPECT_EQ(unreached({{"server/rules/game.cpp", include("server/rules/game.h")},
                         {"server/rules/game.h", "// A game.\n"}}),
              Paths{});
}

TEST(CheckReached, WantsKernelsToBeNamedByAReachedSource) {
    const SourceFile kernel{"kernels/fall.cl", include("kernels/include/fall.h")};
    const SourceFile header{"kernels/include/fall.h", "// Falls.\n"};
    EXPECT_EQ(unreached({kernel, header}), (Paths{"kernels/fall.cl", "kernels/include/fall.h"}));
    const SourceFile stage{"server/zone/zone_fall.cpp",
                           include("server/zone/zone.h") + "make(\"kernels/fall.cl\");\n"};
    EXPECT_EQ(unreached({kernel, header, stage}), Paths{});
}

TEST(CheckReached, ExceptsWhatSaysSoAndItsSource) {
    const std::string note =
        "// Idle.\n// " + std::string(kUnreachedNote) + "a game will use it.\n";
    EXPECT_EQ(unreached({{"server/zone/idle.cpp", include("server/zone/idle.h")},
                         {"server/zone/idle.h", note}}),
              Paths{});
    const std::string broken = "// Idle. Reached by no\n// program yet: a game will use it.\n";
    EXPECT_EQ(unreached({{"server/zone/idle_device.cpp", include("server/zone/idle.h")},
                         {"server/zone/idle.h", broken}}),
              Paths{})
        << "a source without a header of its name";
    EXPECT_EQ(unreached({{"server/zone/idle.h", "// Idle.\n#pragma once\n" + note}}),
              Paths{"server/zone/idle.h"})
        << "it stands in the opening comment";
}

TEST(CheckReached, FindsANoteOnWhatIsReached) {
    const std::string note = "// A zone.\n// " + std::string(kUnreachedNote) + "a game.\n";
    std::vector<SourceFile> files = tree({});
    files.back().text = note;
    const std::vector<Finding> findings = check_reached(files);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].path, "server/zone/zone.h");
}

}  // namespace
}  // namespace zoned::lint
