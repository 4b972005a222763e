#include "tests/lint/local_names.h"

#include <gtest/gtest.h>

namespace zoned::lint {
namespace {

std::string read_local(std::string_view text) {
    std::string found;
    for (const LocalName& local : local_names_of(text)) {
        found += local.scope + "::" + local.name + local.parameters + " ";
    }
    return found;
}

TEST(LocalNamesOf, FindsValuesFunctionsTypesAndAliases) {
    EXPECT_EQ(
        read_local("namespace zoned::ai {\nnamespace {\n"
                   "constexpr float kReach = 2.0F;\n"
                   "const std::array<int, 3> kSizes{1, 2, 3};\n"
                   "int kTable[2] = {1, 2};\n"
                   "struct Near final : Base { int inner = 0; };\n"
                   "enum class Side : int { kLeft };\n"
                   "using List = std::vector<int>;\n"
                   "template <class T, class U = std::array<T, 2>>\n"
                   "T twice(const T& t, int n = 2) { int local = 1; return t * n; }\n"
                   "constexpr auto kMore = [](int a) { return a; };\n"
                   "}\n}\n"),
        "zoned::ai::kReach zoned::ai::kSizes zoned::ai::kTable zoned::ai::Near zoned::ai::Side "
        "zoned::ai::List=std::vector<int> zoned::ai::twice(const T&t,int n=2) zoned::ai::kMore ");
}

TEST(LocalNamesOf, LeavesOutWhatIsDeclaredOrBelongsElsewhere) {
    EXPECT_EQ(read_local("namespace zoned {\nint global = 1;\nvoid free() {}\nnamespace {\n"
                         "void later(int a);\nstruct Later;\n"
                         "void Type::method() {}\nbool operator==(A a, B b) { return true; }\n"
                         "}\nint after() { return 1; }\n}\n"),
              "");
}

std::size_t findings(std::string_view one, std::string_view two, const std::string& path) {
    const auto local = [](std::string_view text) {
        return "namespace zoned {\nnamespace {\n" + std::string(text) + "\n}\n}\n";
    };
    return check_local_names({{"server/ai/crowd/a.cpp", local(one)}, {path, local(two)}}).size();
}

TEST(CheckLocalNames, FindsTheSameNameInTwoSourcesOfALibrary) {
    EXPECT_EQ(findings("int kA = 1;", "int kA = 2;", "server/ai/steering/b.cpp"), 1U);
    EXPECT_EQ(findings("int kA = 1;", "int kA = 2;", "server/physics/b.cpp"), 0U);
    EXPECT_EQ(findings("int kA = 1;", "int kB = 2;", "server/ai/b.cpp"), 0U);
    EXPECT_EQ(findings("struct A {};", "int A() { return 1; }", "server/ai/b.cpp"), 1U);
}

TEST(CheckLocalNames, LetsAliasesOfTheSameThingAgree) {
    EXPECT_EQ(findings("namespace fs = std::filesystem;",
                       "namespace fs = std::filesystem;",
                       "server/ai/b.cpp"),
              0U);
    EXPECT_EQ(findings("using A = int;", "using A = float;", "server/ai/b.cpp"), 1U);
}

TEST(CheckLocalNames, LetsFunctionsDifferInTheirParameters) {
    EXPECT_EQ(
        findings("int f(int a) { return a; }", "int f(int a) { return -a; }", "server/ai/b.cpp"),
        1U);
    EXPECT_EQ(findings("int f(int a) { return a; }", "int f(A a) { return 1; }", "server/ai/b.cpp"),
              0U);
}

}  // namespace
}  // namespace zoned::lint
