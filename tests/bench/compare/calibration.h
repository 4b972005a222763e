// Calibration: a fixed piece of work whose time tells how fast the machine is at the moment.
#pragma once

namespace zoned::bench {

/// CPU time of a fixed kernel in microseconds, the least of several tries: dependent additions and
/// multiplications, and walks over 256 KiB in a fixed random order, about half of the time each.
/// It must never change: files hold ratios to it.
double calibration_us();

}  // namespace zoned::bench
