// A browser's build computes what the server computes, to the last bit.
#include "tests/web/motion_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>

namespace zoned::testing_web {
namespace {

/// All that a program prints.
std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
    std::string out;
    char part[65536];
    for (std::size_t size = 0; (size = std::fread(part, 1, sizeof(part), pipe.get())) > 0;) {
        out.append(part, size);
    }
    return out;
}

/// The numbers of a subject as the module gives them in Node.
std::vector<float> module_numbers(std::size_t subject) {
    const std::string file = ZONED_BINARY_DIR "/web/motion_bits.wasm";
    const std::string script =
        "const system = {fd_write: () => 8, fd_close: () => 8, fd_seek: () => 8, proc_exit() {}};"
        "WebAssembly.instantiate(require('fs').readFileSync(process.argv[1]), "
        "{wasi_snapshot_preview1: system}).then(({instance: {exports: e}}) => { e._initialize();"
        "const n = e.bits_count(Number(process.argv[2]));"
        "process.stdout.write(Buffer.from(e.memory.buffer, e.bits_numbers(), 4 * n)); });";
    const std::string bytes =
        output_of("node -e \"" + script + "\" " + file + " " + std::to_string(subject));
    std::vector<float> out(bytes.size() / sizeof(float));
    std::memcpy(out.data(), bytes.data(), out.size() * sizeof(float));
    return out;
}

class MotionBits : public ::testing::TestWithParam<std::size_t> {};

TEST_P(MotionBits, AreThoseOfTheServersBuild) {
    const std::size_t subject = GetParam();
    const std::vector<float> here = numbers_of(subject);
    const std::vector<float> there = module_numbers(subject);
    ASSERT_GE(here.size(), 40U);
    ASSERT_EQ(there.size(), here.size()) << "is node installed, and the module built?";
    std::size_t unequal = 0;
    float worst = 0.0F;
    for (std::size_t i = 0; i < here.size(); ++i) {
        if (std::bit_cast<std::uint32_t>(here[i]) != std::bit_cast<std::uint32_t>(there[i])) {
            ++unequal;
            worst = std::max(worst, std::abs(here[i] - there[i]));
        }
    }
    std::printf("%-20s %6zu numbers, %5zu unequal, at most by %.2g\n",
                std::string(kSubjects[subject]).c_str(),
                here.size(),
                unequal,
                static_cast<double>(worst));
    EXPECT_EQ(unequal, 0U);
}

INSTANTIATE_TEST_SUITE_P(Subjects,
                         MotionBits,
                         ::testing::Range<std::size_t>(0, kSubjects.size()),
                         [](const auto& one) {
                             std::string name(kSubjects[one.param]);
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

}  // namespace
}  // namespace zoned::testing_web
