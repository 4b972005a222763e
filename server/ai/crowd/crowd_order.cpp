#include "server/ai/crowd/crowd_order.h"

#include "kernels/include/kernel_base.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai::steering {

namespace {

constexpr std::size_t kSortGrain = 4096;  ///< agents
constexpr float kFarthest = 1e6F;         ///< m; an agent farther out counts to the rim

int clamped_cell(float at, int count) {
    return !(at > 0.0F) ? 0
                        : (at < static_cast<float>(count - 1) ? static_cast<int>(at) : count - 1);
}

}  // namespace

void CrowdOrder::lay_grid(const CrowdAgents& agents, float cell_m) {
    float low[2] = {kFarthest, kFarthest};
    float high[2] = {-kFarthest, -kFarthest};
    for (std::size_t i = 0; i < agents.size(); ++i) {
        const float at[2] = {agents.x[i], agents.z[i]};
        for (int axis = 0; axis < 2; ++axis) {
            if (std::abs(at[axis]) <= kFarthest) {
                low[axis] = std::min(low[axis], at[axis]);
                high[axis] = std::max(high[axis], at[axis]);
            }
        }
    }
    const double width = std::max(0.0, static_cast<double>(high[0]) - static_cast<double>(low[0]));
    const double depth = std::max(0.0, static_cast<double>(high[1]) - static_cast<double>(low[1]));
    double size = cell_m;
    while ((std::floor(width / size) + 1.0) * (std::floor(depth / size) + 1.0) >
           static_cast<double>(kMostCells)) {
        size *= 2.0;
    }
    low_x_ = low[0];
    low_z_ = low[1];
    per_m_ = static_cast<float>(1.0 / size);
    columns_ = static_cast<int>(width / size) + 1;
    cell_rows_ = static_cast<int>(depth / size) + 1;
}

void CrowdOrder::sort(const CrowdAgents& agents, float cell_m, compute::Team& team) {
    const std::size_t count = agents.size();
    lay_grid(agents, cell_m);
    const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(cell_rows_);
    begin_.assign(cells + 1, 0);
    cell_of_.resize(count);
    rows_.resize(count);
    for (std::size_t c = 0; c < kSortedColumns; ++c) {
        // Whole lanes may be read beyond the last agent.
        sorted_[c].resize(count + kernels::kLanes, 0.0F);
    }
    team.run(count, kSortGrain, [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i) {
            const int column = clamped_cell((agents.x[i] - low_x_) * per_m_, columns_);
            const int row = clamped_cell((agents.z[i] - low_z_) * per_m_, cell_rows_);
            cell_of_[i] = static_cast<std::uint32_t>(row * columns_ + column);
        }
    });
    for (const std::uint32_t cell : cell_of_) {
        ++begin_[cell + 1];
    }
    for (std::size_t c = 0; c < cells; ++c) {
        begin_[c + 1] += begin_[c];
    }
    // Each cell's begin walks to its end, which is where the next begins: shifted back afterwards.
    for (std::size_t i = 0; i < count; ++i) {
        rows_[begin_[cell_of_[i]]++] = static_cast<std::uint32_t>(i);
    }
    std::copy_backward(begin_.begin(), begin_.end() - 1, begin_.end());
    begin_[0] = 0;
    const std::vector<float>* const from[kSortedColumns] = {&agents.x,
                                                            &agents.z,
                                                            &agents.vx,
                                                            &agents.vz,
                                                            &agents.radius,
                                                            &agents.yield,
                                                            &agents.path_left,
                                                            &agents.want_x,
                                                            &agents.want_z,
                                                            &agents.most_speed};
    team.run(count, kSortGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = 0; c < kSortedColumns; ++c) {
            for (std::size_t i = first; i < last; ++i) {
                sorted_[c][i] = (*from[c])[rows_[i]];
            }
        }
    });
    make_batches();
}

/// Batches do not cross rows: the cells around one that did would be two rows of the whole grid.
void CrowdOrder::make_batches() {
    batches_.clear();
    for (int row = 0; row < cell_rows_; ++row) {
        const auto [first, end] = stretch(row, 0, columns_ - 1);
        for (std::uint32_t i = first; i < end; i += kernels::kLanes) {
            const std::uint32_t stop = std::min<std::uint32_t>(end, i + kernels::kLanes);
            const auto left = static_cast<int>(cell_of_[rows_[i]]) - row * columns_;
            const auto right = static_cast<int>(cell_of_[rows_[stop - 1]]) - row * columns_;
            batches_.push_back({i, stop, left, right, row});
        }
    }
}

}  // namespace zoned::ai::steering
