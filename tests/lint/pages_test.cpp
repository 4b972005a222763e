#include "tests/lint/pages.h"

#include <gtest/gtest.h>

#include <string>

namespace zoned::lint {
namespace {

std::vector<int> counts(std::string_view text) {
    std::vector<int> words;
    for (const Sentence& sentence : sentences_of(text)) {
        words.push_back(sentence.words);
    }
    return words;
}

using Counts = std::vector<int>;

std::string sentence(int words) {
    std::string text = "Word";
    for (int i = 1; i < words; ++i) {
        text += " word";
    }
    return text + ".\n";
}

TEST(SentencesOf, EndAtMarksParagraphsAndListItems) {
    EXPECT_EQ(counts("One two. Three four\nfive! Six?\n\nSeven eight\n\n- nine ten\n- eleven\n"
                     "12. twelve\n"),
              (Counts{2, 3, 1, 2, 2, 1, 1}));
}

TEST(SentencesOf, DoNotEndAtNumbersPathsAndAbbreviations) {
    EXPECT_EQ(counts("It takes 0.5 ms in `a.cpp`, e.g. on two cores (see README.md).\n"),
              Counts{12});
    EXPECT_EQ(counts("The *end.* And (more.) Done.\n"), (Counts{2, 2, 1}));
    EXPECT_EQ(counts("Zones - and only zones - have them.\n"), Counts{6}) << "dashes are no words";
}

TEST(SentencesOf, LeaveOutCodeTablesHeadingsAndComments) {
    EXPECT_EQ(counts("# A heading of words\n\nOne two\n```sh\nrun this. now\n```\n| a | b c d |\n"
                     "<!-- not\nthis -->\nThree.\n"),
              (Counts{2, 1}));
}

TEST(CheckPage, RefusesALongSentence) {
    EXPECT_TRUE(check_page({"a.md", sentence(2) + sentence(10) + sentence(40)}).empty());
    const std::vector<Finding> findings =
        check_page({"a.md", sentence(2) + sentence(10) + sentence(41)});
    ASSERT_EQ(findings.size(), 1U) << to_text(findings);
    EXPECT_EQ(findings[0].line, 3);
    EXPECT_TRUE(check_page({"a.txt", sentence(41)}).empty());
}

TEST(CheckPage, RefusesALongMean) {
    EXPECT_TRUE(check_page({"a.md", sentence(19) + sentence(21)}).empty());
    EXPECT_EQ(check_page({"a.md", sentence(20) + sentence(21)}).size(), 1U);
}

TEST(CheckPage, RefusesALongCell) {
    const std::string cell(kMostInCell, 'x');
    EXPECT_TRUE(check_page({"a.md", "| a | " + cell + " |\n"}).empty());
    EXPECT_EQ(check_page({"a.md", "| a | " + cell + "x |\n"}).size(), 1U);
    EXPECT_EQ(check_page({"a.md", "| " + cell + "\\|x | b |\n"}).size(), 1U)
        << "an escaped bar ends no cell";
    EXPECT_TRUE(check_page({"a.md", "```\n| " + cell + "x |\n```\n"}).empty());
}

TEST(CheckPage, PassesAnEmptyOne) {
    EXPECT_TRUE(check_page({"a.md", "# Title\n"}).empty());
}

}  // namespace
}  // namespace zoned::lint
