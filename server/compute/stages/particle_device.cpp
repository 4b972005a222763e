// build: hot loops
// Particles on a device: buffers over the columns, a kernel per kind of scene, and what is left to
// do when it fails.
#include "server/compute/device.h"
#include "server/compute/stages/device_columns.h"
#include "server/compute/stages/device_table.h"
#include "server/compute/stages/particle_stage.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

namespace zoned::compute {

struct ParticleStage::OnDevice {
    OnDevice(Device& opened, ParticleKernelOptions chosen) : device(opened), options(chosen) {}

    Device& device;
    ParticleKernelOptions options;
    std::array<std::optional<Kernel>, 6> built;  ///< by air and collision
    DeviceColumns columns;
    DeviceTable world, gusts, heights;
    HostBlock done_block;  ///< a flag per work group
    std::optional<Buffer> done;
    std::uint32_t stamp = 0;
    std::size_t group = 0;  ///< of the launch of this step, whose groups may have run; 0: none

    Status step(ParticleColumns& of, std::size_t count, const ParticleScene& scene);
    void finish_on_cpu(ParticleColumns& left,
                       std::size_t count,
                       const ParticleScene& scene,
                       Team& team) const;

  private:
    /// The kernel for a scene, built on first need.
    core::Result<Kernel*> kernel_of(const ParticleScene& scene);
    Status hold(ParticleColumns& of, std::size_t groups);
    Status set_arguments(Kernel& kernel, const ParticleColumns& of);
};

core::Result<Kernel*> ParticleStage::OnDevice::kernel_of(const ParticleScene& scene) {
    const int air = scene.air();
    const bool collides = scene.collides();
    std::optional<Kernel>& kernel = built[static_cast<std::size_t>(air) * 2 + (collides ? 1U : 0U)];
    if (!kernel) {
        std::string defines =
            "-DZK_AIR=" + std::to_string(air) + " -DZK_COLLIDE=" + std::to_string(collides ? 1 : 0);
        if (options.tables_in_global_memory) {
            defines += " -DZK_TABLES_IN_GLOBAL_MEMORY";
        }
        auto made = Kernel::make(device, "kernels/particles.cl", "particles_step", defines);
        if (!made) {
            return core::Result<Kernel*>::failure(made.error());
        }
        kernel.emplace(std::move(*made));
        if (options.group > 0) {
            kernel->set_group(options.group);
        }
        if (kernel->group() % kernels::kLanes != 0 ||
            ParticleColumns::kRoom % kernel->group() != 0) {
            const std::size_t items = kernel->group();
            kernel.reset();
            return core::Result<Kernel*>::failure("kernels/particles.cl: work groups of " +
                                                  std::to_string(items) +
                                                  " items are not whole lanes or no part of " +
                                                  std::to_string(ParticleColumns::kRoom));
        }
    }
    return &*kernel;
}

/// Buffers over the columns and the groups' flags.
Status ParticleStage::OnDevice::hold(ParticleColumns& of, std::size_t groups) {
    if (Status ok = columns.hold(device, of); !ok) {
        return ok;
    }
    const std::size_t bytes = groups * sizeof(stamp);
    if (!done || done_block.bytes() < bytes) {
        done.reset();
        done_block = HostBlock(2 * bytes);
        auto made = Buffer::over(device, done_block.data(), done_block.bytes());
        if (!made) {
            return Status::failure(made.error());
        }
        done.emplace(std::move(*made));
        stamp = 0;
        return done->give();
    }
    return Done{};
}

Status ParticleStage::OnDevice::set_arguments(Kernel& kernel, const ParticleColumns& of) {
    // A value that no group has left in its flag: a wrap takes two years at 60 steps a second.
    ++stamp;
    return first_failure({kernel.set(0, columns.buffer()),
                          kernel.set(1, static_cast<std::uint32_t>(of.stride())),
                          kernel.set(2, world.buffer()),
                          kernel.set(3, gusts.buffer()),
                          kernel.set(4, heights.buffer()),
                          kernel.set(5, *done),
                          kernel.set(6, stamp)});
}

Status ParticleStage::OnDevice::step(ParticleColumns& of,
                                     std::size_t count,
                                     const ParticleScene& scene) {
    group = 0;
    const auto kernel = kernel_of(scene);
    if (!kernel) {
        return Status::failure(kernel.error());
    }
    Kernel& k = **kernel;
    Status ready =
        first_failure({hold(of, k.groups_of(std::max(count, of.capacity()))),
                       world.set(device, &scene.world, sizeof(scene.world)),
                       gusts.set(device, scene.gusts.data(), scene.gusts.size_bytes()),
                       heights.set(device, scene.heights.data(), scene.heights.size_bytes())});
    if (!ready) {
        return ready;
    }
    if (Status given = first_failure({set_arguments(k, of), columns.give(count)}); !given) {
        return given;
    }
    group = k.group();
    return first_failure({k.launch(count), columns.take(count), device.finish(), columns.settle()});
}

/// On a device that works in the host's memory, groups that ended have stored their particles and
/// must not be done again; the others have not begun. Copies are all undone.
void ParticleStage::OnDevice::finish_on_cpu(ParticleColumns& left,
                                            std::size_t count,
                                            const ParticleScene& scene,
                                            Team& team) const {
    if (group == 0 || device.buffers() != BufferMode::kMapped) {
        step_particles(left, count, scene, team);
        return;
    }
    const std::uint32_t* const flags = done_block.as<std::uint32_t>();
    for (std::size_t g = 0; g * group < count; ++g) {
        if (flags[g] != stamp) {
            step_particle_range(left, g * group, std::min(count, (g + 1) * group), scene);
        }
    }
}

ParticleStage::ParticleStage(Device* device, ParticleKernelOptions options)
    : on_device_(device != nullptr ? std::make_unique<OnDevice>(*device, options) : nullptr) {
}

ParticleStage::~ParticleStage() = default;
ParticleStage::ParticleStage(ParticleStage&&) noexcept = default;
ParticleStage& ParticleStage::operator=(ParticleStage&&) noexcept = default;

bool ParticleStage::has_device() const {
    return on_device_ != nullptr;
}

StageRun ParticleStage::step(ParticleColumns& columns,
                             std::size_t count,
                             const ParticleScene& scene,
                             Team& team) {
    StageRun run;
    if (count == 0) {
        return run;
    }
    if (!has_device()) {
        step_particles(columns, count, scene, team);
        return run;
    }
    const std::scoped_lock turn(on_device_->device.turn());
    const Status done = on_device_->step(columns, count, scene);
    run.on_device = done.ok();
    if (!done) {
        run.fault = done.error();
        on_device_->finish_on_cpu(columns, count, scene, team);
        on_device_.reset();
    }
    return run;
}

}  // namespace zoned::compute
