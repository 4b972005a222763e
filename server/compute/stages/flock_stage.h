// FlockStage: moves flocking agents by one step: a grid of cells, agents sorted by cell, eight at a
// time.
#pragma once

#include "server/compute/stages/particle_stage.h"
#include "kernels/include/flock.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace zoned::compute {

struct DeviceInfo;

/// Agents in the order of their cells, for a step to read. A grid of its own beside
/// spatial::PointGrid: kernels read its columns as they are, eight agents at a time.
class FlockOrder {
  public:
    /// Sorts (stable, by counting) the first `count` agents into cells of `cell_size` (m, > 0) over
    /// the box of `rules`, which is finite. Cells are made larger where there would be more than
    /// kMostCells. An agent outside of the box counts to the rim, an agent at NaN to the first
    /// cell.
    void sort(const ParticleColumns& agents,
              std::size_t count,
              const kernels::FlockRules& rules,
              float cell_size,
              Team& team);

    static constexpr std::size_t kMostCells = 1U << 18U;

    [[nodiscard]] const kernels::FlockGrid& grid() const { return grid_; }

    [[nodiscard]] ParticleColumns& sorted() { return sorted_; }

    [[nodiscard]] const ParticleColumns& sorted() const { return sorted_; }

    /// Number of the agent at each place of sorted().
    [[nodiscard]] const std::vector<std::int32_t>& order() const { return order_; }

    /// First place of each cell, and the end.
    [[nodiscard]] const std::vector<std::int32_t>& cell_begin() const { return cell_begin_; }

    [[nodiscard]] const std::vector<kernels::FlockBatch>& batches() const { return batches_; }

  private:
    void lay_grid(const kernels::FlockRules& rules, float cell_size);
    void make_batches();

    kernels::FlockGrid grid_{};
    ParticleColumns sorted_;
    std::vector<std::int32_t> cell_of_;
    std::vector<std::int32_t> order_;
    std::vector<std::int32_t> cell_begin_;
    std::vector<kernels::FlockBatch> batches_;
};

/// One step of the batches [begin, end) on eight lanes, into `agents`. `field` as in
/// FlockStage::step.
void step_flock_batches(ParticleColumns& agents,
                        const FlockOrder& order,
                        const kernels::FlockRules& rules,
                        const float* field,
                        std::size_t begin,
                        std::size_t end);

/// Choices of a measurement; the defaults are the fastest. All give the same bits.
struct FlockKernelOptions {
    enum class Tiles : std::uint8_t {
        kChosen,  ///< on where a device has local memory of its own
        kOff,     ///< neighbours are read from the sorted agents
        kOn       ///< work groups copy neighbours to local memory, tile by tile
    };

    std::size_t group = 0;  ///< batches of a work group, cut to what is possible; 0: chosen
    Tiles tiles = Tiles::kChosen;
    std::size_t tile_agents = 0;  ///< of a tile, cut to what local memory holds; 0: chosen
};

/// Agents of a tile for a device; 0: no tiles.
std::size_t choose_tile(const DeviceInfo& device, const FlockKernelOptions& options);

/// A step of a flock, on all threads of a team or on a device: the same bits. The state before the
/// step stays in FlockOrder, so that a device that fails costs nothing but time.
class FlockStage {
  public:
    /// Null: there is no device. It must outlive the stage.
    explicit FlockStage(Device* device = nullptr, FlockKernelOptions options = {});
    ~FlockStage();
    FlockStage(FlockStage&&) noexcept;
    FlockStage& operator=(FlockStage&&) noexcept;

    /// `field`: where rules.follow > 0, field_columns x field_rows pairs of numbers (see
    /// FlockRules), the caller's.
    StageRun step(ParticleColumns& agents,
                  std::size_t count,
                  const kernels::FlockRules& rules,
                  Team& team,
                  std::span<const float> field = {});

    [[nodiscard]] const FlockOrder& order() const { return order_; }

    /// Whether a device is there that did not fail yet.
    [[nodiscard]] bool has_device() const;

  private:
    struct OnDevice;

    FlockOrder order_;
    std::unique_ptr<OnDevice> on_device_;
};

}  // namespace zoned::compute
