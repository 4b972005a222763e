// NpcWorld: NPCs of a config's types and players on an open plain; only agents and walking run.
#pragma once

#include "server/ai/ai_update.h"
#include "server/compute/team.h"
#include "server/compute/worker_pool.h"
#include "server/config/settings.h"
#include "server/spatial/point_grid.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::bench {

/// How many NPCs of each type.
struct NpcShare {
    std::string type;
    double share;
};

class NpcWorld {
  public:
    struct Plan {
        std::size_t people = 0;
        std::vector<NpcShare> shares;
        std::size_t players = 0;  ///< stand at the nodes of a square lattice
        float side_m = 0.0F;      ///< of the square in which all of them live
        bool simulate_all = false;
        int threads = 1;
    };

    /// `settings` must outlive this.
    NpcWorld(const config::Settings& settings, const Plan& plan);

    /// One tick; measures thread CPU time of the caller and wall-clock time of its two halves.
    struct Cost {
        std::int64_t agents_ns = 0;
        std::int64_t agents_wall_ns = 0;
        std::int64_t walk_ns = 0;
    };

    Cost tick();

    [[nodiscard]] const ai::AiReport& report() const { return report_; }

    [[nodiscard]] Tick now() const { return now_; }

  private:
    void add(const std::string& type, std::size_t count, float side_m);
    void walk();

    const config::Settings& settings_;
    ai::AiSettings ai_;
    float dt_;
    world::Entities entities_;
    ai::AgentStore agents_;
    ai::AiUpdate step_;
    ai::PointsOfInterest places_;
    motion::StaticGeometry plain_;
    spatial::PointGrid grid_;
    std::unique_ptr<compute::WorkerPool> pool_;
    compute::Team team_;
    core::Rng rng_{3};
    Tick now_ = 0;
    ai::AiReport report_;
};

}  // namespace zoned::bench
