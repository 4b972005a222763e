#include "tests/lint/text.h"

#include <gtest/gtest.h>

namespace zoned::lint {
namespace {

TEST(CodeOf, BlanksCommentsAndLiteralsAndKeepsPlaces) {
    const auto same_size = [](std::string_view text) {
        const std::string code = code_of(text);
        EXPECT_EQ(code.size(), text.size());
        return code;
    };
    EXPECT_EQ(same_size("a; // b\nc"), "a;     \nc");
    EXPECT_EQ(same_size("a /* b\nc */ d"), "a     \n     d");
    EXPECT_EQ(same_size("f(\"a // \\\" b\", c)"), "f(\"         \", c)");
    EXPECT_EQ(same_size("x = '\"'; y"), "x = ' '; y");
    EXPECT_EQ(same_size("n = 1'000'000; y"), "n = 1'000'000; y");
    EXPECT_EQ(same_size("s = R\"x(a \" )\" b)x\"; y"), "s =                ; y");
}

TEST(CodeOf, TakesAHashForACommentInConfigs) {
    EXPECT_EQ(code_of("a: 1 # b\nc", true), "a: 1    \nc");
    EXPECT_EQ(code_of("a: \"# b\" c", true), "a: \"   \" c");
}

TEST(OpeningComment, EndsWithTheFirstLineThatIsNone) {
    EXPECT_EQ(opening_comment("// A.\n// B.\n\n// C.\n"), "// A.\n// B.\n");
    EXPECT_EQ(opening_comment("#pragma once\n// A.\n"), "");
}

TEST(Paths, AreCutIntoFolderNameAndStem) {
    EXPECT_EQ(folder_of("server/ai/a.h"), "server/ai");
    EXPECT_EQ(folder_of("a.h"), "");
    EXPECT_EQ(name_of("server/ai/a.h"), "a.h");
    EXPECT_EQ(stem_of("server/ai/a.h"), "server/ai/a");
    EXPECT_TRUE(is_product("kernels/include/a.h"));
    EXPECT_FALSE(is_product("tests/unit/a.cpp"));
    EXPECT_FALSE(is_product("server/README.md"));
}

}  // namespace
}  // namespace zoned::lint
