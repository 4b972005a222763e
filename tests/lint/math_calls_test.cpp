#include "tests/lint/math_calls.h"

#include <gtest/gtest.h>

namespace zoned::lint {
namespace {

std::size_t found(const std::string& line, const std::string& path = "server/physics/a.cpp") {
    return check_math_calls({path, line + "\n"}).size();
}

TEST(CheckMathCalls, FindsTheLibrarysFunctionsHoweverTheyAreNamed) {
    for (const char* line : {"x = std::sin(y);",
                             "x = ::cos(y);",
                             "x = 2.0F * atan2(y, z);",
                             "return sqrtf(sinf(x));",
                             "return exp(x);",
                             "return log(x);",
                             "x = y - std::log(z);",
                             "x = __builtin_cosf(y);",
                             "x = std::hypotf(y, z);",
                             "v = a.array().exp();",
                             "q = Eigen::AngleAxisf(angle, axis);",
                             "r = a.slerp(0.5F, b);",
                             "p += std :: pow (x, 2);"}) {
        EXPECT_EQ(found(line), 1U) << line;
    }
    EXPECT_EQ(check_math_calls({"shared/motion/a.h", "\n\nx = std::sin(y);\n"}).at(0).line, 3);
}

TEST(CheckMathCalls, LetsExactFunctionsAndOtherThingsOfThoseNamesBe) {
    for (const char* line : {"x = elementary::sin(y);",
                             "x = std::sqrt(y) + std::floor(z) + std::remainder(y, z);",
                             "x = std::fmod(std::abs(y), z);",
                             "out.log = expand_log(config.log(), level);",
                             "to_->log(message);",
                             "void log(std::string_view line);",
                             "void Host::log(std::string_view line) {",
                             "std::string log(size, '\\0');",
                             "const double exp = 2.0;",
                             "// std::sin(x) is what this replaces",
                             "text = \"std::sin(x)\";"}) {
        EXPECT_EQ(found(line), 0U) << line;
    }
}

TEST(CheckMathCalls, LooksAtWhatComputesAndNotAtPagesAndTests) {
    const std::string line = "x = std::sin(y);";
    for (const char* path : {"server/config/a.cpp", "client-sim/bot/a.cpp", "shared/wire/a.h"}) {
        EXPECT_EQ(found(line, path), 1U) << path;
    }
    for (const char* path : {"server/admin/a.cpp",
                             "server/app/admin/a.cpp",
                             "shared/core/elementary/sines.cpp",
                             "tests/unit/core/a_test.cpp",
                             "server/physics/README.md"}) {
        EXPECT_EQ(found(line, path), 0U) << path;
    }
}

}  // namespace
}  // namespace zoned::lint
