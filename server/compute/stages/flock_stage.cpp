// build: hot loops
#include "server/compute/stages/flock_stage.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::compute {

namespace {

using kernels::FlockBatch;
using kernels::FlockKernelSum;
using kernels::kLanes;
using kernels::Lanes;

constexpr std::size_t kGatherGrain = 4096;  ///< agents

void step_flock_batch(ParticleColumns& agents,
                      const FlockOrder& order,
                      const kernels::FlockRules& rules,
                      const float* field,
                      const FlockBatch& batch) {
    const auto stride = static_cast<int>(order.sorted().stride());
    const float* const sorted = order.sorted().column(0);
    const float* const at = sorted + batch.begin;
    Lanes state[ParticleColumns::kColumns];
    for (int c = 0; c < 6; ++c) {
        state[c] = kernels::zk_load(at + c * stride);
    }
    FlockKernelSum<Lanes> sum{};
    kernels::flock_look(&sum,
                        &rules,
                        &order.grid(),
                        batch,
                        order.cell_begin().data(),
                        sorted,
                        stride,
                        state[0],
                        state[1],
                        state[2]);
    kernels::flock_steer(
        &sum, &rules, field, &state[0], &state[1], &state[2], &state[3], &state[4], &state[5]);
    float* const to = agents.column(0);
    for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
        for (int i = batch.begin; i < batch.end; ++i) {
            to[c * agents.stride() + static_cast<std::size_t>(order.order()[i])] =
                state[c][i - batch.begin];
        }
    }
}

}  // namespace

void FlockOrder::lay_grid(const kernels::FlockRules& rules, float cell_size) {
    const double width = std::max<double>(double{rules.high_x} - double{rules.low_x}, cell_size);
    const double depth = std::max<double>(double{rules.high_z} - double{rules.low_z}, cell_size);
    // With s the size: (w / s + 1) (d / s + 1) is at most K / 2 + K / 8 + K / 8 + 1.
    constexpr auto kMost = static_cast<double>(kMostCells);
    const double least =
        std::max(std::sqrt(width * depth / (kMost / 2.0)), std::max(width, depth) / (kMost / 8.0));
    const auto size = std::max(cell_size, static_cast<float>(least));
    ZONED_ASSERT(size > 0.0F && std::isfinite(size), "cells have a size, the box has ends");
    grid_.x0 = rules.low_x;
    grid_.z0 = rules.low_z;
    grid_.cells_per_m = 1.0F / size;
    grid_.columns = static_cast<int>(std::ceil(width / static_cast<double>(size)));
    grid_.rows = static_cast<int>(std::ceil(depth / static_cast<double>(size)));
}

void FlockOrder::sort(const ParticleColumns& agents,
                      std::size_t count,
                      const kernels::FlockRules& rules,
                      float cell_size,
                      Team& team) {
    lay_grid(rules, cell_size);
    const auto cells = static_cast<std::size_t>(grid_.columns) * grid_.rows;
    cell_begin_.assign(cells + 1, 0);
    cell_of_.resize(count);
    order_.resize(count);
    sorted_.reserve(agents.capacity());
    const float* const x = agents.column(ParticleColumns::kX);
    const float* const z = agents.column(ParticleColumns::kZ);
    team.run(count, kGatherGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            cell_of_[i] = kernels::flock_cell(&grid_, x[i], z[i]);
        }
    });
    for (const std::int32_t cell : cell_of_) {
        ++cell_begin_[static_cast<std::size_t>(cell) + 1];
    }
    for (std::size_t c = 0; c < cells; ++c) {
        cell_begin_[c + 1] += cell_begin_[c];
    }
    // Each cell's begin walks to its end, which is where the next begins: shifted back afterwards.
    for (std::size_t i = 0; i < count; ++i) {
        order_[static_cast<std::size_t>(cell_begin_[static_cast<std::size_t>(cell_of_[i])]++)] =
            static_cast<std::int32_t>(i);
    }
    std::copy_backward(cell_begin_.begin(), cell_begin_.end() - 1, cell_begin_.end());
    cell_begin_[0] = 0;
    team.run(count, kGatherGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
            const float* const from = agents.column(c);
            float* const to = sorted_.column(c);
            for (std::size_t i = begin; i < end; ++i) {
                to[i] = from[order_[i]];
            }
        }
    });
    make_batches();
}

/// Batches do not cross rows: the cells around one that did would be two rows of the whole grid.
void FlockOrder::make_batches() {
    batches_.clear();
    for (int row = 0; row < grid_.rows; ++row) {
        const auto first = static_cast<std::size_t>(row) * grid_.columns;
        const int end = cell_begin_[first + static_cast<std::size_t>(grid_.columns)];
        for (int i = cell_begin_[first]; i < end; i += static_cast<int>(kLanes)) {
            const int stop = std::min(end, i + static_cast<int>(kLanes));
            const int begin_cell = cell_of_[static_cast<std::size_t>(order_[i])];
            const int end_cell = cell_of_[static_cast<std::size_t>(order_[stop - 1])];
            batches_.push_back(
                {i, stop, begin_cell - row * grid_.columns, end_cell - row * grid_.columns, row});
        }
    }
}

void step_flock_batches(ParticleColumns& agents,
                        const FlockOrder& order,
                        const kernels::FlockRules& rules,
                        const float* field,
                        std::size_t begin,
                        std::size_t end) {
    const kernels::FlockRules fixed = rules;  // that nothing stored can alias
    for (std::size_t b = begin; b < end; ++b) {
        step_flock_batch(agents, order, fixed, field, order.batches()[b]);
    }
}

}  // namespace zoned::compute
