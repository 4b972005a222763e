// Suite `particles`: a million and 16,000 particles, on one thread, on two, on an OpenCL device and
// where the measured crossover sends them, beside a bare loop over the same columns.
#include "server/app/calibration/measure_crossover.h"
#include "server/compute/device.h"
#include "server/compute/worker_pool.h"
#include "server/physics/particles/particle_systems.h"
#include "tests/bench/comparison.h"
#include "tests/bench/plain_particles.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

constexpr float kFallG = 9.81F;

/// Opened once for the run: the pool's second thread and the device are as a server has them.
struct Machine {
    compute::WorkerPool pool{2};
    std::unique_ptr<compute::Device> device;
    std::string no_device;  ///< why there is none
    compute::Crossover crossover;

    Machine() {
        auto opened = compute::Device::open({});
        if (!opened) {
            no_device = opened.error();
            return;
        }
        device = std::move(*opened);
        compute::Team team;
        team.join_pool(pool);
        crossover = app::measure_particles(*device, team).crossover;
    }
};

Machine& machine() {
    static Machine the;
    return the;
}

/// All particles are born in the first step and outlive the run.
motion::Emitter burst(int count) {
    motion::Emitter emitter;
    emitter.seed = 8;
    emitter.rate_hz = 1e9;
    emitter.most = static_cast<std::uint64_t>(count);
    emitter.position = Vec3(0.0F, 1000.0F, 0.0F);
    emitter.spread = 50.0F;
    emitter.cone_cosine = -1.0F;
    emitter.speed_min = 1.0F;
    emitter.speed_max = 20.0F;
    emitter.lifetime_min_s = 3000.0F;
    emitter.lifetime_max_s = 4000.0F;
    return emitter;
}

enum class Where : std::uint8_t {
    kOneThread,
    kTwoThreads,
    kDevice,
    kChosen
};

/// Of the sample's particles: the largest distance from the exact parabola. Semi-implicit Euler is
/// g h t / 2 away from it by theory.
double distance_from_parabola(const compute::ParticleColumns& columns, int count, int frames) {
    const motion::Emitter emitter = burst(count);
    const double t = static_cast<double>(frames) * static_cast<double>(kStepTime);
    double worst = 0.0;
    for (int i = 0; i < count; i += std::max(1, count / 1000)) {
        const auto at = static_cast<std::size_t>(i);
        const motion::Birth birth = motion::birth_of(emitter, at);
        const Vec3d exact = birth.position.cast<double>() + t * birth.velocity.cast<double>() +
                            0.5 * t * t * Vec3d(0.0, -static_cast<double>(kFallG), 0.0);
        const Vec3d is(columns.column(0)[at], columns.column(1)[at], columns.column(2)[at]);
        worst = std::max(worst, (is - exact).norm());
    }
    return worst;
}

/// ParticleSystems as a zone has them: births, deaths and the choice of the side are in the time.
class SystemTrial : public JudgedTrial {
  public:
    SystemTrial(Where where, int count) : count_(count) {
        if (where == Where::kTwoThreads || where == Where::kChosen) {
            team_.join_pool(machine().pool);
        }
        if (where == Where::kDevice) {
            // A CPU that takes for ever: the device it is.
            systems_.use_device(machine().device.get(), {{1e9, 1.0, 0.0}, {}});
        } else if (where == Where::kChosen) {
            systems_.use_device(machine().device.get(), machine().crossover);
        }
        physics::ParticleSystemDef def;
        def.gravity = Vec3(0.0F, -kFallG, 0.0F);
        id_ = *systems_.add(def);
        if (!systems_.add_emitter(id_, burst(count))) {
            throw std::runtime_error("the burst was refused");
        }
    }

    void frame() override {
        const physics::ParticleReport report = systems_.step(frames_++, kStepTime, team_);
        on_device_ += report.on_device;
        if (!report.fault.empty()) {
            throw std::runtime_error(report.fault);
        }
    }

    void judge(Row& row) override {
        row.error = distance_from_parabola(systems_.find(id_)->columns(), count_, frames_);
        row.error_unit = "m";
        row.metric("on_device_share", static_cast<double>(on_device_) / frames_);
        core::StateHash hash;
        systems_.hash(hash);
        char text[24];
        std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
        row.state_hash = text;
    }

