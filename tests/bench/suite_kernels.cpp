// Suite `kernels`: flocking agents on lanes, threads and a device beside a plain loop; on a device
// also the costs of copies, work groups, table memory and tiles in local memory.
#include "server/compute/device.h"
#include "server/compute/stages/flock_stage.h"
#include "server/compute/worker_pool.h"
#include "tests/bench/comparison.h"
#include "tests/bench/plain_flock.h"
#include "tests/scenario/flock.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

/// Devices at their default, and one whose buffers are copied to and fro.
struct Bench {
    compute::WorkerPool pool{2};
    std::unique_ptr<compute::Device> device;
    std::unique_ptr<compute::Device> copying;
    std::string no_device;

    Bench() {
        auto opened = compute::Device::open({});
        if (!opened) {
            no_device = opened.error();
            return;
        }
        device = std::move(*opened);
        compute::DeviceSettings settings;
        settings.buffers = compute::BufferMode::kCopied;
        auto second = compute::Device::open(settings);
        if (second) {
            copying = std::move(*second);
        }
    }
};

Bench& bench() {
    static Bench the;
    return the;
}

class FlockTrial : public JudgedTrial {
  public:
    FlockTrial(std::size_t count,
               int threads,
               compute::Device* device,
               compute::FlockKernelOptions options = {})
        : count_(count),
          rules_(scenario::flock_rules(count)),
          stage_(device, options) {
        if (threads > 1) {
            team_.join_pool(bench().pool);
        }
        agents_.reserve(count);
        scenario::scatter_flock(count, rules_, [this](std::size_t i, auto... values) {
            std::size_t c = 0;
            ((agents_.column(c++)[i] = values), ...);
        });
    }

    void frame() override {
        const compute::Team::Shift shift(team_);
        const compute::StageRun run = stage_.step(agents_, count_, rules_, team_);
        if (!run.fault.empty()) {
            throw std::runtime_error(run.fault);
        }
        ++frames_;
    }

    /// The distance of the first step's velocities from the plain loop's: rounding in another
    /// order.
    void observe() override {
        if (frames_ != 1) {
            return;
        }
        PlainFlock plain;
        plain.rules = rules_;
        plain.agents.resize(count_);
        scenario::scatter_flock(
            count_, rules_, [&](std::size_t i, auto... values) { plain.agents[i] = {values...}; });
        plain.step();
        for (std::size_t i = 0; i < count_; ++i) {
            const double dx = static_cast<double>(agents_.column(3)[i] - plain.agents[i].vx);
            const double dy = static_cast<double>(agents_.column(4)[i] - plain.agents[i].vy);
            const double dz = static_cast<double>(agents_.column(5)[i] - plain.agents[i].vz);
            error_ = std::max(error_, std::sqrt(dx * dx + dy * dy + dz * dz));
        }
    }

    void judge(Row& row) override {
        row.error = error_;
        row.error_unit = "m/s";
    }

  private:
    std::size_t count_;
    kernels::FlockRules rules_;
    compute::Team team_;
    compute::ParticleColumns agents_;
    compute::FlockStage stage_;
    int frames_ = 0;
    double error_ = 0.0;
};

class PlainFlockTrial : public JudgedTrial {
  public:
    explicit PlainFlockTrial(std::size_t count) {
        plain_.rules = scenario::flock_rules(count);
        plain_.agents.resize(count);
        scenario::scatter_flock(count, plain_.rules, [this](std::size_t i, auto... values) {
            plain_.agents[i] = {values...};
        });
    }

    void frame() override { plain_.step(); }

    void judge(Row& row) override {
        row.error_unit = "m/s";
        row.metric("tested_per_agent",
                   static_cast<double>(plain_.tested) / static_cast<double>(plain_.agents.size()));
    }

  private:
    PlainFlock plain_;
};

/// Particles that a stage steps, alone, through a scene that its heirs set.
class StageTrial : public JudgedTrial {
  public:
    StageTrial(std::size_t count, compute::Device* device, compute::ParticleKernelOptions options)
        : count_(count),
          stage_(device, options) {
        columns_.reserve(count);
        scene_.world.h = kStepTime;
        scene_.world.gy = -9.81F;
    }

    void frame() override {
        const compute::StageRun run = stage_.step(columns_, count_, scene_, team_);
        if (!run.fault.empty()) {
            throw std::runtime_error(run.fault);
        }
    }

    void judge(Row& row) override { row.error_unit = "-"; }

  protected:
    void blow(float cells_per_m) {
        scene_.world.gust_cells_per_m = cells_per_m;
        gusts_.assign(3 * kernels::ZK_GUST_CORNERS, 0.5F);
        scene_.gusts = gusts_;
    }

    compute::ParticleColumns columns_;
    compute::ParticleScene scene_;

  private:
    std::size_t count_;
    compute::Team team_;
    std::vector<float> gusts_;
    compute::ParticleStage stage_;
};

