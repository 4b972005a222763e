#include "shared/core/files/line_reader.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace zoned::core {
namespace {

TEST(LineReader, CutsLinesWhateverTheyEndWith) {
    LineReader in("a\nb\r\nc\rd\n\ne");
    for (const char* line : {"a", "b", "c", "d", "", "e"}) {
        ASSERT_TRUE(in.next());
        EXPECT_EQ(in.rest(), line);
    }
    EXPECT_EQ(in.line(), 6U);
    EXPECT_FALSE(in.next());
    EXPECT_EQ(in.rest(), "");
    EXPECT_EQ(in.line(), 6U);
    EXPECT_FALSE(LineReader("").next());
}

TEST(LineReader, CutsWordsAtBlanksAndPassesEmptyLinesAndComments) {
    LineReader in("\n \t\n# nothing\n  one\ttwo # three\nfour", '#');
    ASSERT_TRUE(in.next_written());
    EXPECT_EQ(in.line(), 4U);
    EXPECT_EQ(in.word(), "one");
    EXPECT_EQ(in.rest(), "\ttwo ");
    EXPECT_EQ(in.word(), "two");
    EXPECT_EQ(in.word(), "");
    EXPECT_EQ(in.word(), "");
    ASSERT_TRUE(in.next_written());
    EXPECT_EQ(in.word(), "four");
    EXPECT_FALSE(in.next_written());
}

TEST(LineReader, ReadsNumbersThatTheWholeWordIs) {
    LineReader in("12 -3 0.5 7x 300 ");
    ASSERT_TRUE(in.next());
    EXPECT_EQ(in.number<int>(), 12);
    EXPECT_EQ(in.number<int>(), -3);
    EXPECT_EQ(in.number<double>(), 0.5);
    EXPECT_EQ(in.number<int>(), std::nullopt);
    EXPECT_EQ(in.number<std::uint8_t>(), std::nullopt) << "does not fit";
    EXPECT_EQ(in.number<int>(), std::nullopt) << "nothing is left";
    EXPECT_EQ(parse_number<int>(""), std::nullopt);
    EXPECT_EQ(parse_number<int>(" 1"), std::nullopt);
}

TEST(LineReader, KeepsTheFirstFailureWithItsLine) {
    LineReader in("a\nb\n");
    EXPECT_FALSE(in.failed());
    EXPECT_EQ(in.error(), "");
    in.next();
    in.next();
    EXPECT_FALSE(in.fail("is wrong"));
    EXPECT_FALSE(in.fail_at(7, "is worse"));
    EXPECT_TRUE(in.failed());
    EXPECT_EQ(in.error(), "line 2: is wrong");
    LineReader before("");
    before.fail("is empty");
    EXPECT_EQ(before.error(), "line 1: is empty");
}

TEST(Quoted, ShowsAsMuchOfAWordAsAMessageHolds) {
    EXPECT_EQ(quoted("abc"), "'abc'");
    EXPECT_EQ(quoted("abcdef", 3), "'abc...'");
    EXPECT_EQ(quoted("a\n\x80"),
              "'a?"
              "?'");
}

TEST(Trimmed, TakesBlanksOffBothEnds) {
    EXPECT_EQ(trimmed(" \ta b\t "), "a b");
    EXPECT_EQ(trimmed(" \t"), "");
    EXPECT_EQ(trimmed(""), "");
}

}  // namespace
}  // namespace zoned::core
