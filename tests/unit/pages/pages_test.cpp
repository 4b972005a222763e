// The page test itself: it finds false statements on a page.
#include "tests/pages/play.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace {

namespace fs = std::filesystem;
using namespace zoned::pages;

class Pages : public ::testing::Test {
  protected:
    Pages() {
        std::string folder = (fs::temp_directory_path() / "unit-pages-XXXXXX").string();
        scratch_ = ::mkdtemp(folder.data());
        fs::create_directories(scratch_ / "zoned/config");
        fs::create_directories(scratch_ / "zoned/build");
        std::ofstream(scratch_ / "zoned/config/base.txtpb") << "good\n";
        // Stands in for the server: prints its usage, and takes configs without the word "bad".
        const fs::path program = scratch_ / "zoned/build/zoned";
        std::ofstream(program)
            << "#!/bin/bash\n"
               "if [[ $* == *--help* ]]; then echo; echo '  check '; echo '  --set'; exit; fi\n"
               "! grep bad \"$2\"\n";
        fs::permissions(program, fs::perms::owner_all);
        stage_ = {scratch_ / "zoned", scratch_};
    }

    ~Pages() override { fs::remove_all(scratch_); }

    static Page page(const std::string& text) { return read_page("PAGE.md", text); }

    Played played(const std::string& text) {
        const Page read = page(text);
        EXPECT_TRUE(read.defects.empty()) << read.defects.front().text;
        return play(read, stage_);
    }

    std::vector<Finding> mentioned(const std::string& text) {
        return wrong_mentions(page(text), stage_);
    }

    fs::path scratch_;
    Stage stage_;
};

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST_F(Pages, FindNothingThatAnEarlierPageChangedOrLeft) {
    const fs::path source = scratch_ / "source";
    for (const char* name :
         {"client-sim", "config", "docker", "kernels", "proto", "server/net", "shared", "tests"}) {
        fs::create_directories(source / name);
    }
    for (const char* name : {"CMakeLists.txt", "README.md", "config/a.txtpb", "server/net/b.cpp"}) {
        std::ofstream(source / name) << name;
    }
    const Stage first = set_stage(source, scratch_, scratch_ / "stage");
    EXPECT_EQ(text_of(first.root / "server/net/b.cpp"), "server/net/b.cpp");
    EXPECT_TRUE(fs::exists(first.root / "build/zoned/config/base.txtpb"));
    std::ofstream(first.root / "config/a.txtpb") << "other text in it";
    std::ofstream(first.root / "config/left.txtpb") << "left";
    fs::permissions(first.root / "README.md", fs::perms::owner_read);
    fs::remove_all(first.root / "server/net");
    std::ofstream(first.root / "server/net") << "a file where a folder was";
    fs::create_directories(first.root / "shared/left/far/down");
    fs::create_directories(first.scratch / "game/build");
    const Stage second = set_stage(source, scratch_, scratch_ / "stage");
    EXPECT_EQ(text_of(second.root / "config/a.txtpb"), "config/a.txtpb");
    EXPECT_EQ(text_of(second.root / "server/net/b.cpp"), "server/net/b.cpp");
    EXPECT_EQ(fs::status(second.root / "README.md").permissions(),
              fs::status(source / "README.md").permissions());
    EXPECT_FALSE(fs::exists(second.root / "config/left.txtpb"));
    EXPECT_FALSE(fs::exists(second.root / "shared/left"));
    EXPECT_FALSE(fs::exists(second.scratch / "game"));
    EXPECT_TRUE(fs::exists(source / "server/net/b.cpp"));
    EXPECT_TRUE(fs::exists(scratch_ / "zoned/config/base.txtpb"));  // behind the link to the build
}

TEST_F(Pages, PassWhenEveryBlockDoesWhatThePageSays) {
    const Played p = played(
        "Write `hello.txt`:\n<!-- page: file hello.txt -->\n```txt\nhello\n```\n"
        "```sh\ncat hello.txt\n```\n<!-- page: output -->\n```text\nhello\n```\n"
        "<!-- page: exit 3 -->\n```sh\nexit 3\n```\n");
    EXPECT_TRUE(p.failures.empty()) << p.failures.front().text;
    EXPECT_EQ(p.commands, 2);
}

TEST_F(Pages, FailAtACommandThatDoesNotExist) {
    const Played p = played("one\n\n```sh\nno-such-program --fast\n```\n");
    ASSERT_EQ(p.failures.size(), 1u);
    EXPECT_EQ(p.failures[0].line, 3);
}

TEST_F(Pages, FailAtOutputThatIsNotPrinted) {
    EXPECT_EQ(
        played("```sh\necho one; echo two\n```\n<!-- page: output -->\n```text\ntwo\none\n```\n")
            .failures.size(),
        1u);
    EXPECT_EQ(played("```sh\necho 17 bots\n```\n<!-- page: output -->\n```text\n18 bots\n```\n")
                  .failures.size(),
              1u);
}

TEST_F(Pages, TakeOtherNumbersOnlyWhereThePageSaysSo) {
    const std::string block =
        "```sh\necho took 17.5 ms\n```\n<!-- page: output numbers -->\n```text\ntook 3 ms\n```\n";
    EXPECT_TRUE(played(block).failures.empty());
    const std::string wrong =
        "```sh\necho took 17.5 ms\n```\n<!-- page: output numbers -->\n```text\ntook 3 s\n```\n";
    EXPECT_EQ(played(wrong).failures.size(), 1u);
}

