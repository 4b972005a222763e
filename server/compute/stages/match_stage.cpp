// build: hot loops
#include "server/compute/stages/match_stage.h"

#include "server/compute/device.h"
#include "server/compute/stages/device_columns.h"
#include "server/compute/stages/device_table.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace zoned::compute {

namespace {

using kernels::FlockGrid;
using kernels::kLanes;
using kernels::LaneInts;
using kernels::Lanes;
using kernels::MatchViewer;

constexpr std::size_t kViewerGrain = 16;
constexpr std::size_t kFirstRoom = 64;

/// The entities at [begin, end) of the sorted columns, eight at a time.
void match_stretch(const FlockOrder& order,
                   int begin,
                   int end,
                   const MatchViewer& viewer,
                   int& count,
                   std::int32_t* out,
                   int most) {
    const float* const x = order.sorted().column(ParticleColumns::kX);
    const float* const z = order.sorted().column(ParticleColumns::kZ);
    const float* const aura = order.sorted().column(kAura);
    const Lanes nimbus = Lanes{} + viewer.nimbus;
    for (int j = begin; j < end; j += static_cast<int>(kLanes)) {
        const LaneInts hears = kernels::match_hears(kernels::zk_load(x + j) - viewer.x,
                                                    kernels::zk_load(z + j) - viewer.z,
                                                    kernels::zk_load(aura + j),
                                                    nimbus);
        const int stop = std::min(end - j, static_cast<int>(kLanes));
        for (int i = 0; i < stop; ++i) {
            if (hears[i] != 0) {
                if (count < most) {
                    out[count] = order.order()[static_cast<std::size_t>(j + i)];
                }
                ++count;
            }
        }
    }
}

int match_viewer(const FlockOrder& order,
                 const MatchViewer& viewer,
                 float reach,
                 std::int32_t* out,
                 int most) {
    const FlockGrid& grid = order.grid();
    const float r = viewer.nimbus < reach ? viewer.nimbus : reach;
    const float x = viewer.x - grid.x0;
    const float z = viewer.z - grid.z0;
    const int first = kernels::flock_clamp_cell((x - r) * grid.cells_per_m, grid.columns);
    const int last = kernels::flock_clamp_cell((x + r) * grid.cells_per_m, grid.columns);
    const int low = kernels::flock_clamp_cell((z - r) * grid.cells_per_m, grid.rows);
    const int high = kernels::flock_clamp_cell((z + r) * grid.cells_per_m, grid.rows);
    const std::int32_t* const cells = order.cell_begin().data();
    int count = 0;
    for (int row = low; row <= high && r > 0.0F; ++row) {
        const std::int32_t* const at = cells + row * grid.columns;
        match_stretch(order, at[first], at[last + 1], viewer, count, out, most);
    }
    return count;
}

float largest_aura(const ParticleColumns& entities, std::size_t count) {
    const float* const aura = entities.column(kAura);
    float reach = 0.0F;
    for (std::size_t i = 0; i < count; ++i) {
        reach = std::max(reach, aura[i]);
    }
    return reach;
}

}  // namespace

struct MatchStage::OnDevice {
    explicit OnDevice(Device& opened) : device(opened) {}

    Device& device;
    std::optional<Kernel> kernel;
    DeviceColumns entities;
    DeviceTable viewers, order, cells, grid, found, out;

    Status prepare(FlockOrder& by, std::span<const MatchViewer> who, const Matches& matches);
    Status run(FlockOrder& by,
               std::size_t count,
               std::span<const MatchViewer> who,
               float reach,
               Matches& matches);
};

