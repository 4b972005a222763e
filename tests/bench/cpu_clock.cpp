#include "tests/bench/cpu_clock.h"

#include "tests/bench/statistics.h"

#include <ctime>
#include <vector>

namespace zoned::bench {

namespace {

std::int64_t read(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

std::int64_t thread_cpu_ns() {
    return read(CLOCK_THREAD_CPUTIME_ID);
}

std::int64_t wall_ns() {
    return read(CLOCK_MONOTONIC);
}

double clock_cost_ns() {
    static const double cost = [] {
        std::vector<double> intervals;
        for (int i = 0; i < 2001; ++i) {
            const std::int64_t before = thread_cpu_ns();
            intervals.push_back(static_cast<double>(thread_cpu_ns() - before));
        }
        return median(intervals);
    }();
    return cost;
}

}  // namespace zoned::bench
