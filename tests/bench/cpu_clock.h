// Clocks: CPU time of the calling thread, which other processes do not add to, and wall-clock time.
#pragma once

#include <cstdint>

namespace zoned::bench {

/// Nanoseconds of CPU time that the calling thread has used (CLOCK_THREAD_CPUTIME_ID).
std::int64_t thread_cpu_ns();

/// Wall-clock nanoseconds since some fixed moment (CLOCK_MONOTONIC).
std::int64_t wall_ns();

/// The time that one clock reading adds to an interval between two readings, nanoseconds. Measured
/// once.
double clock_cost_ns();

}  // namespace zoned::bench
