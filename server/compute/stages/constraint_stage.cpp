// build: hot loops
#include "server/compute/stages/constraint_stage.h"

#include "server/compute/device.h"
#include "server/compute/stages/device_columns.h"
#include "server/compute/stages/device_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace zoned::compute {

namespace {

using kernels::DistanceLink;
using kernels::kLanes;
using kernels::LaneInts;
using kernels::Lanes;

constexpr std::size_t kLinkGrain = 512;

std::string unfit_link(const DistanceLink& link, std::size_t nodes) {
    const auto known = [nodes](int node) {
        return node >= 0 && static_cast<std::size_t>(node) < nodes;
    };
    if (!known(link.a) || !known(link.b)) {
        return "a node that is not there";
    }
    if (link.a == link.b) {
        return "joins a node to itself";
    }
    if (!(link.rest > 0.0F) || !std::isfinite(link.rest)) {
        return "rest length must be above 0";
    }
    return link.compliance >= 0.0F && std::isfinite(link.compliance)
               ? std::string()
               : "compliance must be finite and not below 0";
}

struct Nodes {
    float* x;
    std::size_t stride;
};

/// Up to eight links of one colour; lanes beyond repeat the first and are not stored.
void solve_eight(const Nodes& nodes,
                 const DistanceLink* links,
                 float* lambdas,
                 std::size_t count,
                 float per_h2) {
    LaneInts a{};
    LaneInts b{};
    Lanes rest{};
    Lanes compliance{};
    Lanes lambda{};
    for (std::size_t i = 0; i < kLanes; ++i) {
        const std::size_t from = i < count ? i : 0;
        a[i] = links[from].a;
        b[i] = links[from].b;
        rest[i] = links[from].rest;
        compliance[i] = links[from].compliance;
        lambda[i] = lambdas[from];
    }
    Lanes pa[4];
    Lanes pb[4];
    for (std::size_t c = 0; c < 4; ++c) {
        pa[c] = kernels::zk_gather(nodes.x + c * nodes.stride, a);
        pb[c] = kernels::zk_gather(nodes.x + c * nodes.stride, b);
    }
    kernels::constraint_solve(&pa[0],
                              &pa[1],
                              &pa[2],
                              pa[3],
                              &pb[0],
                              &pb[1],
                              &pb[2],
                              pb[3],
                              rest,
                              compliance * per_h2,
                              &lambda);
    for (std::size_t i = 0; i < count; ++i) {
        lambdas[i] = lambda[i];
        for (std::size_t c = 0; c < 3; ++c) {
            nodes.x[c * nodes.stride + static_cast<std::size_t>(a[i])] = pa[c][i];
            nodes.x[c * nodes.stride + static_cast<std::size_t>(b[i])] = pb[c][i];
        }
    }
}

}  // namespace

core::Result<ColouredLinks> ColouredLinks::make(std::span<const DistanceLink> links,
                                                std::size_t nodes) {
    using Made = core::Result<ColouredLinks>;
    std::vector<std::uint64_t> taken(nodes, 0);
    std::vector<std::uint8_t> colour(links.size());
    std::vector<std::size_t> begin(65, 0);
    std::size_t colours = 0;
    for (std::size_t i = 0; i < links.size(); ++i) {
        const std::string why = unfit_link(links[i], nodes);
        if (!why.empty()) {
            return Made::failure("link " + std::to_string(i) + ": " + why);
        }
        std::uint64_t& at_a = taken[static_cast<std::size_t>(links[i].a)];
        std::uint64_t& at_b = taken[static_cast<std::size_t>(links[i].b)];
        const auto free = static_cast<std::size_t>(std::countr_one(at_a | at_b));
        if (free == 64) {
            return Made::failure("link " + std::to_string(i) + ": more than 64 colours");
        }
        at_a |= std::uint64_t{1} << free;
        at_b |= std::uint64_t{1} << free;
        colour[i] = static_cast<std::uint8_t>(free);
        colours = std::max(colours, free + 1);
        ++begin[free + 1];
    }
    for (std::size_t c = 1; c < begin.size(); ++c) {
        begin[c] += begin[c - 1];
    }
    ColouredLinks made;
    made.begin_.assign(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(colours) + 1);
    made.links_.resize(links.size());
    for (std::size_t i = 0; i < links.size(); ++i) {
        made.links_[begin[colour[i]]++] = links[i];
    }
    return made;
}

struct ConstraintStage::OnDevice {
    explicit OnDevice(Device& opened) : device(opened) {}

    Device& device;
    std::optional<Kernel> kernel;
    DeviceColumns nodes;
    DeviceTable links, lambdas;
    std::vector<float> before;  ///< positions, should the device fail

