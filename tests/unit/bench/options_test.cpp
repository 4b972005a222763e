#include "tests/bench/options.h"

#include <gmock/gmock.h>

namespace zoned::bench {
namespace {

std::optional<Options> parse(std::vector<const char*> line, int& code) {
    line.insert(line.begin(), "zoned-bench");
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const auto options = parse_options(static_cast<int>(line.size()), line.data(), code);
    testing::internal::GetCapturedStdout();
    testing::internal::GetCapturedStderr();
    return options;
}

TEST(Options, TakeSuitesAndListsOfNames) {
    int code = -1;
    const auto o = parse(
        {"physics", "--scene", "S1,S3", "--method", "default,bullet", "--repeat", "5", "--quick"},
        code);
    ASSERT_TRUE(o);
    EXPECT_THAT(o->suites, testing::ElementsAre("physics"));
    EXPECT_THAT(o->scenes, testing::ElementsAre("S1", "S3"));
    EXPECT_THAT(o->methods, testing::ElementsAre("default", "bullet"));
    EXPECT_EQ(o->repeats, 5);
    EXPECT_TRUE(o->quick);
}

TEST(Options, TakeReportsAndBaselines) {
    int code = -1;
    const auto o = parse({"--report",
                          "r.html",
                          "--picture",
                          "p.svg",
                          "--resume",
                          "k.json",
                          "--against",
                          "b.json",
                          "--advise-times",
                          "--baseline",
                          "n.json",
                          "--passes",
                          "3"},
                         code);
    ASSERT_TRUE(o);
    EXPECT_EQ(o->report, "r.html");
    EXPECT_EQ(o->picture_file, "p.svg");
    EXPECT_EQ(o->resume_file, "k.json");
    EXPECT_EQ(o->against_file, "b.json");
    EXPECT_EQ(o->baseline_file, "n.json");
    EXPECT_TRUE(o->advise_times);
    EXPECT_EQ(o->passes, 3);
}

TEST(Options, RefuseWhatIsUnknownOrOutOfRange) {
    int code = -1;
    EXPECT_FALSE(parse({"--fast"}, code));
    EXPECT_EQ(code, kBadUsage);
    EXPECT_FALSE(parse({"--repeat", "0"}, code));
    EXPECT_EQ(code, kBadUsage);
    code = -1;
    EXPECT_FALSE(parse({"--passes", "2"}, code));
    EXPECT_EQ(code, kBadUsage);
}

TEST(Options, EndWellAfterHelp) {
    int code = -1;
    EXPECT_FALSE(parse({"--help"}, code));
    EXPECT_EQ(code, kGood);
}

}  // namespace
}  // namespace zoned::bench