TEST(PrintedLines, MayHaveOtherNumbersAndOthersBetween) {
    std::string missing;
    EXPECT_TRUE(has_lines("a 1.5e-05 m\nx\nb  2\n", "a 17 m\nb 3\n", true, missing));
    EXPECT_TRUE(has_lines("hash 1a2b, ok\n", "hash ..., ok\n", false, missing));
    EXPECT_FALSE(has_lines("b 2\na 1\n", "a 1\nb 2\n", false, missing));
    EXPECT_EQ(missing, "b 2");
    EXPECT_FALSE(has_lines("verdict: inconsistent\n", "verdict: consistent\n", true, missing));
    EXPECT_TRUE(has_lines(
        "verdict: consistent, with a warning: late\n", "verdict: consistent\n", true, missing));
    EXPECT_FALSE(has_lines("verdict: consistent, no\n", "verdict: consistent\n", true, missing));
}

TEST_F(Pages, FailAtAnotherExitCode) {
    EXPECT_EQ(played("```sh\nexit 1\n```\n").failures.size(), 1u);
    EXPECT_EQ(played("<!-- page: exit 1 -->\n```sh\ntrue\n```\n").failures.size(), 1u);
}

TEST_F(Pages, FailAtTheFirstOfSeveralCommands) {
    EXPECT_EQ(played("```sh\nfalse\ntrue\n```\n").failures.size(), 1u);
}

TEST_F(Pages, FailWhereACommandTakesTooLong) {
    const Played p = played("<!-- page: seconds 0.2 -->\n```sh\nsleep 20\n```\n");
    ASSERT_EQ(p.failures.size(), 1u);
    EXPECT_NE(p.failures[0].text.find("took more than"), std::string::npos);
}

TEST_F(Pages, GoOnWhereTheReaderStands) {
    EXPECT_TRUE(played("```sh\nmkdir a\ncd a\n```\n```sh\ncd ../a\n```\n").failures.empty());
    EXPECT_EQ(played("```sh\nmkdir b\ncd b\n```\n```sh\ncd b\n```\n").failures.size(), 1u);
}

TEST_F(Pages, KeepAProgramInTheBackgroundUntilItIsStopped) {
    const std::string server =
        "<!-- page: background ready -->\n```sh\nbash -c 'trap \"exit CODE\" TERM; echo ready; "
        "while :; do sleep 0.05; done'\n```\n"
        "```sh\necho meanwhile\n```\n<!-- page: stop -->\n";
    const auto with_code = [&](const std::string& code) {
        std::string text = server;
        return text.replace(text.find("CODE"), 4, code);
    };
    EXPECT_TRUE(played(with_code("0")).failures.empty());
    EXPECT_EQ(played(with_code("1")).failures.size(), 1u);
    EXPECT_EQ(played("<!-- page: background ready -->\n```sh\necho dead\n```\n").failures.size(),
              1u);
}

TEST_F(Pages, CheckWhatIsAddedToAConfig) {
    EXPECT_TRUE(played("<!-- page: extends config/base.txtpb -->\n```txtpb\nbetter\n```\n")
                    .failures.empty());
    EXPECT_EQ(
        played("<!-- page: extends config/base.txtpb -->\n```txtpb\nbad\n```\n").failures.size(),
        1u);
}

TEST_F(Pages, GiveTheReaderPortsThatAreFree) {
    EXPECT_EQ(
        played("<!-- page: ports 7777 -->\n```sh\n[ 7777 = 17777 ] || [ 7777 != 77'77' ]\n```\n")
            .failures.size(),
        0u);
    EXPECT_EQ(played("<!-- page: ports 7777 -->\n```sh\n[ 7777 = 77'77' ]\n```\n").failures.size(),
              1u);
    EXPECT_EQ(played("<!-- page: ports 7777 -->\n<!-- page: append 7777 -->\n"
                     "```sh\ntest 77'77' !=\n```\n")
                  .failures.size(),
              0u);
}

TEST_F(Pages, SayWhatTheyDoNotRun) {
    const Played p = played(
        "<!-- page: skip it takes a day -->\n```sh\nsleep 86400\n```\n"
        "<!-- page: append --quick -->\n```sh\necho\n```\n");
    ASSERT_EQ(p.skipped.size(), 1u);
    EXPECT_EQ(p.skipped[0].text, "it takes a day");
    EXPECT_EQ(p.shortened.size(), 1u);
}

TEST_F(Pages, HaveNoBlockOfWhichNothingIsSaid) {
    EXPECT_EQ(page("```\nls\n```\n").defects.size(), 1u);
    EXPECT_EQ(page("```txtpb\nworld { }\n```\n").defects.size(), 1u);
    EXPECT_EQ(page("<!-- page: skip -->\n```sh\nls\n```\n").defects.size(), 1u);
    EXPECT_EQ(page("<!-- page: skipp it -->\n```sh\nls\n```\n").defects.size(), 1u);
    EXPECT_EQ(page("<!-- page: exit 1 -->\n\nWords.\n```sh\nls\n```\n").defects.size(), 1u);
    EXPECT_EQ(page("```sh\nls\n").defects.size(), 1u);
    EXPECT_TRUE(page("```text\na picture\n```\n").defects.empty());
}

TEST_F(Pages, NameNothingThatDoesNotExist) {
    EXPECT_TRUE(
        mentioned(
            "`config/base.txtpb`, `zoned check --set a=b`, [base](config/base.txtpb), `a/b`\n")
            .empty());
    EXPECT_EQ(mentioned("`config/none.txtpb`\n").size(), 1u);
    EXPECT_EQ(mentioned("[none](config/none.txtpb)\n").size(), 1u);
    EXPECT_EQ(mentioned("`zoned chekc FILE`\n").size(), 1u);
    EXPECT_EQ(mentioned("`zoned check --sett a=b`\n").size(), 1u);
}

}  // namespace
