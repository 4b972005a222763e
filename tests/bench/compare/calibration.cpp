#include "tests/bench/compare/calibration.h"

#include "tests/bench/cpu_clock.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace zoned::bench {

namespace {

constexpr std::size_t kPlaces = 32'768;  // of 8 bytes
constexpr int kTries = 5;

/// One cycle through all places (Sattolo's algorithm), so that each read waits for the one before.
std::vector<std::uint64_t> random_cycle() {
    std::vector<std::uint64_t> next(kPlaces);
    std::iota(next.begin(), next.end(), std::uint64_t{0});
    std::uint64_t state = 88172645463325252ULL;
    for (std::size_t i = kPlaces - 1; i > 0; --i) {
        state ^= state << 13U;  // xorshift64, Marsaglia 2003
        state ^= state >> 7U;
        state ^= state << 17U;
        std::swap(next[i], next[state % i]);
    }
    return next;
}

/// A number that depends on all of the work, so that none of it is left out.
double work(const std::vector<std::uint64_t>& next) {
    std::uint64_t at = 0;
    double sum = 1.0;
    for (std::size_t i = 0; i < 2 * kPlaces; ++i) {
        at = next[at];
        sum = sum * 0.999 + static_cast<double>(at & 1U);
    }
    for (int i = 0; i < 100'000; ++i) {
        sum = sum * 0.9999 + 1e-3;
    }
    return sum;
}

}  // namespace

double calibration_us() {
    static const std::vector<std::uint64_t> next = random_cycle();
    double kept = 0.0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kTries; ++i) {
        const std::int64_t begin = thread_cpu_ns();
        kept += work(next);
        least = std::min(least, static_cast<double>(thread_cpu_ns() - begin) * 1e-3);
    }
    // The work can't be left out: its result decides on a branch that is never taken.
    return std::isfinite(kept) ? least : 0.0;
}

}  // namespace zoned::bench
