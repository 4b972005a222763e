#include "tests/lint/check.h"

#include "tests/lint/layers.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::lint {
namespace {

std::size_t include_findings(const std::string& path, const std::string& include) {
    return check_includes({path, "#include " + include + "\n"}).size();
}

void expect_allowed(const std::string& path, const std::string& include) {
    EXPECT_EQ(include_findings(path, include), 0U) << path << " includes " << include;
}

void expect_refused(const std::string& path, const std::string& include) {
    EXPECT_EQ(include_findings(path, include), 1U) << path << " includes " << include;
}

TEST(CheckIncludes, LetsAFolderIncludeItselfAndWhatStandsAboveIt) {
    expect_allowed("shared/motion/a.cpp", "\"shared/motion/a.h\"");
    expect_allowed("shared/motion/a.cpp", "\"shared/math/types.h\"");
    expect_allowed("server/world/a.h", "\"shared/motion/a.h\"");
    expect_allowed("server/zone/zone.cpp", "\"server/replication/replicator.h\"");
    expect_allowed("server/rules/a.cpp", "\"server/zone/rules.h\"");
    expect_allowed("server/session/a.cpp", "\"server/zone/rules.h\"");
    expect_allowed("server/main.cpp", "\"server/app/serve.h\"");
    expect_allowed("server/config/settings.cpp", "\"proto/config/config.pb.h\"");
    expect_allowed("server/session/a.cpp", "\"proto/session.pb.h\"");
    expect_allowed("server/physics/a.cpp", "\"kernels/include/particle.h\"");
}

TEST(CheckIncludes, RefusesWhatStandsBelow) {
    expect_refused("shared/core/a.h", "\"shared/math/types.h\"");
    expect_refused("shared/motion/a.h", "\"shared/wire/packet.h\"");
    expect_refused("shared/wire/a.h", "\"server/world/entities.h\"");
    expect_refused("server/world/a.h", "\"server/physics/scene/scene.h\"");
    expect_refused("server/physics/a.cpp", "\"server/zone/rules.h\"");
    expect_refused("server/zone/zone.cpp", "\"server/config/settings.h\"");
    expect_refused("server/rules/a.cpp", "\"server/net/udp.h\"");
    expect_refused("server/session/a.cpp", "\"server/app/serve.h\"");
    expect_refused("server/app/a.cpp", "\"proto/config/config.pb.h\"");
}

TEST(CheckIncludes, RefusesSiblings) {
    expect_refused("shared/math/a.h", "\"shared/clock/tick_clock.h\"");
    expect_refused("server/physics/a.cpp", "\"server/ai/ai_update.h\"");
    expect_refused("server/interest/a.cpp", "\"server/replication/replicator.h\"");
    expect_refused("server/replication/a.cpp", "\"server/interest/interest_rule.h\"");
    expect_refused("server/recording/a.cpp", "\"server/rules/sandbox.h\"");
}

TEST(CheckIncludes, LetsAiAskPhysicsItsQueriesOnly) {
    expect_allowed("server/ai/perception/perception.cpp", "\"server/physics/query/query.h\"");
    expect_allowed("server/ai/perception/perception.cpp", "\"server/physics/query/query_ray.h\"");
    expect_refused("server/ai/perception/perception.cpp", "\"server/physics/scene/scene.h\"");
    expect_refused("server/interest/a.cpp", "\"server/physics/query/query.h\"");
}

TEST(CheckIncludes, KeepsTheProgramsApart) {
    expect_allowed("client-sim/view/a.cpp", "\"client-sim/link/link.h\"");
    expect_allowed("client-sim/main.cpp", "\"client-sim/app/run.h\"");
    expect_allowed("client-sim/bot/a.cpp", "\"shared/wire/packet.h\"");
    expect_allowed("client-sim/link/a.cpp", "\"proto/session.pb.h\"");
    expect_refused("client-sim/link/a.cpp", "\"client-sim/view/view.h\"");
    for (const Layer& layer : kLayers) {
        if (layer.side == Side::kServer) {
            const std::string target = "\"" + std::string(layer.folder) +
                                       (layer.folder == "server" ? "/main.cpp\"" : "/a.h\"");
            expect_refused("client-sim/app/a.cpp", target);
        }
        if (layer.side == Side::kClient && layer.folder != "client-sim") {
            expect_refused("server/app/a.cpp", "\"" + std::string(layer.folder) + "/a.h\"");
        }
    }
}

TEST(CheckIncludes, KeepsThePureRowsPure) {
    for (const char* include : {"<asio.hpp>",
                                "<asio/ip/udp.hpp>",
                                "<spdlog/spdlog.h>",
                                "<google/protobuf/message.h>",
                                "\"proto/session.pb.h\"",
                                "<openssl/evp.h>",
                                "<thread>",
                                "<mutex>",
                                "<atomic>",
                                "<condition_variable>",
                                "<chrono>",
                                "<ctime>",
                                "<sys/time.h>",
                                "<random>"}) {
        expect_refused("shared/motion/a.cpp", include);
        expect_refused("server/physics/a.cpp", include);
        expect_refused("server/zone/a.h", include);
        expect_allowed("server/session/a.cpp", include);
        expect_allowed("client-sim/link/a.cpp", include);
    }
    expect_allowed("server/zone/a.h", "<vector>");
    expect_allowed("server/zone/a.h", "<Eigen/Core>");
}

TEST(CheckIncludes, LetsQueuesLockComputeThreadAndTheSealEncrypt) {
    expect_allowed("server/mailbox/bounded_queue.h", "<mutex>");
    expect_allowed("server/mailbox/bounded_queue.h", "<atomic>");
    expect_refused("server/mailbox/bounded_queue.h", "<thread>");
    expect_refused("server/mailbox/bounded_queue.h", "<chrono>");
    expect_allowed("server/compute/workers.cpp", "<thread>");
    expect_allowed("server/compute/workers.cpp", "<mutex>");
    expect_allowed("server/compute/workers.cpp", "<ctime>");
    expect_refused("server/compute/workers.cpp", "<chrono>");
    expect_refused("server/mailbox/bounded_queue.h", "<ctime>");
    expect_allowed("shared/wire/seal.cpp", "<openssl/evp.h>");
    expect_refused("shared/wire/seal.h", "<openssl/evp.h>");
}

TEST(CheckIncludes, RefusesPathsThatAreNotFromTheRootAndFoldersThatAreNotInTheTable) {
    expect_refused("server/zone/zone.cpp", "\"census.h\"");
    expect_refused("server/zone/zone.cpp", "\"../world/entities.h\"");
    expect_refused("server/zone/zone.cpp", "\"server/helpers/a.h\"");
    EXPECT_EQ(check_includes({"server/helpers/a.h", ""}).size(), 1U);
    EXPECT_EQ(check_includes({"server/stray.cpp", ""}).size(), 1U);
}

TEST(CheckIncludes, FindsTheLineWhateverItsSpacing) {
    const std::vector<Finding> findings = check_includes(
        {"shared/core/a.h", "// A.\n#pragma once\n  #  include   <chrono>  // why\n"});
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].line, 3);
    EXPECT_EQ(findings[0].path, "shared/core/a.h");
    EXPECT_NE(findings[0].what.find("chrono"), std::string::npos);
}

