// build: hot loops
// The step of a flock: sorted on the host, moved on the lanes of a team or on a device.
#include "server/compute/device.h"
#include "server/compute/stages/device_columns.h"
#include "server/compute/stages/device_table.h"
#include "server/compute/stages/flock_stage.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace zoned::compute {

namespace {

constexpr std::size_t kFlockGrain = 64;  ///< batches: some ten microseconds
/// Batches of a work group: each is a loop of its own, so a few are enough.
constexpr std::size_t kFlockGroup = 64;
constexpr std::size_t kAgentBytes = ParticleColumns::kColumns * sizeof(float);
/// Agents of a tile: 12 KiB, of which a compute unit holds several groups' at a time.
constexpr std::size_t kTileAgents = 512;
/// Batches of a work group with tiles, at most. At a barrier a CPU device keeps the state of all
/// items of a group, a kilobyte each, on one stack: PoCL dies of 4,096.
constexpr std::size_t kMostTileGroup = 256;
constexpr std::size_t kMostTileAgents = 1U << 16U;

}  // namespace

std::size_t choose_tile(const DeviceInfo& device, const FlockKernelOptions& options) {
    using Tiles = FlockKernelOptions::Tiles;
    const bool wanted =
        options.tiles == Tiles::kOn || (options.tiles == Tiles::kChosen && device.own_local_memory);
    // Drivers keep some of it for themselves; where it is a part of the common memory, a device may
    // name any size.
    const std::size_t most = std::min(device.local_bytes / 2 / kAgentBytes, kMostTileAgents);
    const std::size_t agents = options.tile_agents > 0 ? options.tile_agents : kTileAgents;
    return wanted ? std::min(agents, most) : 0;
}

struct FlockStage::OnDevice {
    OnDevice(Device& opened, const FlockKernelOptions& chosen)
        : device(opened),
          options(chosen),
          tile(choose_tile(opened.info(), chosen)) {}

    Device& device;
    FlockKernelOptions options;
    std::size_t tile;  ///< agents, 0: without
    std::optional<Kernel> kernel;
    DeviceColumns agents, sorted;
    DeviceTable order, cells, batches, rules, grid, field;

    Status make_kernel();
    Status prepare(ParticleColumns& of,
                   FlockOrder& by,
                   const kernels::FlockRules& how,
                   std::span<const float> along);
    Status step(ParticleColumns& of,
                std::size_t count,
                FlockOrder& by,
                const kernels::FlockRules& how,
                std::span<const float> along);
};

Status FlockStage::OnDevice::make_kernel() {
    if (!kernel) {
        auto made = Kernel::make(
            device, "kernels/flock.cl", tile > 0 ? "flock_step_tiles" : "flock_step", "");
        if (!made) {
            return Status::failure(made.error());
        }
        kernel.emplace(std::move(*made));
        const std::size_t group = options.group > 0 ? options.group : kFlockGroup;
        kernel->set_group(tile > 0 ? std::min(group, kMostTileGroup) : group);
        if (tile > 0) {
            return first_failure({kernel->set_local(10, tile * kAgentBytes),
                                  kernel->set(11, static_cast<std::int32_t>(tile))});
        }
    }
    return Done{};
}

Status FlockStage::OnDevice::prepare(ParticleColumns& of,
                                     FlockOrder& by,
                                     const kernels::FlockRules& how,
                                     std::span<const float> along) {
    if (Status made = make_kernel(); !made) {
        return made;
    }
    const auto bytes = [](const auto& list) {
        return list.size() * sizeof(list[0]);
    };
    return first_failure({agents.hold(device, of),
                          sorted.hold(device, by.sorted()),
                          order.set(device, by.order().data(), bytes(by.order())),
                          cells.set(device, by.cell_begin().data(), bytes(by.cell_begin())),
                          batches.set(device, by.batches().data(), bytes(by.batches())),
                          rules.set(device, &how, sizeof(how)),
                          field.set(device, along.data(), along.size_bytes()),
                          grid.set(device, &by.grid(), sizeof(by.grid()))});
}

Status FlockStage::OnDevice::step(ParticleColumns& of,
                                  std::size_t count,
                                  FlockOrder& by,
                                  const kernels::FlockRules& how,
                                  std::span<const float> along) {
    if (Status ready = prepare(of, by, how, along); !ready) {
        return ready;
    }
    Kernel& k = *kernel;
    const auto stride = static_cast<std::int32_t>(of.stride());
    const auto total = static_cast<std::int32_t>(by.batches().size());
    return first_failure({agents.give(count),
                          sorted.give(count + kernels::kLanes),
                          k.set(0, agents.buffer()),
                          k.set(1, sorted.buffer()),
                          k.set(2, stride),
                          k.set(3, order.buffer()),
                          k.set(4, cells.buffer()),
                          k.set(5, batches.buffer()),
                          k.set(6, total),
                          k.set(7, rules.buffer()),
                          k.set(8, grid.buffer()),
                          k.set(9, field.buffer()),
                          k.launch(by.batches().size()),
                          agents.take(count),
                          sorted.take_unchanged(),
                          device.finish(),
                          agents.settle()});
}

FlockStage::FlockStage(Device* device, FlockKernelOptions options)
    : on_device_(device != nullptr ? std::make_unique<OnDevice>(*device, options) : nullptr) {
}

FlockStage::~FlockStage() = default;
FlockStage::FlockStage(FlockStage&&) noexcept = default;
FlockStage& FlockStage::operator=(FlockStage&&) noexcept = default;

bool FlockStage::has_device() const {
    return on_device_ != nullptr;
}

StageRun FlockStage::step(ParticleColumns& agents,
                          std::size_t count,
                          const kernels::FlockRules& rules,
                          Team& team,
                          std::span<const float> field) {
    ZONED_ASSERT(
        rules.follow <= 0.0F || (rules.field_columns > 0 && rules.field_rows > 0 &&
                                 field.size() == 2 * static_cast<std::size_t>(rules.field_columns) *
                                                     static_cast<std::size_t>(rules.field_rows)),
        "the field has two numbers for each cell");
    StageRun run;
    if (count == 0) {
        return run;
    }
    order_.sort(agents, count, rules, std::sqrt(rules.radius2), team);
    if (has_device()) {
        const std::scoped_lock turn(on_device_->device.turn());
        const Status done = on_device_->step(agents, count, order_, rules, field);
        run.on_device = done.ok();
        if (!done) {
            run.fault = done.error();
            on_device_.reset();
        }
    }
    if (!run.on_device) {
        team.run(order_.batches().size(), kFlockGrain, [&](std::size_t begin, std::size_t end) {
            step_flock_batches(agents, order_, rules, field.data(), begin, end);
        });
    }
    return run;
}

}  // namespace zoned::compute
