#include "server/app/calibration/particle_device.h"

#include "server/app/calibration/measure_crossover.h"
#include "server/app/log/log.h"
#include "server/compute/stages/particle_stage.h"
#include "server/compute/worker_pool.h"
#include "server/config/world/particle_config.h"
#include "server/physics/method_selection/cost_table.h"
#include "server/physics/particles/particle_system.h"
#include "server/physics/particles/wind.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

namespace zoned::app {

namespace {

bool has_drag(const physics::ParticleSystemDef& def) {
    return def.linear_drag > 0.0F || def.quadratic_drag > 0.0F;
}

std::string describe_crossover(const compute::Crossover& crossover, const std::string& items) {
    if (!crossover.measured()) {
        return {};
    }
    char text[300];
    const std::size_t from = crossover.threshold();
    const std::string side = from == SIZE_MAX ? "the CPU is faster for any number of " + items
                                              : "the device is faster from " +
                                                    std::to_string(from) + " " + items + " on";
    std::snprintf(text,
                  sizeof(text),
                  "; %s (CPU %.1f us + %.2f ns each, device %.1f us + %.2f ns)",
                  side.c_str(),
                  crossover.cpu().launch_us,
                  1e3 * (crossover.cpu().item_us + crossover.cpu().copy_us),
                  crossover.device().launch_us,
                  1e3 * (crossover.device().item_us + crossover.device().copy_us));
    return text;
}

/// Compilers and drivers say more than a log needs: the lines joined, cut where it becomes a page.
std::string one_line(std::string text) {
    constexpr std::size_t kMost = 400;
    std::replace(text.begin(), text.end(), '\n', ' ');
    if (text.size() > kMost) {
        text.resize(kMost);
        text += "...";
    }
    return text;
}

/// The surroundings of a system's particles, without a heightfield; balls stand where nobody is.
struct SystemSurroundings {
    SystemSurroundings(const config::Settings& settings, const zone::ParticleSource& source) {
        const physics::ParticleSystemDef& def = source.def;
        scene.world.h = static_cast<float>(1.0 / settings.tick_rate_hz / def.pieces);
        scene.world.gy = def.gravity.y();
        scene.world.linear_drag = def.linear_drag;
        scene.world.quadratic_drag = def.quadratic_drag;
        scene.world.gust_cells_per_m = 1.0F / def.wind.gust_size;
        scene.world.planes = 1;  // the ground
        scene.world.plane[0] = {0.0F, 1.0F, 0.0F, 0.0F};
        scene.world.spheres = static_cast<int>(source.characters_met);
        for (std::uint32_t ball = 0; ball < source.characters_met; ++ball) {
            scene.world.sphere[ball] = {0.0F, -1e6F, 0.0F, 1.0F};
        }
        if (has_drag(def)) {
            gusts = physics::gust_table(def.wind);
            scene.gusts = gusts;
        }
    }

    SystemSurroundings(const SystemSurroundings&) = delete;
    SystemSurroundings& operator=(const SystemSurroundings&) = delete;

