// CPU time of the calling thread: what other processes do to the machine does not count.
#pragma once

#include <cstdint>

namespace zoned::bench {

/// Nanoseconds of CPU time that the calling thread has used (CLOCK_THREAD_CPUTIME_ID).
std::int64_t thread_cpu_ns();

/// What one reading of the clock adds to an interval between two readings, nanoseconds. Measured
/// once.
double clock_cost_ns();

}  // namespace zoned::bench
