// ParticleDevice: the OpenCL device that may move large particle systems, opened on first need.
#pragma once

#include "server/compute/crossover.h"
#include "server/compute/device.h"
#include "server/config/settings.h"

#include <memory>
#include <string>

namespace zoned::app {

/// A device can save no more of a tick than the CPU's step takes. Loading OpenCL, opening a device,
/// building kernels and measuring took a server's start 1.3 to 1.5 s and 80 MB (PoCL, two cores,
/// nothing cached). Where the step takes a hundredth of the tick, that is paid back in some minutes
/// at the earliest. Where all systems of a zone, as full as they may be, take less, no device is
/// looked for.
inline constexpr double kDeviceShare = 0.01;

/// Time that one thread of the CPU needs for a tick of a particle, by
/// physics::method_selection::ParticleCost, ns; other machines differ.
double particle_ns(const zone::ParticleSource& source, bool heightfield);

/// The same for all systems of a zone at their `most`, us a tick.
double particle_step_us(const config::Settings& settings);

struct ParticleDevice {
    std::unique_ptr<compute::Device> device;  ///< null: the CPU does it all
    compute::Crossover crossover;             ///< of particles that fall
    compute::Crossover of_flocks;
    bool needed = false;  ///< the world has work for one; if not, OpenCL was not even loaded
    bool failed = false;  ///< one that the config names is not there, or one that opened is no good
    std::string text;     ///< one line: the choice and its reason
    std::string
        no_cache;  ///< one line: why built kernels are not kept; empty: they are, or need not
};

/// Looks for a device as the config asks, where the world has work for one, and opens it. Measures
/// from how many particles on it is faster than `threads` threads: in the air and among the balls
/// of the falling system that costs most, and by the rules of the largest flock. The results are
/// the same bits on either side, so that the choice needs no recording: a replay may make another
/// one. `with` adds options beside the config, for tests: buffers, other kernels and faults.
ParticleDevice open_particle_device(const config::Settings& settings,
                                    unsigned threads,
                                    compute::DeviceSettings with = {});

/// Logs the choice where the world `has_particles`, and whatever is unusual about the device.
void log_device(const ParticleDevice& device, bool has_particles);

}  // namespace zoned::app
