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

TEST(Options, RefuseWhatIsUnknownOrOutOfRange) {
    int code = -1;
    EXPECT_FALSE(parse({"--fast"}, code));
    EXPECT_EQ(code, kBadUsage);
    EXPECT_FALSE(parse({"--repeat", "0"}, code));
    EXPECT_EQ(code, kBadUsage);
}

TEST(Options, EndWellAfterHelp) {
    int code = -1;
    EXPECT_FALSE(parse({"--help"}, code));
    EXPECT_EQ(code, kGood);
}

}  // namespace
}  // namespace zoned::bench