/// Particles in gusts with walls to hit, where tables in constant memory and work groups matter.
class KernelTrial : public StageTrial {
  public:
    KernelTrial(std::size_t count,
                compute::Device& device,
                compute::ParticleKernelOptions options,
                bool gusts)
        : StageTrial(count, &device, options) {
        if (gusts) {
            scene_.world.linear_drag = 0.5F;
            blow(0.2F);
            scene_.world.planes = 4;
            for (int i = 0; i < 4; ++i) {
                scene_.world.plane[i] = {0.0F, 1.0F, 0.0F, -100.0F};
            }
        }
    }
};

/// The surroundings of a system's particles, each dearer than the one before.
enum class Surroundings : std::uint8_t {
    kGround,
    kDrag,
    kGusts,
    kEightBalls,
    kAll,  ///< sixteen balls and a heightfield
};

/// Particles that fall through 20 m over an area of 60 x 60 m: the measurement behind ParticleCost
/// (server/physics/method_selection/cost_table.h).
class SurroundedTrial : public StageTrial {
  public:
    SurroundedTrial(std::size_t count, Surroundings in, compute::Device* device)
        : StageTrial(count, device, {}) {
        kernels::ParticleWorld& w = scene_.world;
        w.restitution = 0.4F;
        w.friction = 0.5F;
        w.radius = 0.01F;
        w.planes = 1;
        w.plane[0] = {0.0F, 1.0F, 0.0F, 0.0F};
        w.linear_drag = in >= Surroundings::kDrag ? 0.1F : 0.0F;
        if (in >= Surroundings::kGusts) {
            blow(0.1F);
        }
        w.spheres = in == Surroundings::kAll ? 16 : (in == Surroundings::kEightBalls ? 8 : 0);
        for (int ball = 0; ball < w.spheres; ++ball) {
            w.sphere[ball] = {3.0F * static_cast<float>(ball), 1.0F, 0.0F, 0.9F};
        }
        if (in == Surroundings::kAll) {
            heights_.assign(64 * 64, 0.0F);
            scene_.heights = heights_;
            w.field = {64, 64, -32.0F, 0.0F, -32.0F, 1.0F, 1.0F, -1.0F};
        }
        core::Rng rng(1, 1);
        for (std::size_t i = 0; i < count; ++i) {
            const float values[] = {rng.range(-30.0F, 30.0F),
                                    rng.range(0.0F, 20.0F),
                                    rng.range(-30.0F, 30.0F),
                                    rng.range(-2.0F, 2.0F),
                                    rng.range(-8.0F, 0.0F),
                                    rng.range(-2.0F, 2.0F)};
            for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
                columns_.column(c)[i] = values[c];
            }
        }
    }

  private:
    std::vector<float> heights_;
};

void add_wall_ratio(std::vector<Row>& rows, const std::string& against, double items) {
    const auto base = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
        return (row.peer.empty() ? row.method : row.peer) == against;
    });
    for (Row& row : rows) {
        const double wall = *row.find_metric("wall_us_p50");
        row.metric("wall_ns_per_item", 1e3 * wall / items);
        if (base != rows.end()) {
            row.metric("wall_" + against + "_ratio", wall / *base->find_metric("wall_us_p50"));
        }
    }
}

void run_boids(Session& session) {
    const std::size_t count = session.quick ? 10'000 : 50'000;
    session.progress("kernels boids_50k");
    const auto ours = [count](const char* name, int threads, compute::Device* device) {
        return Method{name, "", [=] {
                          return std::make_unique<FlockTrial>(count, threads, device);
                      }};
    };
    std::vector<Method> methods{ours("default", 2, nullptr), ours("cpu_1", 1, nullptr)};
    if (bench().device) {
        methods.push_back(ours("opencl", 2, bench().device.get()));
    }
    methods.push_back({"default", "plain_loop", [count] {
                           return std::make_unique<PlainFlockTrial>(count);
                       }});
    const Plan plan{
        session.quick ? 1 : 5, session.quick ? 4 : 60, session.quick ? 1 : session.repeats};
    std::vector<Row> rows =
        compare("kernels", "boids_50k", "", wanted(session, std::move(methods)), plan);
    add_wall_ratio(rows, "plain_loop", static_cast<double>(count));
    session.add(std::move(rows));
}

