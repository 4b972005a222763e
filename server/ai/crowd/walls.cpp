#include "server/ai/crowd/walls.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace zoned::ai::steering {

namespace {

constexpr float kCellsOfPiece = 4.0F;

bool within_bounds(const Wall& w) {
    const float all[] = {w.ax, w.az, w.bx, w.bz};
    return std::all_of(std::begin(all), std::end(all), [](float v) {
        return std::abs(v) <= Walls::kLongest;  // false for a value that is not a number
    });
}

/// Pieces meet in the same numbers, so that there is no gap between them.
void cut(const Wall& w, float longest, std::vector<Wall>& out) {
    const float length = std::max(std::abs(w.bx - w.ax), std::abs(w.bz - w.az));
    const int count = std::max(1, static_cast<int>(std::ceil(length / longest)));
    float x = w.ax;
    float z = w.az;
    for (int i = 1; i <= count; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(count);
        const float to_x = i == count ? w.bx : w.ax + t * (w.bx - w.ax);
        const float to_z = i == count ? w.bz : w.az + t * (w.bz - w.az);
        out.push_back({x, z, to_x, to_z});
        x = to_x;
        z = to_z;
    }
}

}  // namespace

core::Result<Walls> Walls::make(std::span<const Wall> walls, float cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "cells have a size");
    Walls made;
    for (std::size_t i = 0; i < walls.size(); ++i) {
        if (!within_bounds(walls[i])) {
            return core::Result<Walls>::failure(
                "wall " + std::to_string(i) +
                " is not finite or lies more than 100 km from the origin");
        }
        cut(walls[i], std::max(kCellsOfPiece * cell_m, kLongest * 1e-4F), made.pieces_);
    }
    if (!made.pieces_.empty()) {
        made.lay_cells(cell_m);
        made.fill_cells();
    }
    return made;
}

void Walls::lay_cells(float cell_m) {
    float high_x = -kLongest;
    float high_z = -kLongest;
    low_x_ = kLongest;
    low_z_ = kLongest;
    for (const Wall& w : pieces_) {
        low_x_ = std::min({low_x_, w.ax, w.bx});
        low_z_ = std::min({low_z_, w.az, w.bz});
        high_x = std::max({high_x, w.ax, w.bx});
        high_z = std::max({high_z, w.az, w.bz});
    }
    const double width = static_cast<double>(high_x) - static_cast<double>(low_x_);
    const double depth = static_cast<double>(high_z) - static_cast<double>(low_z_);
    double size = cell_m;
    while ((std::floor(width / size) + 1.0) * (std::floor(depth / size) + 1.0) >
           static_cast<double>(kMostCells)) {
        size *= 2.0;
    }
    per_m_ = static_cast<float>(1.0 / size);
    columns_ = static_cast<int>(width / size) + 1;
    rows_ = static_cast<int>(depth / size) + 1;
}

void Walls::fill_cells() {
    const auto cells_of = [this](std::uint32_t i, const auto& take) {
        const Wall& w = pieces_[i];
        for (int z = row(std::min(w.az, w.bz)); z <= row(std::max(w.az, w.bz)); ++z) {
            for (int x = column(std::min(w.ax, w.bx)); x <= column(std::max(w.ax, w.bx)); ++x) {
                take(static_cast<std::size_t>(z * columns_ + x));
            }
        }
    };
    inside_.build(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                  static_cast<std::uint32_t>(pieces_.size()),
                  cells_of);
}

}  // namespace zoned::ai::steering
