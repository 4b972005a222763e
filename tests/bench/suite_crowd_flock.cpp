#include "server/app/calibration/measure_crossover.h"
#include "server/compute/device.h"
#include "server/compute/worker_pool.h"
#include "server/physics/particles/particle_systems.h"
#include "tests/bench/comparison.h"
#include "tests/bench/suite_crowd.h"

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

constexpr float kH = 1.0F / 60.0F;
constexpr int kEmittersAlongASide = 10;

/// Animals of a particle system as a config makes it, along a path through their box. About five
/// are in a cell, so that each tests some 45.
class FlockSystem {
  public:
    explicit FlockSystem(std::size_t count) {
        physics::ParticleSystemDef def;
        def.most = count;
        physics::FlockDef& flock = def.flock.emplace();
        flock.radius = 3.0F;
        flock.separation_radius = 1.0F;
        flock.most_speed = 6.0F;
        flock.least_speed = 1.0F;
        const double side = 3.0 * std::sqrt(static_cast<double>(count) / 5.0);
        flock.high = Vec3d(side, 6.0, side);
        flock.path = {{0.1 * side, 0.1 * side},
                      {0.9 * side, 0.3 * side},
                      {0.2 * side, 0.6 * side},
                      {0.9 * side, 0.9 * side}};
        system_ = *systems_.add(std::move(def));
        for (int i = 0; i < kEmittersAlongASide * kEmittersAlongASide; ++i) {
            add_emitter(i, side / kEmittersAlongASide, count);
        }
    }

    void use_device(compute::Device* device, const compute::Crossover& of_flocks) {
        systems_.use_device(device, {}, of_flocks);
    }

    void step(compute::Team& team) {
        const physics::ParticleReport report = systems_.step(now_++, kH, team);
        if (!report.fault.empty()) {
            throw std::runtime_error(report.fault);
        }
    }

    [[nodiscard]] const compute::ParticleColumns& columns() const {
        return systems_.find(system_)->columns();
    }

  private:
    void add_emitter(int i, double apart, std::size_t count) {
        motion::Emitter emitter;
        emitter.seed = static_cast<std::uint64_t>(i);
        emitter.rate_hz = 1e9;
        emitter.most = count / (kEmittersAlongASide * kEmittersAlongASide);
        emitter.position = Vec3d((i % kEmittersAlongASide + 0.5) * apart,
                                 3.0,
                                 (i / kEmittersAlongASide + 0.5) * apart)
                               .cast<float>();
        emitter.spread = static_cast<float>(apart / 2.0);
        emitter.cone_cosine = -1.0F;
        emitter.speed_min = 1.0F;
        emitter.speed_max = 3.0F;
        emitter.lifetime_min_s = emitter.lifetime_max_s = 3600.0F;
        if (!systems_.add_emitter(system_, emitter).ok()) {
            throw std::logic_error("an emitter of the flock is unfit");
        }
    }

    physics::ParticleSystems systems_;
    physics::ParticleSystemId system_;
    Tick now_ = 0;
};

class SteeredFlockTrial final : public JudgedTrial {
  public:
    SteeredFlockTrial(std::size_t count,
                      int threads,
                      compute::Device* device,
                      const compute::Crossover& of_flocks)
        : count_(count),
          flock_(count),
          reference_(count) {
        if (threads > 1) {
            pool_ = std::make_unique<compute::WorkerPool>(threads);
            team_.join_pool(*pool_);
        }
        flock_.use_device(device, of_flocks);
    }

    void frame() override { flock_.step(team_); }

    /// The number of values that differ from those of one thread without a device.
    void observe() override {
        compute::Team alone;
        reference_.step(alone);
        for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
            for (std::size_t i = 0; i < count_; ++i) {
                different_ += std::memcmp(flock_.columns().column(c) + i,
                                          reference_.columns().column(c) + i,
                                          sizeof(float)) != 0
                                  ? 1.0
                                  : 0.0;
            }
        }
    }

    void judge(Row& row) override {
        row.error = different_;
        row.error_unit = "different numbers";
        row.metric("agents", static_cast<double>(count_));
    }

  private:
    std::size_t count_;
    std::unique_ptr<compute::WorkerPool> pool_;
    compute::Team team_;
    FlockSystem flock_;
    FlockSystem reference_;
    double different_ = 0.0;
};

/// Measured as a server measures it at its start.
compute::Crossover measured_crossover(compute::Device& device) {
    compute::WorkerPool pool(2);
    compute::Team team;
    team.join_pool(pool);
    return app::measure_flock(device, team, physics::FlockDef{}).crossover;
}

}  // namespace

void run_crowd_flock(Session& session) {
    const std::size_t count = session.quick ? 5'000 : 50'000;
    session.progress("crowd flock_50k");
    session.note(
        "crowd flock_50k: 50,000 animals of a particle system, 45 neighbours tested each, that "
        "follow a path; wall_ms is what counts on two cores; `chosen` goes where the measured "
        "crossover sends it; the error is the number of numbers that differ from one thread's");
    auto device = compute::Device::open({});
    const auto with = [count](const char* name,
                              int threads,
                              compute::Device* on,
                              const compute::Crossover& of_flocks) {
        return Method{name, "", [=] {
                          return std::make_unique<SteeredFlockTrial>(count, threads, on, of_flocks);
                      }};
    };
    std::vector<Method> methods{with("default", 2, nullptr, {}), with("cpu_1", 1, nullptr, {})};
    if (device) {
        const compute::Crossover always({1e9, 1.0, 0.0}, {});
        methods.push_back(with("opencl", 1, device->get(), always));
        methods.push_back(with("chosen", 2, device->get(), measured_crossover(**device)));
    } else {
        session.note("crowd: " + device.error());
    }
    methods = wanted(session, std::move(methods));
    const Plan plan{5, session.quick ? 3 : 30, session.quick ? 1 : session.repeats};
    std::vector<Row> rows = compare("crowd", kFlockScene, "", methods, plan);
    for (Row& row : rows) {
        row.metric("wall_ms", 1e-3 * *row.find_metric("wall_us_p50"));
    }
    session.add(std::move(rows));
}

}  // namespace zoned::bench
