#include "tests/lint/names.h"

#include <gtest/gtest.h>

#include <array>

namespace zoned::lint {
namespace {

std::vector<std::string> type_names(std::string_view text) {
    std::vector<std::string> names;
    for (const TypeDefinition& type : types_of(text)) {
        names.push_back(type.name);
    }
    return names;
}

using Names = std::vector<std::string>;

TEST(TypesOf, FindsEveryKindAndWhatIsNested) {
    EXPECT_EQ(type_names("namespace a::b {\n"
                         "struct One { int x = 0; };\n"
                         "class Two final : public One {\n"
                         "  public:\n"
                         "    enum class Three : int { kA, kB } three = Three::kA;\n"
                         "    union Four { int i; float f; };\n"
                         "};\n"
                         "template <class T, class U = std::vector<T>>\n"
                         "class Five : public Base<T> {};\n"
                         "struct alignas(16) Six {};\n"
                         "struct [[nodiscard]] Seven {};\n"
                         "enum Eight { kC };\n"
                         "}\n"),
              (Names{"One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight"}));
}

TEST(TypesOf, LeavesOutDeclarationsSpecialisationsAndUses) {
    EXPECT_EQ(type_names("class Later;\n"
                         "template <>\nstruct IntsOf<float> { using type = int; };\n"
                         "struct Whole::Impl { int x; };\n"
                         "struct Made make() { return {}; }\n"
                         "template <class T>\nvoid use(T t) { t(); }\n"
                         "struct { int x; } unnamed;\n"
                         "const struct Other value = {1};\n"),
              Names{});
}

TEST(TypesOf, LeavesOutFunctionsAndAnonymousNamespaces) {
    EXPECT_EQ(type_names("void f() { struct Local { int x; }; }\n"
                         "namespace {\nstruct Hidden { struct Inner {}; };\n}\n"
                         "inline auto g = [] { struct InLambda {}; return 1; };\n"
                         "struct Seen {};\n"),
              Names{"Seen"});
}

TEST(TypesOf, IsNotMisledByCommentsStringsAndMacros) {
    EXPECT_EQ(type_names("// struct A {\n/* class B { */\nconst char* s = \"struct C {\";\n"
                         "#define D struct E { \\\n  int x; }\nstruct F {};\n"),
              Names{"F"});
    EXPECT_EQ(types_of("\n\nstruct F {};").at(0).line, 3);
}

TEST(CheckTypeNames, FindsANameThatOccursTwice) {
    const std::vector<SourceFile> files{
        {"server/ai/a.h", "namespace ai { class Tree { struct Node {}; }; }"},
        {"server/spatial/b.h", "namespace spatial { struct Node {}; }"},
        {"server/spatial/b.cpp", "namespace spatial { struct Tree {}; }"},
        {"tests/a.h", "struct Node {};"},
    };
    const std::vector<Finding> findings = check_type_names(files, {});
    ASSERT_EQ(findings.size(), 1U) << to_text(findings);
    EXPECT_NE(findings[0].what.find("Node occurs 2 times"), std::string::npos);
    static constexpr std::array<std::string_view, 1> kAgreed{"Node"};
    EXPECT_TRUE(check_type_names(files, kAgreed).empty());
}

TEST(CheckHeaderNames, FindsANameThatOccursTwice) {
    const std::vector<SourceFile> files{{"server/ai/query.h", ""},
                                        {"server/physics/query.h", ""},
                                        {"server/ai/query.cpp", ""},
                                        {"tests/unit/query.h", ""}};
    EXPECT_EQ(check_header_names(files, {}).size(), 1U);
    static constexpr std::array<std::string_view, 1> kAgreed{"query.h"};
    EXPECT_TRUE(check_header_names(files, kAgreed).empty());
}

TEST(WordsOf, CutsAtUnderscoresAndCapitals) {
    EXPECT_EQ(words_of("path_of_way"), (Names{"path", "of", "way"}));
    EXPECT_EQ(words_of("WayMap"), (Names{"way", "map"}));
    EXPECT_EQ(words_of("kMostWays2"), (Names{"most", "ways"}));
    EXPECT_EQ(words_of("UDPWay"), (Names{"udp", "way"}));
    EXPECT_EQ(words_of("halfway_"), (Names{"halfway"}));
}

class CheckRenamedWords : public testing::Test {
  protected:
    static std::size_t findings(const std::string& text,
                                const std::string& path = "server/ai/a.h") {
        static constexpr std::array<std::string_view, 1> kDirection{"one_way"};
        static constexpr std::array kWords{RenamedWord{"way", "path", "", kDirection},
                                           RenamedWord{"walk_mesh", "navmesh", "", {}},
                                           RenamedWord{"wish", "velocity", "server/ai/", {}}};
        return check_renamed_words({path, text}, kWords).size();
    }
};

TEST_F(CheckRenamedWords, FindsThemAsPartsOfIdentifiers) {
    EXPECT_EQ(findings("int way;"), 1U);
    EXPECT_EQ(findings("class WayMap;"), 1U);
    EXPECT_EQ(findings("int kMostWay = 1;"), 1U);
    EXPECT_EQ(findings("WalkMesh mesh; int walk_meshes;"), 1U);
    EXPECT_EQ(findings("optional Way way = 1;", "proto/config.proto"), 2U);
    EXPECT_EQ(findings("way { } # way\n", "config/a.txtpb"), 1U);
}

TEST_F(CheckRenamedWords, FindsThemInTheirPlace) {
    EXPECT_EQ(findings("Vec3 wish;"), 1U);
    EXPECT_EQ(findings("Codec wish;", "server/replication/a.h"), 0U);
}

TEST_F(CheckRenamedWords, LetsOtherWordsCommentsStringsAndExceptionsBe) {
    EXPECT_EQ(findings("int halfway; int runaway; double kOneWay_s;"), 0U);
    EXPECT_EQ(findings("// the way back\nf(\"way\");\n"), 0U);
    EXPECT_EQ(findings("int walk; int mesh;"), 0U);
    EXPECT_EQ(findings("int way;", "tests/unit/a_test.cpp"), 0U);
    EXPECT_EQ(findings("a way of life", "server/README.md"), 0U);
}

}  // namespace
}  // namespace zoned::lint
