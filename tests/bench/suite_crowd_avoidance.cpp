#include "server/ai/crowd/orca_avoidance.h"
#include "server/compute/worker_pool.h"
#include "tests/bench/comparison.h"
#include "tests/bench/suite_crowd.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::bench {

namespace {

using ai::steering::AvoidanceReport;
using ai::steering::CrowdAgents;
using ai::steering::OrcaAvoidance;
using ai::steering::Walls;

constexpr float kPerM2 = 0.5F;         ///< agents
constexpr float kBodyRadius = 0.25F;   ///< m
constexpr float kWalkingSpeed = 1.3F;  ///< m/s
constexpr float kFastest = 2.0F;

/// People who cross a square in all directions, each to a goal of its own and then to another.
class AvoidanceTrial final : public JudgedTrial {
  public:
    AvoidanceTrial(std::size_t count, int threads)
        : side_(std::sqrt(static_cast<float>(count) / kPerM2)) {
        if (threads > 1) {
            pool_ = std::make_unique<compute::WorkerPool>(threads);
            team_.join_pool(*pool_);
        }
        core::Rng rng(1);
        agents_.reserve(count);
        // One in each square of a lattice, so that none overlap at first.
        const auto lines =
            static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
        const float pitch = side_ / static_cast<float>(lines);
        for (std::size_t i = 0; i < count; ++i) {
            const float spare = pitch / 2 - kBodyRadius;
            const float x =
                (static_cast<float>(i % lines) + 0.5F) * pitch + rng.range(-spare, spare);
            const float z =
                (static_cast<float>(i / lines) + 0.5F) * pitch + rng.range(-spare, spare);
            agents_.add(static_cast<std::uint32_t>(i), x, z, kBodyRadius, kFastest);
            goals_.push_back({rng.range(0.0F, side_), rng.range(0.0F, side_)});
        }
        rng_ = rng;
        aim();
    }

    void frame() override {
        const compute::Team::Shift shift(team_);
        const AvoidanceReport report = avoidance_.step(agents_, Walls(), tick_++, team_);
        relaxed_ += report.relaxed;
        stuck_ += report.stuck;
    }

    /// Runs that are only timed do not turn: their 80 steps are 5 m, less than most paths.
    void observe() override {
        worst_overlap_ = std::max(worst_overlap_, overlap());
        for (std::size_t i = 0; i < agents_.size(); ++i) {
            walked_ += std::hypot(agents_.vx[i], agents_.vz[i]);
        }
        steps_ += static_cast<double>(agents_.size());
        aim();
    }

    void judge(Row& row) override {
        row.error = worst_overlap_;
        row.error_unit = "overlap / radius";
        row.metric("agents", static_cast<double>(agents_.size()));
        row.metric("relaxed_share", relaxed_ / steps_);
        row.metric("stuck_share", stuck_ / steps_);
        row.metric("speed_share", walked_ / steps_ / static_cast<double>(kWalkingSpeed));
    }

  private:
    struct Goal {
        float x, z;
    };

    void aim() {
        for (std::size_t i = 0; i < agents_.size(); ++i) {
            float dx = goals_[i].x - agents_.x[i];
            float dz = goals_[i].z - agents_.z[i];
            if (std::hypot(dx, dz) < 2.0F) {
                goals_[i] = {rng_.range(0.0F, side_), rng_.range(0.0F, side_)};
                dx = goals_[i].x - agents_.x[i];
                dz = goals_[i].z - agents_.z[i];
            }
            const float d = std::max(1e-3F, std::hypot(dx, dz));
            agents_.want_x[i] = kWalkingSpeed * dx / d;
            agents_.want_z[i] = kWalkingSpeed * dz / d;
            agents_.path_left[i] = d;
        }
    }

    /// Sweeps all pairs along x: a box farther along than a diameter does not matter.
    [[nodiscard]] double overlap() {
        by_x_.resize(agents_.size());
        for (std::size_t i = 0; i < by_x_.size(); ++i) {
            by_x_[i] = static_cast<std::uint32_t>(i);
        }
        std::sort(by_x_.begin(), by_x_.end(), [this](std::uint32_t a, std::uint32_t b) {
            return agents_.x[a] < agents_.x[b];
        });
        double worst = 0.0;
        for (std::size_t i = 0; i < by_x_.size(); ++i) {
            for (std::size_t j = i + 1; j < by_x_.size(); ++j) {
                const double dx = static_cast<double>(agents_.x[by_x_[j]]) -
                                  static_cast<double>(agents_.x[by_x_[i]]);
                const double dz = static_cast<double>(agents_.z[by_x_[j]]) -
                                  static_cast<double>(agents_.z[by_x_[i]]);
                const auto radius = static_cast<double>(kBodyRadius);
                if (dx > 2.0 * radius) {
                    break;
                }
                worst = std::max(worst, (2.0 * radius - std::hypot(dx, dz)) / radius);
            }
        }
        return worst;
    }

    float side_;
    core::Rng rng_;
    std::unique_ptr<compute::WorkerPool> pool_;
    compute::Team team_;
    CrowdAgents agents_;
    std::vector<Goal> goals_;
    std::vector<std::uint32_t> by_x_;
    OrcaAvoidance avoidance_{{}};
    std::uint64_t tick_ = 0;
    double relaxed_ = 0.0;
    double stuck_ = 0.0;
    double walked_ = 0.0;
    double steps_ = 0.0;
    double worst_overlap_ = 0.0;
};

}  // namespace

void run_crowd_avoidance(Session& session) {
    const std::size_t count = session.quick ? 2'000 : 20'000;
    session.progress("crowd avoidance_20k");
    session.note(
        "crowd avoidance_20k: 20,000 people at 0.5 per m2, radius 0.25 m, 1.3 m/s, in all "
        "directions; neighbours within 3 m, horizon 1.2 s, steps of 0.05 s; time is per agent and "
        "step, on one thread (cpu_2: two), the error is the largest overlap after any step over a "
        "radius");
    const auto with = [count](const char* name, int threads) {
        return Method{name, "", [=] {
                          return std::make_unique<AvoidanceTrial>(count, threads);
                      }};
    };
    const auto methods = wanted(session, {with("default", 1), with("cpu_2", 2)});
    const Plan plan{20, session.quick ? 5 : 60, session.quick ? 1 : session.repeats};
    std::vector<Row> rows = compare("crowd", kAvoidanceScene, "", methods, plan);
    for (Row& row : rows) {
        const auto agents = static_cast<double>(count);
        row.time_us_p50 /= agents;
        row.time_us_p99 /= agents;
        row.metric("ns_per_agent", 1e3 * row.time_us_p50);
        row.metric("wall_ns_per_agent", 1e3 * *row.find_metric("wall_us_p50") / agents);
    }
    session.add(std::move(rows));
}

}  // namespace zoned::bench
