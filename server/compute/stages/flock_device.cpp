// The step of a flock: sorted on the host, moved on the lanes of a team or on a device.
#include "server/compute/device.h"
#include "server/compute/stages/device_columns.h"
#include "server/compute/stages/device_table.h"
#include "server/compute/stages/flock_stage.h"

#include <cmath>
#include <optional>
#include <utility>

namespace zoned::compute {

namespace {

constexpr std::size_t kFlockGrain = 64;  ///< batches: some ten microseconds
/// Batches of a work group: each is a loop of its own, so a few are enough.
constexpr std::size_t kFlockGroup = 64;

}  // namespace

struct FlockStage::OnDevice {
    explicit OnDevice(Device& opened) : device(opened) {}

    Device& device;
    bool given_up = false;
    std::optional<Kernel> kernel;
    DeviceColumns agents, sorted;
    DeviceTable order, cells, batches, rules, grid;

    Status prepare(ParticleColumns& of, FlockOrder& by, const kernels::FlockRules& how);
    Status step(ParticleColumns& of,
                std::size_t count,
                FlockOrder& by,
                const kernels::FlockRules& how);
};

Status FlockStage::OnDevice::prepare(ParticleColumns& of,
                                     FlockOrder& by,
                                     const kernels::FlockRules& how) {
    if (!kernel) {
        auto made = Kernel::make(device, "kernels/flock.cl", "flock_step", "");
        if (!made) {
            return Status::failure(made.error());
        }
        kernel.emplace(std::move(*made));
        kernel->set_group(kFlockGroup);
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
                          grid.set(device, &by.grid(), sizeof(by.grid()))});
}

Status FlockStage::OnDevice::step(ParticleColumns& of,
                                  std::size_t count,
                                  FlockOrder& by,
                                  const kernels::FlockRules& how) {
    if (Status ready = prepare(of, by, how); !ready) {
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
                          k.launch(by.batches().size()),
                          agents.take(count),
                          sorted.take_unchanged(),
                          device.finish(),
                          agents.settle()});
}

FlockStage::FlockStage(Device* device)
    : on_device_(device != nullptr ? std::make_unique<OnDevice>(*device) : nullptr) {
}

FlockStage::~FlockStage() = default;
FlockStage::FlockStage(FlockStage&&) noexcept = default;
FlockStage& FlockStage::operator=(FlockStage&&) noexcept = default;

bool FlockStage::has_device() const {
    return on_device_ != nullptr && !on_device_->given_up;
}

StageRun FlockStage::step(ParticleColumns& agents,
                          std::size_t count,
                          const kernels::FlockRules& rules,
                          Team& team) {
    StageRun run;
    if (count == 0) {
        return run;
    }
    order_.sort(agents, count, rules, std::sqrt(rules.radius2), team);
    if (has_device()) {
        const std::scoped_lock turn(on_device_->device.turn());
        const Status done = on_device_->step(agents, count, order_, rules);
        run.on_device = done.ok();
        if (!done) {
            run.fault = done.error();
            on_device_->given_up = true;
        }
    }
    if (!run.on_device) {
        team.run(order_.batches().size(), kFlockGrain, [&](std::size_t begin, std::size_t end) {
            step_flock_batches(agents, order_, rules, begin, end);
        });
    }
    return run;
}

}  // namespace zoned::compute
