// ParticleDevice: the OpenCL device that may move large particle systems, opened on first need.
#pragma once

#include "server/compute/crossover.h"
#include "server/compute/device.h"
#include "server/ops/settings.h"

#include <memory>
#include <string>

namespace zoned::app {

/// A zone whose simulated systems hold fewer particles together is faster on the CPU wherever it
/// was measured, so that no device is looked for.
inline constexpr std::size_t kDeviceParticles = 16'384;

struct ParticleDevice {
    std::unique_ptr<compute::Device> device;  ///< null: the CPU does it all
    compute::Crossover crossover;
    bool needed = false;  ///< the world has work for one; if not, OpenCL was not even loaded
    std::string text;     ///< one line: what was chosen, and why
};

/// Looks for a device as the config asks, where the world has work for one, opens it and measures
/// from how many particles on it is faster than `threads` threads. The results are the same bits on
/// either side, so that the choice needs no recording: a replay may make another one.
ParticleDevice open_particle_device(const ops::Settings& settings, unsigned threads);

}  // namespace zoned::app