Status MatchStage::OnDevice::prepare(FlockOrder& by,
                                     std::span<const MatchViewer> who,
                                     const Matches& matches) {
    if (!kernel) {
        auto made = Kernel::make(device, "kernels/matching.cl", "matching_viewers", "");
        if (!made) {
            return Status::failure(made.error());
        }
        kernel.emplace(std::move(*made));
        kernel->set_group(kLanes);
    }
    const auto bytes = [](const auto& list) {
        return list.size() * sizeof(list[0]);
    };
    return first_failure({entities.hold(device, by.sorted()),
                          viewers.set(device, who.data(), who.size_bytes()),
                          order.set(device, by.order().data(), bytes(by.order())),
                          cells.set(device, by.cell_begin().data(), bytes(by.cell_begin())),
                          grid.set(device, &by.grid(), sizeof(by.grid())),
                          found.clear(device, matches.found.data(), bytes(matches.found)),
                          out.clear(device, matches.out.data(), bytes(matches.out))});
}

Status MatchStage::OnDevice::run(FlockOrder& by,
                                 std::size_t count,
                                 std::span<const MatchViewer> who,
                                 float reach,
                                 Matches& matches) {
    if (Status ready = prepare(by, who, matches); !ready) {
        return ready;
    }
    Kernel& k = *kernel;
    Status done = first_failure({entities.give(count),
                                 k.set(0, viewers.buffer()),
                                 k.set(1, static_cast<std::int32_t>(who.size())),
                                 k.set(2, entities.buffer()),
                                 k.set(3, static_cast<std::int32_t>(by.sorted().stride())),
                                 k.set(4, order.buffer()),
                                 k.set(5, cells.buffer()),
                                 k.set(6, grid.buffer()),
                                 k.set(7, reach),
                                 k.set(8, found.buffer()),
                                 k.set(9, out.buffer()),
                                 k.set(10, static_cast<std::int32_t>(matches.most)),
                                 k.launch(who.size()),
                                 entities.take_unchanged()});
    if (!done) {
        return done;
    }
    return first_failure(
        {found.read(device, matches.found.data(), matches.found.size() * sizeof(std::int32_t)),
         out.read(device, matches.out.data(), matches.out.size() * sizeof(std::int32_t))});
}

MatchStage::MatchStage(Device* device)
    : on_device_(device != nullptr ? std::make_unique<OnDevice>(*device) : nullptr) {
}

MatchStage::~MatchStage() = default;
MatchStage::MatchStage(MatchStage&&) noexcept = default;
MatchStage& MatchStage::operator=(MatchStage&&) noexcept = default;

bool MatchStage::has_device() const {
    return on_device_ != nullptr;
}

StageRun MatchStage::match(const ParticleColumns& entities,
                           std::size_t count,
                           const kernels::FlockRules& box,
                           float cell_size,
                           std::span<const MatchViewer> viewers,
                           Matches& matches,
                           Team& team) {
    StageRun run;
    matches.found.assign(viewers.size(), 0);
    if (viewers.empty() || count == 0) {
        return run;
    }
    order_.sort(entities, count, box, cell_size, team);
    const float reach = largest_aura(entities, count);
    matches.most = std::max(matches.most, kFirstRoom);
    for (;;) {
        matches.out.resize(viewers.size() * matches.most);
        run.on_device = false;
        if (has_device()) {
            const std::scoped_lock turn(on_device_->device.turn());
            const Status done = on_device_->run(order_, count, viewers, reach, matches);
            run.on_device = done.ok();
            if (!done) {
                run.fault = done.error();
                on_device_.reset();
            }
        }
        if (!run.on_device) {
            team.run(viewers.size(), kViewerGrain, [&](std::size_t begin, std::size_t end) {
                for (std::size_t v = begin; v < end; ++v) {
                    matches.found[v] = match_viewer(order_,
                                                    viewers[v],
                                                    reach,
                                                    matches.out.data() + v * matches.most,
                                                    static_cast<int>(matches.most));
                }
            });
        }
        const auto largest =
            static_cast<std::size_t>(*std::max_element(matches.found.begin(), matches.found.end()));
        if (largest <= matches.most) {
            return run;
        }
        matches.most = largest + largest / 4;
    }
}

}  // namespace zoned::compute
