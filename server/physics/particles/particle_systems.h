// ParticleSystems: the particles of a zone: smoke, debris and rain that rules or physics ask about.
#pragma once

#include "server/compute/crossover.h"
#include "server/physics/particles/particle_system.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace zoned::compute {
class Device;
}

namespace zoned::core {
class FieldReader;
class FieldWriter;
}  // namespace zoned::core

namespace zoned::physics {

/// Counted from 1; 0 is none.
using ParticleSystemId = StrongId<struct ParticleSystemTag>;

struct ParticleReport {
    std::size_t particles = 0;  ///< after the step
    ParticleCounts counts;
    unsigned on_device = 0;  ///< systems that a device moved
    std::string fault;       ///< why a device was given up, in the step in which that happened
};

/// Particles that only look nice do not belong here: nobody simulates or sends them, a client
/// replays them from motion::CosmeticEmitter. A zone without systems has nothing to step, hash or
/// keep: empty() says so.
class ParticleSystems {
  public:
    /// Fails with the name of the system and the mistake.
    core::Result<ParticleSystemId> add(ParticleSystemDef def);

    /// Fails where there is no such system or the emitter is unfit. An emitter that began in the
    /// past has missed its particles.
    core::Result<std::uint32_t> add_emitter(ParticleSystemId system,
                                            const motion::Emitter& emitter);

    /// Its particles go with it. False where there is no such system.
    bool remove(ParticleSystemId system);

    /// From now on the motion may be computed on a device, which must outlive this, where the
    /// crossovers of falling particles and of flocks say so. The owner of a clock measures them.
    /// Only a device that rounds correctly opens. On it the kernel gives the bits of the CPU path
    /// (tested), so that the choice never shows in a hash. Systems that are there already start
    /// anew on it. Null: no device.
    void use_device(compute::Device* device,
                    const compute::Crossover& of_falling,
                    const compute::Crossover& of_flocks = {});

    [[nodiscard]] bool empty() const { return count_ == 0; }

    /// Null where there is no such system.
    [[nodiscard]] ParticleSystem* find(ParticleSystemId system);
    [[nodiscard]] const ParticleSystem* find(ParticleSystemId system) const;

    /// One step of h seconds (0 < h <= 1) from tick `now`, systems one after the other, each on all
    /// threads of the team. Allocates only where columns grow.
    ParticleReport step(Tick now, float h, compute::Team& team);

    void hash(core::StateHash& hash) const;

    /// The particles of all systems, between two steps.
    void save(core::FieldWriter& archive) const;
    /// The systems are those that were saved, as their definitions made them.
    void load(core::FieldReader& archive);

  private:
    std::vector<std::unique_ptr<ParticleSystem>> systems_;  ///< null: removed
    std::size_t count_ = 0;
    compute::Device* device_ = nullptr;
    compute::Crossover of_falling_;
    compute::Crossover of_flocks_;
};

}  // namespace zoned::physics
