// ParticleSystem: particles that live in one air and bounce off the same things.
#pragma once

#include "server/compute/stages/particle_stage.h"
#include "server/physics/particles/particle_flock.h"
#include "server/physics/particles/wind.h"
#include "server/physics/shapes/heightfield.h"
#include "shared/core/result.h"
#include "shared/core/state_hash.h"
#include "shared/motion/emitter.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::physics {

/// Solid where normal . p < offset.
struct ParticleWall {
    Vec3 normal = Vec3::UnitY();  ///< unit
    float offset = 0.0F;          ///< m
};

struct ParticleBall {
    Vec3 centre = Vec3::Zero();
    float radius = 1.0F;  ///< m, > 0
};

/// SI units, zone coordinates.
struct ParticleSystemDef {
    std::string name = "particles";  ///< for errors
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);
    float linear_drag = 0.0F;                  ///< 1/s: deceleration over speed relative to the air
    float quadratic_drag = 0.0F;               ///< 1/m: deceleration over the square of that speed
    Wind wind;                                 ///< of no effect without drag
    float radius = 0.0F;                       ///< of a particle when it collides, m
    float restitution = 0.3F;                  ///< 0..1
    float friction = 0.5F;                     ///< Coulomb
    std::vector<ParticleWall> walls;           ///< at most kernels::ZK_MOST_PLANES
    std::vector<ParticleBall> balls;           ///< at most kernels::ZK_MOST_SPHERES; they may move
    std::shared_ptr<const Heightfield> field;  ///< or null
    Vec3 field_origin = Vec3::Zero();          ///< where its middle lies
    std::size_t most = 1U << 20U;              ///< particles at a time; more are not born
    int pieces = 1;                            ///< equal steps that a step is cut into, 1..64
    /// Set: the particles steer by each other. Of all above, `name` and `most` alone matter then.
    std::optional<FlockDef> flock;
};

/// Why a system is refused ("smoke: restitution: must be 0..1"); empty: it is not.
std::string unfit(const ParticleSystemDef& def);

struct ParticleCounts {
    std::size_t born = 0;
    std::size_t died = 0;
    std::size_t refused = 0;  ///< births for which there was no room
};

/// Particles in columns, without a meaningful order: the last one replaces a particle that dies.
/// Births, deaths and their order depend on emitters and ticks alone, and each particle's step on
/// that particle alone. So everything is the same for any number of threads and on any device that
/// rounds correctly.
class ParticleSystem {
  public:
    /// `def` is fit. No device: null.
    ParticleSystem(ParticleSystemDef def, compute::Device* device);

    [[nodiscard]] const std::string& name() const { return def_.name; }

    /// `emitter` is fit. Its number among the system's emitters.
    std::uint32_t add(const motion::Emitter& emitter);

    /// Drops emitters that are through before tick `now`; those behind them get other numbers.
    void forget_over(Tick now, float h);

    /// Another device from now on, or none.
    void use_device(compute::Device* device);

    [[nodiscard]] bool is_flock() const { return flock_ != nullptr; }

    /// Moves the balls; as many as the system was made with.
    void move_balls(std::span<const ParticleBall> balls);

    /// Deaths, births (with the part of the step that they live already), then one step of h
    /// seconds, in as many pieces as the system is defined with. `now` is the tick in which the
    /// step begins. The caller chooses the side that computes the motion; without a device it is
    /// the CPU.
    compute::StageRun step(Tick now,
                           float h,
                           bool on_device,
                           compute::Team& team,
                           ParticleCounts& counts);

    [[nodiscard]] std::size_t size() const { return size_; }

    /// Whether a step is long enough that calling another thread for it pays.
    [[nodiscard]] bool keeps_threads_busy() const;

    [[nodiscard]] Vec3 position(std::size_t i) const;
    [[nodiscard]] Vec3 velocity(std::size_t i) const;

    [[nodiscard]] const compute::ParticleColumns& columns() const { return columns_; }

    /// Whether nothing is there and nothing is ever born from `now` on.
    [[nodiscard]] bool is_over(Tick now, float h) const;

    /// Columns, ends of lives and emitters.
    void hash(core::StateHash& hash) const;

    /// The particles, emitters and balls; what the definition says is there already.
    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t count = size_;
        archive(count, ends_, block_ends_, emitters_);
        if constexpr (Archive::kReads) {
            if (count > def_.most || ends_.size() < count || block_ends_.size() * kBlock < count) {
                archive.fail("particles are more than have an end, or than there may be");
                return;
            }
            size_ = static_cast<std::size_t>(count);
            columns_.reserve(size_);
        }
        for (std::size_t c = 0; c < compute::ParticleColumns::kColumns; ++c) {
            if (size_ > 0) {
                archive.items(columns_.column(c), size_);
            }
        }
        for (int ball = 0; ball < scene_.world.spheres; ++ball) {
            archive(scene_.world.sphere[ball]);
        }
    }

  private:
    static constexpr std::size_t kBlock = 1024;  ///< particles that share a next end of life

    void bury(Tick now, ParticleCounts& counts);
    void bury_block(std::size_t block, Tick now, ParticleCounts& counts);
    void remove(std::size_t i);
    void give_birth(Tick now, float h, ParticleCounts& counts);
    void put(const motion::Birth& birth, Tick now, double h, double since_start_s);
    void update_world(double time_s, float h);
    compute::StageRun fly(Tick now, float h, bool on_device, compute::Team& team);

    ParticleSystemDef def_;
    std::vector<float> gusts_;
    compute::ParticleScene scene_;
    compute::ParticleStage stage_;
    compute::ParticleColumns columns_;
    compute::ParticleStage cpu_stage_;
    std::unique_ptr<Flock> flock_;  ///< null: the particles fall
    std::size_t size_ = 0;
    std::vector<Tick> ends_;        ///< the tick before which a particle dies
    std::vector<Tick> block_ends_;  ///< the first of each block
    std::vector<motion::Emitter> emitters_;
};

}  // namespace zoned::physics