/// The same steps with mapped and with copied buffers: the difference is the cost of copies.
void run_copies(Session& session) {
    if (!bench().copying) {
        return;
    }
    std::vector<std::size_t> sizes{4096, 65'536, 1'048'576};
    sizes.resize(session.quick ? 1 : sizes.size());
    for (const std::size_t count : sizes) {
        session.progress("kernels copies " + std::to_string(count));
        const auto with = [count](const char* name, compute::Device& device) {
            return Method{name, "", [count, &device] {
                              return std::make_unique<KernelTrial>(
                                  count, device, compute::ParticleKernelOptions(), false);
                          }};
        };
        const Plan plan{2, session.quick ? 10 : 100, session.quick ? 1 : session.repeats};
        std::vector<Row> rows = compare(
            "kernels",
            "copies",
            "n=" + std::to_string(count),
            wanted(session, {with("mapped", *bench().device), with("copied", *bench().copying)}),
            plan);
        for (Row& row : rows) {
            row.metric("bytes_each_way", 24.0 * static_cast<double>(count));
        }
        add_wall_ratio(rows, "mapped", static_cast<double>(count));
        session.add(std::move(rows));
    }
}

void run_groups(Session& session) {
    if (!bench().device) {
        return;
    }
    const std::size_t count = session.quick ? 16'384 : 262'144;
    std::vector<std::size_t> groups{0, 64, 256, 1024, 4096};
    groups.resize(session.quick ? 1 : groups.size());
    for (const std::size_t group : groups) {
        session.progress("kernels groups " + std::to_string(group));
        const auto with = [&](const char* name, bool global) {
            return Method{name, "", [=] {
                              return std::make_unique<KernelTrial>(
                                  count,
                                  *bench().device,
                                  compute::ParticleKernelOptions{group, global},
                                  true);
                          }};
        };
        const Plan plan{2, session.quick ? 5 : 40, session.quick ? 1 : session.repeats};
        std::vector<Row> rows =
            compare("kernels",
                    "groups",
                    group == 0 ? "chosen" : "group=" + std::to_string(group),
                    wanted(session, {with("constant_tables", false), with("global_tables", true)}),
                    plan);
        add_wall_ratio(rows, "constant_tables", static_cast<double>(count));
        session.add(std::move(rows));
    }
}

/// Flocking with neighbours in tiles of local memory and without, by the batches of a work group.
void run_tiles(Session& session) {
    if (!bench().device) {
        return;
    }
    using Tiles = compute::FlockKernelOptions::Tiles;
    const std::size_t count = 50'000;
    for (const std::size_t group : {0U, 8U, 32U, 256U}) {
        session.progress("kernels tiles " + std::to_string(group));
        const auto with = [=](const char* name, Tiles tiles) {
            return Method{name, "", [=] {
                              return std::make_unique<FlockTrial>(
                                  count,
                                  2,
                                  bench().device.get(),
                                  compute::FlockKernelOptions{group, tiles, 0});
                          }};
        };
        std::vector<Row> rows =
            compare("kernels",
                    "tiles",
                    group == 0 ? "chosen" : "group=" + std::to_string(group),
                    wanted(session, {with("no_tiles", Tiles::kOff), with("tiles", Tiles::kOn)}),
                    {3, 40, session.repeats});
        add_wall_ratio(rows, "no_tiles", static_cast<double>(count));
        session.add(std::move(rows));
    }
}

void run_surroundings(Session& session) {
    const std::size_t count = session.quick ? 4096 : 16'384;
    const std::pair<const char*, Surroundings> all[] = {
        {"ground", Surroundings::kGround},
        {"drag", Surroundings::kDrag},
        {"gusts", Surroundings::kGusts},
        {"balls_8", Surroundings::kEightBalls},
        {"balls_16_field", Surroundings::kAll},
    };
    for (const auto& [name, surroundings] : all) {
        session.progress(std::string("kernels surroundings ") + name);
        const auto with = [count, in = surroundings](const char* method, compute::Device* device) {
            return Method{method, "", [=] {
                              return std::make_unique<SurroundedTrial>(count, in, device);
                          }};
        };
        std::vector<Method> methods{with("cpu_1", nullptr)};
        // Each kind of surroundings is a kernel of its own, which takes long to build.
        if (bench().device && !session.quick) {
            methods.push_back(with("opencl", bench().device.get()));
        }
        const Plan plan{2, session.quick ? 5 : 60, session.quick ? 1 : session.repeats};
        std::vector<Row> rows =
            compare("kernels", "surroundings", name, wanted(session, std::move(methods)), plan);
        add_wall_ratio(rows, "cpu_1", static_cast<double>(count));
        session.add(std::move(rows));
    }
}

void run_kernels(Session& session) {
    session.note(
        "kernels: wall_* are times on the wall; time_us is CPU time of the calling thread");
    if (!bench().device) {
        session.note("kernels: no device rows: " + bench().no_device);
    }
    if (session.wants_scene("boids_50k")) {
        run_boids(session);
    }
    if (session.wants_scene("copies")) {
        run_copies(session);
    }
    if (session.wants_scene("surroundings")) {
        run_surroundings(session);
    }
    // The driver builds a kernel for each kind of group, which takes longer than a quick run may.
    if (session.wants_scene("groups") && !session.quick) {
        run_groups(session);
    }
    if (session.wants_scene("tiles") && !session.quick) {
        run_tiles(session);
    }
}

const Registration kKernels({"kernels",
                             "flocking agents; what particles live in; copies, work groups, tables "
                             "and tiles on a device",
                             {"boids_50k", "surroundings", "copies", "groups", "tiles"},
                             {"default",
                              "cpu_1",
                              "opencl",
                              "plain_loop/default",
                              "mapped",
                              "copied",
                              "constant_tables",
                              "global_tables",
                              "no_tiles",
                              "tiles"},
                             run_kernels});

}  // namespace

}  // namespace zoned::bench
