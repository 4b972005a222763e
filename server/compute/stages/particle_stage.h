// ParticleStage: moves the particles of one system by one step, on lanes and threads or on a
// device.
#pragma once

#include "server/compute/host_block.h"
#include "server/compute/stages/stage_run.h"
#include "server/compute/team.h"
#include "kernels/include/particle.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace zoned::compute {

class Device;

/// Six columns of floats in one block of memory: position (m) and velocity (m/s). The columns are
/// `stride` numbers apart and hold whole lanes. Numbers beyond the particles are zero or left over
/// and may be worked on.
class ParticleColumns {
  public:
    enum Column : std::size_t {
        kX,
        kY,
        kZ,
        kVx,
        kVy,
        kVz,
        kColumns
    };

    /// Columns have room for so many particles or a multiple of it, and so for whole work groups.
    static constexpr std::size_t kRoom = 4096;

    /// Makes room; the content stays. Pointers change where it grows.
    void reserve(std::size_t particles);

    [[nodiscard]] std::size_t capacity() const { return capacity_; }

    [[nodiscard]] std::size_t stride() const { return stride_; }

    [[nodiscard]] float* column(std::size_t c) { return block_->as<float>() + c * stride_; }

    [[nodiscard]] const float* column(std::size_t c) const {
        return block_->as<float>() + c * stride_;
    }

    /// Replaced where the columns grow. A caller that has a device work in it keeps it alive.
    [[nodiscard]] const std::shared_ptr<HostBlock>& block() const { return block_; }

  private:
    std::shared_ptr<HostBlock> block_;
    std::size_t capacity_ = 0;
    std::size_t stride_ = 0;
};

/// The surroundings that a system's particles move in. The tables belong to the caller and stay as
/// they are during a step.
struct ParticleScene {
    kernels::ParticleWorld world{};
    std::span<const float> gusts;    ///< 3 ZK_GUST_CORNERS numbers (x, y, z; m/s), or none
    std::span<const float> heights;  ///< rows times columns of world.field, or none

    /// ZK_AIR_*: the parts of the air that the step has to compute.
    [[nodiscard]] int air() const;
    [[nodiscard]] bool collides() const;
};

/// One step of `count` particles on eight lanes and all threads of the team, in blocks that do not
/// touch each other: the same bits for any number of threads, and as on a device.
void step_particles(ParticleColumns& columns,
                    std::size_t count,
                    const ParticleScene& scene,
                    Team& team);

/// The same for the particles in [begin, end); begin is a multiple of kernels::kLanes.
void step_particle_range(ParticleColumns& columns,
                         std::size_t begin,
                         std::size_t end,
                         const ParticleScene& scene);

/// Choices of a measurement; the defaults are the fastest.
struct ParticleKernelOptions {
    std::size_t group =
        0;  ///< work items of a group, a power of 2 in 8..4096; 0: chosen per device
    bool tables_in_global_memory = false;  ///< instead of constant memory
};

/// Runs steps on a device. Where the device or the kernel fails, the CPU does the step (or the rest
/// of it: see particles.cl). The device is given up, and all later steps run on the CPU.
class ParticleStage {
  public:
    /// Null: there is no device. It must outlive the stage.
    explicit ParticleStage(Device* device = nullptr, ParticleKernelOptions options = {});
    ~ParticleStage();
    ParticleStage(ParticleStage&&) noexcept;
    ParticleStage& operator=(ParticleStage&&) noexcept;

    /// Whether a device is there that did not fail yet.
    [[nodiscard]] bool has_device() const;

    StageRun step(ParticleColumns& columns,
                  std::size_t count,
                  const ParticleScene& scene,
                  Team& team);

  private:
    struct OnDevice;

    std::unique_ptr<OnDevice> on_device_;
};

}  // namespace zoned::compute
