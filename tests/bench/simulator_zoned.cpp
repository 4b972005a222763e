#include "server/compute/worker_pool.h"
#include "tests/bench/simulator.h"
#include "tests/bench/zoned_scene.h"

#include <cmath>
#include <cstdio>

namespace zoned::bench {

namespace {

class ZonedSimulator : public Simulator {
  public:
    ZonedSimulator(const scenario::Description& description,
                   const physics::PhysicsSettings& settings,
                   unsigned threads)
        : pool_(threads),
          zoned_(build_scene(description, settings)) {
        team_.join_pool(pool_);
        zoned_.scene.work_with(&team_);
    }

    void step() override { zoned_.scene.step(zoned_.dt); }

    [[nodiscard]] Motion motion(std::size_t body) const override {
        const physics::BodyState state = zoned_.scene.state(zoned_.ids[body]);
        Motion m;
        const physics::Frame& frame = zoned_.frames[body];
        m.pose.orientation =
            state.orientation.cast<double>() * frame.rotation.cast<double>().conjugate();
        m.pose.position =
            state.position.cast<double>() - m.pose.orientation * frame.position.cast<double>();
        m.velocity = state.velocity.cast<double>();
        m.spin = state.angular_velocity.cast<double>();
        m.asleep = state.asleep;
        return m;
    }

    bool cast(std::span<const scenario::Ray> rays, std::span<double> distances) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            physics::RayHit hit;
            const bool found = zoned_.scene.ray_cast(rays[i].origin.cast<float>(),
                                                     rays[i].direction.cast<float>(),
                                                     static_cast<float>(rays[i].length),
                                                     0,
                                                     hit);
            distances[i] = found ? static_cast<double>(hit.distance) : INFINITY;
        }
        return true;
    }

    [[nodiscard]] std::string state_hash() const override {
        core::StateHash hash;
        zoned_.scene.hash(hash);
        return hash_text(hash);
    }

  private:
    compute::WorkerPool pool_;
    compute::Team team_;
    ZonedScene zoned_;
};

Engine zoned_engine(std::string method,
                    const physics::PhysicsSettings& settings,
                    unsigned threads = 1) {
    return {std::move(method),
            "",
            [settings, threads](const scenario::Description& description) {
                return std::make_unique<ZonedSimulator>(description, settings, threads);
            },
            [settings](const std::string& /*scene*/, const scenario::Description& description) {
                // Where a scene is large, one method stands for all.
                const bool costly = settings.substeps != 0 ||
                                    (settings.method != physics::SolverVariant::kSoftStep &&
                                     settings.method != physics::SolverVariant::kGaussSeidel);
                const bool large = costly && description.bodies.size() > kSmallScene;
                return std::string(large ? "only for small scenes" : "");
            }};
}

}  // namespace

std::string hash_text(const core::StateHash& hash) {
    char text[17];
    std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash.value()));
    return text;
}

std::vector<Engine> zoned_engines() {
    physics::PhysicsSettings strict;
    strict.error_budget_m = 0.002F;
    std::vector<Engine> engines{zoned_engine("default", physics::PhysicsSettings()),
                                zoned_engine("budget_2mm", strict),
                                zoned_engine("threads_2", physics::PhysicsSettings(), 2)};
    for (const int substeps : {2, 4, 8, 16}) {
        physics::PhysicsSettings fixed;
        fixed.substeps = substeps;
        engines.push_back(zoned_engine("substeps_" + std::to_string(substeps), fixed));
    }
    for (const NamedMethod& named : contact_methods()) {
        physics::PhysicsSettings other;
        other.method = named.method;
        other.methods.manifold = named.manifold;
        engines.push_back(zoned_engine(named.name, other));
    }
    return engines;
}

}  // namespace zoned::bench