  private:
    int count_;
    compute::Team team_;
    physics::ParticleSystems systems_;
    physics::ParticleSystemId id_;
    int frames_ = 0;
    unsigned on_device_ = 0;
};

class PlainTrial : public JudgedTrial {
  public:
    explicit PlainTrial(int count) : count_(count) {
        columns_.reserve(static_cast<std::size_t>(count));
        const motion::Emitter emitter = burst(count);
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
            const motion::Birth birth = motion::birth_of(emitter, i);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                columns_.column(axis)[i] = birth.position[static_cast<Eigen::Index>(axis)];
                columns_.column(axis + 3)[i] = birth.velocity[static_cast<Eigen::Index>(axis)];
            }
        }
    }

    void frame() override {
        plain_particle_loop(static_cast<std::size_t>(count_),
                            kStepTime,
                            0.0F,
                            -kFallG,
                            0.0F,
                            columns_.column(0),
                            columns_.column(1),
                            columns_.column(2),
                            columns_.column(3),
                            columns_.column(4),
                            columns_.column(5));
        ++frames_;
    }

    void judge(Row& row) override {
        row.error = distance_from_parabola(columns_, count_, frames_);
        row.error_unit = "m";
    }

  private:
    int count_;
    compute::ParticleColumns columns_;
    int frames_ = 0;
};

double wall_of(const std::vector<Row>& rows, const std::string& method) {
    for (const Row& row : rows) {
        if ((row.peer.empty() ? row.method : row.peer) == method &&
            row.find_metric("wall_us_p50") != nullptr) {
            return *row.find_metric("wall_us_p50");
        }
    }
    return NAN;
}

/// Ratios of wall-clock times: a second thread and a device shorten nothing else.
void add_particle_ratios(std::vector<Row>& rows, int count) {
    const double plain = wall_of(rows, "plain_loop");
    const double two = wall_of(rows, "cpu_2");
    const double best = std::fmin(std::fmin(wall_of(rows, "cpu_1"), two), wall_of(rows, "opencl"));
    for (Row& row : rows) {
        const double wall = *row.find_metric("wall_us_p50");
        row.metric("wall_ns_per_particle", 1e3 * wall / count);
        row.metric("wall_plain_ratio", wall / plain);
        row.metric("wall_cpu_2_ratio", wall / two);
        row.metric("wall_best_ratio", wall / best);
    }
}

void run_particle_scene(Session& session, const std::string& scene, int count, int frames) {
    session.progress("particles " + scene);
    const auto ours = [count](const char* name, Where where) {
        return Method{name, "", [=] {
                          return std::make_unique<SystemTrial>(where, count);
                      }};
    };
    std::vector<Method> methods{ours("default", Where::kChosen),
                                ours("cpu_1", Where::kOneThread),
                                ours("cpu_2", Where::kTwoThreads)};
    if (machine().device) {
        methods.push_back(ours("opencl", Where::kDevice));
    } else {
        session.note("particles: no opencl rows: " + machine().no_device);
    }
    methods.push_back({"default", "plain_loop", [count] {
                           return std::make_unique<PlainTrial>(count);
                       }});
    const Plan plan{session.quick ? 2 : 12, frames, session.quick ? 1 : session.repeats};
    std::vector<Row> rows =
        compare("particles", scene, "", wanted(session, std::move(methods)), plan);
    add_particle_ratios(rows, count);
    session.add(std::move(rows));
}

void run_particles(Session& session) {
    session.note(
        "particles: time_us is CPU time of the calling thread; wall_* are times on the wall, which "
        "count where a second thread or a device works");
    if (machine().device) {
        session.note("particles: device " + machine().device->reason());
    }
    if (session.wants_scene("particles_1m")) {
        run_particle_scene(session, "particles_1m", 1'000'000, session.quick ? 8 : 240);
    }
    if (session.wants_scene("particles_16k")) {
        run_particle_scene(session, "particles_16k", 16'000, session.quick ? 100 : 2400);
    }
}

const Registration kParticles({"particles",
                               "particles on lanes, threads and a device beside a bare loop",
                               {"particles_1m", "particles_16k"},
                               {"default", "cpu_1", "cpu_2", "opencl", "plain_loop/default"},
                               run_particles});

}  // namespace

}  // namespace zoned::bench