    void remember(const ParticleColumns& of, std::size_t count);
    void restore(ParticleColumns& to, std::size_t count) const;
    Status prepare(ParticleColumns& of, const ColouredLinks& by, std::span<const float> zeros);
    Status run(ParticleColumns& of,
               std::size_t count,
               const ColouredLinks& by,
               float h,
               int passes);
};

void ConstraintStage::OnDevice::remember(const ParticleColumns& of, std::size_t count) {
    before.resize(3 * count);
    for (std::size_t c = 0; c < 3; ++c) {
        std::memcpy(before.data() + c * count, of.column(c), count * sizeof(float));
    }
}

void ConstraintStage::OnDevice::restore(ParticleColumns& to, std::size_t count) const {
    for (std::size_t c = 0; c < 3; ++c) {
        std::memcpy(to.column(c), before.data() + c * count, count * sizeof(float));
    }
}

Status ConstraintStage::OnDevice::prepare(ParticleColumns& of,
                                          const ColouredLinks& by,
                                          std::span<const float> zeros) {
    if (!kernel) {
        auto made = Kernel::make(device, "kernels/constraints.cl", "constraints_solve", "");
        if (!made) {
            return Status::failure(made.error());
        }
        kernel.emplace(std::move(*made));
    }
    const std::size_t bytes = by.links().size() * sizeof(DistanceLink);
    return first_failure({nodes.hold(device, of),
                          links.set(device, by.links().data(), bytes),
                          lambdas.clear(device, zeros.data(), zeros.size_bytes())});
}

Status ConstraintStage::OnDevice::run(ParticleColumns& of,
                                      std::size_t count,
                                      const ColouredLinks& by,
                                      float h,
                                      int passes) {
    Kernel& k = *kernel;
    Status given = first_failure({nodes.give(count),
                                  k.set(0, nodes.buffer()),
                                  k.set(1, static_cast<std::int32_t>(of.stride())),
                                  k.set(2, links.buffer()),
                                  k.set(3, lambdas.buffer()),
                                  k.set(6, 1.0F / (h * h))});
    if (!given) {
        return given;
    }
    for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t c = 0; c < by.colours(); ++c) {
            const std::size_t first = by.colour_begin()[c];
            const std::size_t links_of = by.colour_begin()[c + 1] - first;
            Status queued = first_failure({k.set(4, static_cast<std::int32_t>(first)),
                                           k.set(5, static_cast<std::int32_t>(links_of)),
                                           k.launch(links_of)});
            if (!queued) {
                return queued;
            }
        }
    }
    return first_failure({nodes.take(count), device.finish(), nodes.settle()});
}

ConstraintStage::ConstraintStage(Device* device)
    : on_device_(device != nullptr ? std::make_unique<OnDevice>(*device) : nullptr) {
}

ConstraintStage::~ConstraintStage() = default;
ConstraintStage::ConstraintStage(ConstraintStage&&) noexcept = default;
ConstraintStage& ConstraintStage::operator=(ConstraintStage&&) noexcept = default;

bool ConstraintStage::has_device() const {
    return on_device_ != nullptr;
}

void ConstraintStage::solve_on_cpu(ParticleColumns& nodes,
                                   const ColouredLinks& links,
                                   float h,
                                   int passes,
                                   Team& team) {
    const Nodes view{nodes.column(0), nodes.stride()};
    const float per_h2 = 1.0F / (h * h);
    for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t c = 0; c < links.colours(); ++c) {
            const std::size_t first = links.colour_begin()[c];
            const std::size_t count = links.colour_begin()[c + 1] - first;
            team.run(count, kLinkGrain, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = first + begin; i < first + end; i += kLanes) {
                    solve_eight(view,
                                links.links().data() + i,
                                lambdas_.data() + i,
                                std::min(kLanes, first + end - i),
                                per_h2);
                }
            });
        }
    }
}

StageRun ConstraintStage::solve(ParticleColumns& nodes,
                                std::size_t count,
                                const ColouredLinks& links,
                                float h,
                                int passes,
                                Team& team) {
    StageRun run;
    lambdas_.assign(links.links().size(), 0.0F);
    if (lambdas_.empty()) {
        return run;
    }
    if (has_device()) {
        OnDevice& on = *on_device_;
        const std::scoped_lock turn(on.device.turn());
        on.remember(nodes, count);
        Status done = on.prepare(nodes, links, lambdas_);
        if (done) {
            done = on.run(nodes, count, links, h, passes);
        }
        run.on_device = done.ok();
        if (!done) {
            run.fault = done.error();
            on.restore(nodes, count);
            on_device_.reset();
        }
    }
    if (!run.on_device) {
        solve_on_cpu(nodes, links, h, passes, team);
    }
    return run;
}

}  // namespace zoned::compute