TEST(CheckIncludes, DoesNotMistakeACommentForAnInclude) {
    EXPECT_TRUE(check_includes({"shared/core/a.h", "// #include <chrono>\n"}).empty());
}

TEST(CheckIncludes, LetsTestsIncludeAnything) {
    expect_allowed("tests/unit/core/a_test.cpp", "\"server/app/serve.h\"");
}

TEST(CheckHeader, AsksForAPurposeAndAPragma) {
    EXPECT_TRUE(check_header({"shared/core/a.h", "// What it is for.\n#pragma once\n"}).empty());
    EXPECT_TRUE(
        check_header({"shared/core/a.h", "// What it is\n// for.\n#pragma once\n"}).empty());
    EXPECT_TRUE(check_header({"shared/core/a.cpp", "#include <vector>\n"}).empty());
    EXPECT_EQ(check_header({"shared/core/a.h", "#pragma once\n"}).size(), 1U);
    EXPECT_EQ(check_header({"shared/core/a.h", "//\n#pragma once\n"}).size(), 1U);
    EXPECT_EQ(check_header({"shared/core/a.h", "// What it is for.\n"}).size(), 1U);
    EXPECT_EQ(check_header({"shared/core/a.h", ""}).size(), 2U);
    const std::string example = "// What it is for.\n//\n//   example();\n\n#pragma once\n";
    EXPECT_TRUE(check_header({"shared/core/a.h", example}).empty());
    const std::string late = "// What it is for.\n#include <vector>\n#pragma once\n";
    EXPECT_EQ(check_header({"shared/core/a.h", late}).size(), 1U);
}

