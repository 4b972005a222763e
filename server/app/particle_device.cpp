#include "server/app/particle_device.h"

#include "server/app/measure_crossover.h"
#include "server/compute/worker_pool.h"
#include "server/ops/particles.h"

#include <cstdint>
#include <cstdio>
#include <utility>

namespace zoned::app {

namespace {

std::string describe_crossover(const compute::Crossover& crossover) {
    char text[300];
    const std::size_t from = crossover.threshold();
    const std::string side =
        from == SIZE_MAX ? "the CPU is faster for any number of particles"
                         : "the device is faster from " + std::to_string(from) + " particles on";
    std::snprintf(text,
                  sizeof(text),
                  "%s (CPU %.1f us + %.2f ns a particle, device %.1f us + %.2f ns)",
                  side.c_str(),
                  crossover.cpu().launch_us,
                  1e3 * (crossover.cpu().item_us + crossover.cpu().copy_us),
                  crossover.device().launch_us,
                  1e3 * (crossover.device().item_us + crossover.device().copy_us));
    return text;
}

}  // namespace

ParticleDevice open_particle_device(const ops::Settings& settings, unsigned threads) {
    ParticleDevice out;
    const proto::Config::Compute& wish = settings.config.compute();
    const std::size_t most = ops::most_particles(settings);
    if (settings.particles.empty()) {
        out.text = "particles: none is simulated, no device is looked for";
        return out;
    }
    if (wish.device() == "none" || most < kDeviceParticles) {
        out.text = wish.device() == "none"
                       ? "particles: on the CPU, as compute.device says"
                       : "particles: on the CPU, at most " + std::to_string(most) +
                             " in a zone are too few for a device to pay";
        return out;
    }
    out.needed = true;
    compute::DeviceSettings open;
    open.wish = wish.device();
    open.cache_folder = wish.cache_folder();
    auto device = compute::Device::open(open);
    if (!device.ok()) {
        out.text = "particles: on the CPU, " + device.error();
        return out;
    }
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    MeasuredCrossover measured = measure_particles(**device, team);
    if (!measured.fault.empty()) {
        out.text = "particles: on the CPU, the device failed: " + measured.fault;
        return out;
    }
    out.device = std::move(*device);
    out.crossover = measured.crossover;
    out.text = "particles: device " + compute::to_text(out.device->info()) + ", " +
               out.device->reason() + "; " + describe_crossover(out.crossover);
    return out;
}

}  // namespace zoned::app
