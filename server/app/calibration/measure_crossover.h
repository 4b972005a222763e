// Measured crossovers: finds on this machine the number of items from which a device is faster.
#pragma once

#include "server/compute/crossover.h"
#include "server/compute/stages/particle_stage.h"
#include "server/compute/team.h"
#include "server/physics/particles/particle_flock.h"

#include <string>

namespace zoned::compute {
class Device;
}

namespace zoned::app {

struct MeasuredCrossover {
    compute::Crossover crossover;  ///< not measured where the device failed
    std::string fault;             ///< why; empty: it did not
};

/// The usual particle system: drag in a steady wind, and a floor.
compute::ParticleScene common_scene();

/// Steps a few thousand and a few hundred thousand particles on both sides, five times each after
/// the kernel is built and both are warm; the median counts. Takes some 20 ms in the common scene,
/// and a second among 16 balls on a slow device. Where the program is in no cache, it also takes
/// the time of a build. For the first need of a device, not for every start.
MeasuredCrossover measure_particles(compute::Device& device,
                                    compute::Team& team,
                                    const compute::ParticleScene& scene = common_scene());

/// The same for the animals of a flock, spread over ground where some five are in a cell.
MeasuredCrossover measure_flock(compute::Device& device,
                                compute::Team& team,
                                const physics::FlockDef& flock);

}  // namespace zoned::app
