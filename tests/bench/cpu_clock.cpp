#include "tests/bench/cpu_clock.h"

#include "tests/bench/statistics.h"

#include <ctime>
#include <vector>

namespace zoned::bench {

std::int64_t thread_cpu_ns() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
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
