#include "server/ai/pathfinding/flow_fields/flock_flow_field.h"
#include "server/compute/device.h"
#include "server/compute/stages/flock_stage.h"
#include "server/compute/worker_pool.h"
#include "tests/bench/comparison.h"
#include "tests/bench/suite_crowd.h"
#include "tests/scenario/flock.h"

#include <cstring>
#include <stdexcept>
#include <utility>

namespace zoned::bench {

namespace {

/// A flock that follows a path through its box.
class SteeredFlockTrial final : public JudgedTrial {
  public:
    SteeredFlockTrial(std::size_t count, int threads, compute::Device* device)
        : count_(count),
          rules_(scenario::flock_rules(count)),
          stage_(device) {
        if (threads > 1) {
            pool_ = std::make_unique<compute::WorkerPool>(threads);
            team_.join_pool(*pool_);
        }
        const float side = rules_.high_x;
        const Vec2 path[] = {{0.1F * side, 0.1F * side},
                             {0.9F * side, 0.3F * side},
                             {0.2F * side, 0.6F * side},
                             {0.9F * side, 0.9F * side}};
        const int cells = static_cast<int>(side / 4.0F) + 1;
        field_ = ai::pathfinding::along_path(path, {0.0F, 0.0F, 4.0F, cells, cells, {}}, 20.0F);
        field_.steer(rules_, 1.0F);
        agents_ = scattered();
        reference_ = scattered();
    }

    void frame() override {
        const compute::Team::Shift shift(team_);
        const compute::StageRun run =
            stage_.step(agents_, count_, rules_, team_, field_.directions);
        if (!run.fault.empty()) {
            throw std::runtime_error(run.fault);
        }
    }

    /// The number of values that differ from those of one thread without a device.
    void observe() override {
        compute::Team alone;
        plain_.step(reference_, count_, rules_, alone, field_.directions);
        for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
            for (std::size_t i = 0; i < count_; ++i) {
                different_ +=
                    std::memcmp(agents_.column(c) + i, reference_.column(c) + i, sizeof(float)) != 0
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
    [[nodiscard]] compute::ParticleColumns scattered() const {
        compute::ParticleColumns agents;
        agents.reserve(count_);
        scenario::scatter_flock(count_, rules_, [&agents](std::size_t i, auto... values) {
            std::size_t c = 0;
            ((agents.column(c++)[i] = values), ...);
        });
        return agents;
    }

    std::size_t count_;
    kernels::FlockRules rules_;
    std::unique_ptr<compute::WorkerPool> pool_;
    compute::Team team_;
    ai::pathfinding::FlockFlowField field_;
    compute::ParticleColumns agents_;
    compute::ParticleColumns reference_;
    compute::FlockStage stage_;
    compute::FlockStage plain_;
    double different_ = 0.0;
};

}  // namespace

void run_crowd_flock(Session& session) {
    const std::size_t count = session.quick ? 5'000 : 50'000;
    session.progress("crowd flock_50k");
    session.note(
        "crowd flock_50k: 50,000 agents, 45 neighbours tested each, that follow a path by a table "
        "of directions, a step; wall_ms is what counts on two cores; the error is the number of "
        "numbers that differ from one thread's");
    auto device = compute::Device::open({});
    const auto with = [count](const char* name, int threads, compute::Device* on) {
        return Method{name, "", [=] {
                          return std::make_unique<SteeredFlockTrial>(count, threads, on);
                      }};
    };
    std::vector<Method> methods{with("default", 2, nullptr), with("cpu_1", 1, nullptr)};
    if (device) {
        methods.push_back(with("opencl", 1, device->get()));
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