    compute::ParticleScene scene;
    std::vector<float> gusts;
};

/// The kernels that the world's systems need, so that no tick waits for a compiler: a step of one
/// particle through each system's air. Why one failed; empty: none did.
std::string build_kernels(const config::Settings& settings,
                          compute::Device& device,
                          compute::Team& team) {
    compute::ParticleStage stage(&device);
    compute::ParticleColumns columns;
    columns.reserve(1);
    for (const zone::ParticleSource& source : settings.particles) {
        if (source.def.flock) {
            continue;  // all flocks share one kernel, which is measured
        }
        const SystemSurroundings around(settings, source);
        compute::StageRun run = stage.step(columns, 1, around.scene, team);
        if (!run.fault.empty()) {
            return run.fault;
        }
    }
    return {};
}

bool has_heightfield(const config::Settings& settings) {
    return std::any_of(settings.surfaces.begin(), settings.surfaces.end(), [](const auto& surface) {
        return surface.shape.kind == physics::ShapeKind::kHeightfield;
    });
}

/// The system whose particles cost most, among the flocks or among all others; null: there is none.
const zone::ParticleSource* dearest(const config::Settings& settings, bool flocks, bool field) {
    const zone::ParticleSource* found = nullptr;
    double most = 0.0;
    for (const zone::ParticleSource& source : settings.particles) {
        const double cost = static_cast<double>(source.def.most) * particle_ns(source, field);
        if (source.def.flock.has_value() == flocks && cost > most) {
            most = cost;
            found = &source;
        }
    }
    return found;
}

/// Fills the crossovers. Why a kernel failed; empty: none did.
std::string measure(const config::Settings& settings, compute::Team& team, ParticleDevice& out) {
    const bool field = has_heightfield(settings);
    if (const zone::ParticleSource* source = dearest(settings, false, field)) {
        MeasuredCrossover measured =
            measure_particles(*out.device, team, SystemSurroundings(settings, *source).scene);
        if (!measured.fault.empty()) {
            return measured.fault;
        }
        out.crossover = measured.crossover;
    }
    if (const zone::ParticleSource* source = dearest(settings, true, field)) {
        MeasuredCrossover measured = measure_flock(*out.device, team, *source->def.flock);
        if (!measured.fault.empty()) {
            return measured.fault;
        }
        out.of_flocks = measured.crossover;
    }
    return build_kernels(settings, *out.device, team);
}

/// "particles: on the CPU, ..." where there is nothing to look for; empty where there is.
std::string why_none(const config::Settings& settings) {
    if (settings.particles.empty()) {
        return "particles: none is simulated, no device is looked for";
    }
    if (settings.server.compute.device == "none") {
        return "particles: on the CPU, as compute.device says";
    }
    const double us = particle_step_us(settings);
    const double tick_us = 1e6 / settings.tick_rate_hz;
    if (us >= kDeviceShare * tick_us) {
        return {};
    }
    char text[200];
    std::snprintf(text,
                  sizeof(text),
                  "particles: on the CPU, at most %zu in a zone take it some %.0f us of a tick of "
                  "%.0f us: too little for a device to pay",
                  config::most_particles(settings),
                  us,
                  tick_us);
    return text;
}

}  // namespace

double particle_ns(const zone::ParticleSource& source, bool heightfield) {
    using Cost = physics::method_selection::ParticleCost;
    const double met =
        Cost::kBall_ns * source.characters_met + (heightfield ? Cost::kField_ns : 0.0);
    return physics::method_selection::particle_cost_ns(source.def, source.def.pieces) +
           met * source.def.pieces;
}

double particle_step_us(const config::Settings& settings) {
    const bool field = has_heightfield(settings);
    double us = 0.0;
    for (const zone::ParticleSource& source : settings.particles) {
        us += 1e-3 * particle_ns(source, field) * static_cast<double>(source.def.most);
    }
    return us;
}

ParticleDevice open_particle_device(const config::Settings& settings,
                                    unsigned threads,
                                    compute::DeviceSettings with) {
    ParticleDevice out;
    const config::ComputeSettings& wish = settings.server.compute;
    out.text = why_none(settings);
    if (!out.text.empty()) {
        return out;
    }
    out.needed = true;
    with.wish = wish.device;
    with.cache_folder = wish.cache_folder;
    auto device = compute::Device::open(with);
    const std::string asked = "particles: on the CPU, compute.device \"" + wish.device + "\": ";
    if (!device.ok()) {
        out.failed = wish.device != "auto";
        out.text = one_line(asked + device.error());
        return out;
    }
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    out.device = std::move(*device);
    const std::string fault = measure(settings, team, out);
    if (!fault.empty()) {
        out.failed = true;
        out.text = one_line(asked + out.device->info().name + " failed: " + fault);
        out.device.reset();
        return out;
    }
    out.text = "particles: device " + compute::to_text(out.device->info()) + ", " +
               out.device->reason() + describe_crossover(out.crossover, "particles") +
               describe_crossover(out.of_flocks, "animals of a flock");
    const compute::ProgramCounts programs = out.device->programs();
    if (!with.cache_folder.empty() && programs.stored < programs.built) {
        out.no_cache = "compute.cache_folder \"" + with.cache_folder +
                       "\": cannot be written, kernels are built anew at every start";
    }
    return out;
}

void log_device(const ParticleDevice& device, bool has_particles) {
    if (has_particles) {
        log_of(LogArea::kServer)
            .log(device.failed ? spdlog::level::warn : spdlog::level::info, "{}", device.text);
    }
    if (!device.no_cache.empty()) {
        log_of(LogArea::kServer).warn("{}", device.no_cache);
    }
}

}  // namespace zoned::app
