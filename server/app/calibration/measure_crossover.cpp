#include "server/app/calibration/measure_crossover.h"

#include "server/compute/device.h"
#include "server/compute/stages/flock_stage.h"
#include "server/compute/stages/particle_stage.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <utility>

namespace zoned::app {

namespace {

constexpr std::size_t kFew = 4096;
constexpr std::size_t kMany = 262'144;
constexpr std::size_t kFewAnimals = 1024;
constexpr std::size_t kManyAnimals = 32'768;
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

namespace {

/// Animals at random in the box of the flock, standing.
void spread(compute::ParticleColumns& columns, std::size_t count, const physics::FlockDef& flock) {
    core::Rng rng(1);
    const Vec3 high = flock.high.cast<float>();
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            columns.column(axis)[i] = rng.range(0.0F, high[static_cast<Eigen::Index>(axis)]);
            columns.column(3 + axis)[i] = 0.0F;
        }
    }
}

template <class OnDevice, class OnCpu>
compute::Crossover crossover_of(const OnDevice& on_device,
                                const OnCpu& on_cpu,
                                std::size_t few,
                                std::size_t many,
                                const MeasuredCrossover& measured) {
    const double few_device = on_device(few);
    const double many_device = on_device(many);
    if (!measured.fault.empty()) {
        return {};
    }
    const double few_cpu = on_cpu(few);
    const double many_cpu = on_cpu(many);
    return {compute::cost_through(few, few_cpu, many, many_cpu),
            compute::cost_through(few, few_device, many, many_device)};
}

}  // namespace

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
    measured.crossover = crossover_of(on_device, on_cpu, kFew, kMany, measured);
    return measured;
}

MeasuredCrossover measure_flock(compute::Device& device,
                                compute::Team& team,
                                const physics::FlockDef& flock) {
    MeasuredCrossover measured;
    compute::ParticleColumns columns;
    columns.reserve(kManyAnimals);
    compute::FlockStage on_both(&device);
    compute::FlockStage on_lanes;
    const auto timed = [&](compute::FlockStage& stage, std::size_t count) {
        physics::FlockDef ground = flock;
        ground.path.clear();
        const double side =
            static_cast<double>(flock.radius) * std::sqrt(static_cast<double>(count) / 5.0);
        ground.low = Vec3d::Zero();
        ground.high = Vec3d(side, static_cast<double>(flock.radius), side);
        kernels::FlockRules rules = physics::flock_rules_of(ground);
        rules.h = 1.0F / 60.0F;
        spread(columns, count, ground);
        return median_us([&] {
            const compute::Team::Shift shift(team);
            compute::StageRun run = stage.step(columns, count, rules, team);
            if (!run.fault.empty()) {
                measured.fault = std::move(run.fault);
            }
        });
    };
    measured.crossover = crossover_of([&](std::size_t n) { return timed(on_both, n); },
                                      [&](std::size_t n) { return timed(on_lanes, n); },
                                      kFewAnimals,
                                      kManyAnimals,
                                      measured);
    return measured;
}

}  // namespace zoned::app
