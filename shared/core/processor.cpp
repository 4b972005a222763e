// Built for plain x86-64 whatever the rest is built for (see CMakeLists.txt): it must run
// everywhere to say that the rest cannot.
#include "shared/core/processor.h"

#if defined(__x86_64__)
#include <cpuid.h>
#include <unistd.h>

#include <cstring>
#endif

namespace zoned::core {

#if defined(__x86_64__)
namespace {

constexpr char kTargetName[] = ZONED_TARGET_NAME;

/// x86-64-v3 as the System V psABI defines it (section 3.1.1, "Processor architecture").
bool has_v3() {
    unsigned a = 0;
    unsigned b = 0;
    unsigned c = 0;
    unsigned d = 0;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0) {
        return false;
    }
    constexpr unsigned kLeaf1 = (1u << 12) | (1u << 22) | (1u << 27) | (1u << 28) | (1u << 29);
    if ((c & kLeaf1) != kLeaf1) {  // FMA, MOVBE, OSXSAVE, AVX, F16C
        return false;
    }
    unsigned xcr0_low = 0;
    unsigned xcr0_high = 0;
    __asm__("xgetbv" : "=a"(xcr0_low), "=d"(xcr0_high) : "c"(0));
    if ((xcr0_low & 6u) != 6u) {  // the system saves SSE and AVX state
        return false;
    }
    constexpr unsigned kLeaf7 = (1u << 3) | (1u << 5) | (1u << 8);
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0 ||
        (b & kLeaf7) != kLeaf7) {  // BMI1, AVX2, BMI2
        return false;
    }
    return __get_cpuid(0x80000001u, &a, &b, &c, &d) != 0 && (c & (1u << 5)) != 0;  // LZCNT
}

// Before main and before static objects of other files, which may already use the newer
// instructions.
__attribute__((constructor(101))) void check_processor() {
    if (std::strcmp(kTargetName, "v3") == 0 && !has_v3()) {
        static constexpr char kText[] =
            "zoned: this program was built for x86-64-v3 (AVX2, FMA, BMI2), which this processor "
            "lacks; "
            "build it with -DZONED_TARGET=baseline\n";
        const auto written = write(STDERR_FILENO, kText, sizeof(kText) - 1);
        _exit(written < 0 ? 4 : 3);
    }
}

}  // namespace
#endif

void require_processor() {
    // The work was done by check_processor(); calling this links it in.
}

}  // namespace zoned::core