TEST(CheckLength, RefusesFilesOfMoreThanTheLimit) {
    const std::string longest(static_cast<std::size_t>(kMaxLines), '\n');
    EXPECT_TRUE(check_length({"server/zone/a.cpp", longest}).empty());
    EXPECT_EQ(check_length({"server/zone/a.cpp", longest + "\n"}).size(), 1U);
    EXPECT_EQ(check_length({"client-sim/view/a.cpp", longest + "x"}).size(), 1U);
    EXPECT_EQ(check_length({"shared/core/a.h", longest + "\n"}).size(), 1U);
    EXPECT_TRUE(check_length({"tests/unit/core/a_test.cpp", longest + "\n"}).empty());
}

TEST(CheckWords, FindsMarksOfUnfinishedWorkAsWholeWords) {
    const std::string words[] = {
        "TO"
        "DO",
        "FIX"
        "ME",
        "XX"
        "X",
        "HA"
        "CK"};
    for (const std::string& word : words) {
        const auto count = [](const std::string& line) {
            return check_words({"config/a.txtpb", "first\n" + line + "\n"}).size();
        };
        EXPECT_EQ(count("// " + word), 1U);
        EXPECT_EQ(count("// " + word + "(me): later"), 1U);
        EXPECT_EQ(count(word), 1U);
        EXPECT_EQ(count(word + word), 0U);
        EXPECT_EQ(count("k" + word), 0U);
        EXPECT_EQ(check_words({"a", "\n// " + word}).at(0).line, 2);
    }
    EXPECT_TRUE(check_words({"a", "all done\n"}).empty());
}

TEST(CheckSandbox, LetsOnlyRulesBotsAndTestsKnowTheGame) {
    const std::string text = "#include \"proto/sandbox.pb.h\"\n";
    EXPECT_TRUE(check_sandbox({"server/rules/sandbox.cpp", text}).empty());
    EXPECT_TRUE(check_sandbox({"client-sim/bot/fight.cpp", text}).empty());
    EXPECT_TRUE(check_sandbox({"tests/integration/a.cpp", text}).empty());
    EXPECT_EQ(check_sandbox({"server/zone/zone.cpp", text}).size(), 1U);
    EXPECT_EQ(check_sandbox({"client-sim/view/view.cpp", text}).size(), 1U);
    EXPECT_EQ(check_sandbox({"server/app/serve.cpp", text}).size(), 1U);
}

TEST(CheckTopLevel, KnowsItsNames) {
    EXPECT_TRUE(
        check_top_level({"CMakeLists.txt", "README.md", "server", ".git", "build-asan"}).empty());
    EXPECT_EQ(check_top_level({"scripts"}).size(), 1U);
    EXPECT_EQ(check_top_level({"src", "notes.md", "tests"}).size(), 2U);
}

TEST(CheckFile, RunsEveryCheck) {
    const std::string text =
        "#include <chrono>\n#include \"proto/sandbox.pb.h\"\n// TO"
        "DO\n" +
        std::string(static_cast<std::size_t>(kMaxLines), '\n');
    // Two includes, no purpose, no pragma, too long, one word, one mention of the game.
    EXPECT_EQ(check_file({"server/zone/a.h", text}).size(), 7U)
        << to_text(check_file({"server/zone/a.h", text}));
}

}  // namespace
}  // namespace zoned::lint
