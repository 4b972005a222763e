// Measured crossovers: from how many items on a device is faster, found out on this machine.
#pragma once

#include "server/compute/crossover.h"
#include "server/compute/team.h"

#include <string>

namespace zoned::compute {
class Device;
}

namespace zoned::app {

struct MeasuredCrossover {
    compute::Crossover crossover;  ///< not measured where the device failed
    std::string fault;             ///< why; empty: it did not
};

/// Steps a few thousand and a few hundred thousand particles on both sides, five times each after
/// the kernel is built and both are warm; the median counts. Takes some 20 ms and, where the
/// program is in no cache, the time of a build. For the first need of a device, not for every
/// start. The choice is recorded by whoever makes it.
MeasuredCrossover measure_particles(compute::Device& device, compute::Team& team);

}  // namespace zoned::app
