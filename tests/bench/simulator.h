// Simulator: an engine that runs a described scene, with one interface for ours and its peers.
#pragma once

#include "tests/scenario/ray.h"
#include "shared/core/state_hash.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::bench {

/// Scenes of up to this number of bodies are run with costly alternatives too.
inline constexpr std::size_t kSmallScene = 300;

struct Motion {
    scenario::Pose pose;
    Vec3d velocity = Vec3d::Zero();  ///< m/s
    Vec3d spin = Vec3d::Zero();      ///< rad/s, world axes
    bool asleep = false;
};

class Simulator {
  public:
    Simulator() = default;
    Simulator(const Simulator&) = delete;
    Simulator& operator=(const Simulator&) = delete;
    virtual ~Simulator() = default;

    /// One time step of the description.
    virtual void step() = 0;
    /// Of a body by its index in the description.
    [[nodiscard]] virtual Motion motion(std::size_t body) const = 0;

    /// Brings the engine's trees into the best shape for the queries that follow.
    virtual void prepare_queries() {}

    /// Distance of the nearest hit of each ray, infinity for none; false where this engine does not
    /// answer such queries here.
    virtual bool cast(std::span<const scenario::Ray> rays, std::span<double> distances) const {
        return rays.empty() && distances.empty();
    }

    /// The heap that the engine's scene took when it was built, bytes.
    [[nodiscard]] double heap_bytes() const { return heap_bytes_; }

    void set_heap_bytes(double bytes) { heap_bytes_ = bytes; }

    /// Hash of the state as text; empty where the engine has none.
    [[nodiscard]] virtual std::string state_hash() const { return {}; }

  private:
    double heap_bytes_ = 0.0;
};

/// An engine with its settings.
struct Engine {
    std::string method;
    std::string peer;  ///< empty for ours
    std::function<std::unique_ptr<Simulator>(const scenario::Description&)> build;
    /// Why a scene can't be run, or empty. `scene` is its name.
    std::function<std::string(const std::string& scene, const scenario::Description&)> refusal;
};

/// 16 hexadecimal digits.
std::string hash_text(const core::StateHash& hash);

/// Ours: the default and its alternatives.
std::vector<Engine> zoned_engines();
/// Bullet at its defaults, with continuous collision detection, and with finer steps.
std::vector<Engine> bullet_engines();
/// Bullet for queries: its default rays, and its slower, more exact ones.
std::vector<Engine> bullet_query_engines();
/// ODE with its iterative solver (default) and with its exact one.
std::vector<Engine> ode_engines();

}  // namespace zoned::bench
