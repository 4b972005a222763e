#include "server/physics/particles/particle_systems.h"

#include "shared/core/archive/field_archive.h"
#include "shared/core/assert.h"

#include <optional>
#include <utility>

namespace zoned::physics {

core::Result<ParticleSystemId> ParticleSystems::add(ParticleSystemDef def) {
    std::string why = unfit(def);
    if (!why.empty()) {
        return core::Result<ParticleSystemId>::failure(std::move(why));
    }
    systems_.push_back(std::make_unique<ParticleSystem>(std::move(def), device_));
    ++count_;
    return ParticleSystemId(static_cast<std::uint32_t>(systems_.size()));
}

core::Result<std::uint32_t> ParticleSystems::add_emitter(ParticleSystemId system,
                                                         const motion::Emitter& emitter) {
    using Added = core::Result<std::uint32_t>;
    ParticleSystem* const found = find(system);
    if (found == nullptr) {
        return Added::failure("there is no particle system " + std::to_string(system.value));
    }
    const std::string why = motion::unfit(emitter);
    if (!why.empty()) {
        return Added::failure(found->name() + ": emitter: " + why);
    }
    return found->add(emitter);
}

bool ParticleSystems::remove(ParticleSystemId system) {
    if (find(system) == nullptr) {
        return false;
    }
    systems_[system.value - 1].reset();
    --count_;
    return true;
}

void ParticleSystems::use_device(compute::Device* device,
                                 const compute::Crossover& of_falling,
                                 const compute::Crossover& of_flocks) {
    device_ = device;
    of_falling_ = of_falling;
    of_flocks_ = of_flocks;
    for (const auto& system : systems_) {
        if (system) {
            system->use_device(device);
        }
    }
}

ParticleSystem* ParticleSystems::find(ParticleSystemId system) {
    return system && system.value <= systems_.size() ? systems_[system.value - 1].get() : nullptr;
}

const ParticleSystem* ParticleSystems::find(ParticleSystemId system) const {
    return system && system.value <= systems_.size() ? systems_[system.value - 1].get() : nullptr;
}

ParticleReport ParticleSystems::step(Tick now, float h, compute::Team& team) {
    ZONED_ASSERT(h > 0.0F && h <= 1.0F, "a particle step is above 0 and at most a second long");
    ParticleReport report;
    if (empty()) {
        return report;
    }
    // Calling other threads costs as much as some thousand particles.
    std::optional<compute::Team::Shift> shift;
    for (const auto& system : systems_) {
        if (!system) {
            continue;
        }
        if (!shift && system->keeps_threads_busy()) {
            shift.emplace(team);
        }
        const compute::Crossover& crossover = system->is_flock() ? of_flocks_ : of_falling_;
        const bool on_device = device_ != nullptr && crossover.choose(system->size(), true, true) ==
                                                         compute::Side::kDevice;
        compute::StageRun run = system->step(now, h, on_device, team, report.counts);
        report.particles += system->size();
        report.on_device += run.on_device ? 1 : 0;
        if (!run.fault.empty()) {
            report.fault = std::move(run.fault);
        }
    }
    return report;
}

void ParticleSystems::save(core::FieldWriter& archive) const {
    for (const auto& system : systems_) {
        if (system) {
            archive.section(system->name(), [&] { archive(*system); });
        }
    }
}

void ParticleSystems::load(core::FieldReader& archive) {
    for (const auto& system : systems_) {
        if (system) {
            archive.section(system->name(), [&] { archive(*system); });
        }
    }
}

void ParticleSystems::hash(core::StateHash& hash) const {
    for (const auto& system : systems_) {
        hash.add(system ? std::uint64_t{1} : std::uint64_t{0});
        if (system) {
            system->hash(hash);
        }
    }
}

}  // namespace zoned::physics
