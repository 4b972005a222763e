#include "server/app/calibration/measure_crossover.h"

#include "server/compute/device.h"
#include "server/compute/stages/particle_stage.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>

namespace zoned::app {

namespace {

constexpr std::size_t kFew = 4096;
constexpr std::size_t kMany = 262'144;
constexpr int kWarmUps = 2;
constexpr std::size_t kTimed = 5;

template <class Work>
double median_us(const Work& work) {
    for (int i = 0; i < kWarmUps; ++i) {
        work();
    }
    std::array<double, kTimed> times{};
    for (double& time : times) {
        const auto before = std::chrono::steady_clock::now();
        work();
        const std::chrono::duration<double, std::micro> spent =
            std::chrono::steady_clock::now() - before;
        time = spent.count();
    }
    std::sort(times.begin(), times.end());
    return times[kTimed / 2];
}

}  // namespace

compute::ParticleScene common_scene() {
    compute::ParticleScene scene;
    scene.world.h = 1.0F / 60.0F;
    scene.world.gy = -9.81F;
    scene.world.linear_drag = 0.1F;
    scene.world.wind_x = 1.0F;
    scene.world.planes = 1;
    scene.world.plane[0] = {0.0F, 1.0F, 0.0F, 0.0F};
    return scene;
}

MeasuredCrossover measure_particles(compute::Device& device,
                                    compute::Team& team,
                                    const compute::ParticleScene& scene) {
    MeasuredCrossover measured;
    compute::ParticleColumns columns;
    columns.reserve(kMany);
    compute::ParticleStage stage(&device);
    const auto on_device = [&](std::size_t count) {
        return median_us([&] {
            compute::StageRun run = stage.step(columns, count, scene, team);
            if (!run.fault.empty()) {
                measured.fault = std::move(run.fault);
            }
        });
    };
    const auto on_cpu = [&](std::size_t count) {
        return median_us([&] {
            const compute::Team::Shift shift(team);
            compute::step_particles(columns, count, scene, team);
        });
    };
    const double few_device = on_device(kFew);
    const double many_device = on_device(kMany);
    if (!measured.fault.empty()) {
        return measured;
    }
    const double few_cpu = on_cpu(kFew);
    const double many_cpu = on_cpu(kMany);
    measured.crossover =
        compute::Crossover(compute::cost_through(kFew, few_cpu, kMany, many_cpu),
                           compute::cost_through(kFew, few_device, kMany, many_device));
    return measured;
}

}  // namespace zoned::app
