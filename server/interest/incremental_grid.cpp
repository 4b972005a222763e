// build: hot loops
#include "server/interest/incremental_grid.h"

#include "server/interest/compress_lanes.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cstring>

namespace zoned::interest {

namespace {

// Runs are read as a whole: cells may be narrow where lines are few.
constexpr double kWidths = 4.0;
constexpr std::size_t kSpareEvery = 4;
// A crowd that one of so many joins is no reason to build the grid anew.
constexpr std::uint32_t kSpareShare = 16;
constexpr double kMostCells = 1048576.0;
// A cell looks this far for a free slot, in cells, before the grid is built anew.
constexpr std::uint32_t kBorrowCells = 64;
constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

}  // namespace

void IncrementalGrid::choose_cells(const GridPoints& points, float cell_m) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const std::size_t size = points.x.size();
    Array8 low_x = kInfinity, high_x = -low_x, low_z = low_x, high_z = -low_x;
    Array8 low_r = low_x, high_r = 0.0F;
    std::size_t i = 0;
    for (; i + kLanes <= size; i += kLanes) {
        const Array8 x = Array8::load(points.x.data() + i);
        const Array8 z = Array8::load(points.z.data() + i);
        const Array8 radius = Array8::load(points.radius_m.data() + i);
        const auto there = radius > 0.0F;
        low_x = there.select(low_x.min(x), low_x);
        high_x = there.select(high_x.max(x), high_x);
        low_z = there.select(low_z.min(z), low_z);
        high_z = there.select(high_z.max(z), high_z);
        low_r = there.select(low_r.min(radius), low_r);
        high_r = high_r.max(radius);
    }
    min_x_ = low_x.lowest();
    max_x_ = high_x.highest();
    min_z_ = low_z.lowest();
    max_z_ = high_z.highest();
    smallest_radius_ = low_r.lowest();
    largest_radius_ = high_r.highest();
    for (; i < size; ++i) {
        if (points.radius_m[i] > 0.0F) {
            min_x_ = std::min(min_x_, points.x[i]);
            max_x_ = std::max(max_x_, points.x[i]);
            min_z_ = std::min(min_z_, points.z[i]);
            max_z_ = std::max(max_z_, points.z[i]);
            smallest_radius_ = std::min(smallest_radius_, points.radius_m[i]);
            largest_radius_ = std::max(largest_radius_, points.radius_m[i]);
        }
    }
    if (!(max_x_ >= min_x_)) {
        min_x_ = max_x_ = min_z_ = max_z_ = 0.0F;
    }
    double cell = cell_m;
    const double width = static_cast<double>(max_x_) - min_x_;
    const double depth = static_cast<double>(max_z_) - min_z_;
    while ((std::floor(width / cell * kWidths) + 1.0) * (std::floor(depth / cell) + 1.0) >
           kMostCells) {
        cell *= 2.0;
    }
    cell_m_ = cell_m;
    per_m_x_ = static_cast<float>(kWidths / cell);
    per_m_z_ = static_cast<float>(1.0 / cell);
    columns_ = static_cast<std::size_t>(width / cell * kWidths) + 1;
    last_column_ = static_cast<float>(columns_ - 1);
    last_line_ = static_cast<float>(static_cast<int>(depth / cell));
    outside_ = 0;
}

/// Cell of each key and how many points each cell holds.
void IncrementalGrid::count_points(const GridPoints& points) {
    const std::size_t size = points.x.size();
    const std::size_t cells = columns_ * (static_cast<std::size_t>(last_line_) + 1);
    counts_.assign(cells + 1, 0);  // the last one takes those that are no point
    cell_of_.resize(size);
    std::size_t i = 0;
    for (; i + kLanes <= size; i += kLanes) {
        using Int8 = Array8::Integers;
        const Array8 radius = Array8::load(points.radius_m.data() + i);
        // An entity that is no point may be nowhere, which no cell has a number for.
        const Array8 x = (radius > 0.0F).select(Array8::load(points.x.data() + i), min_x_);
        const Array8 z = (radius > 0.0F).select(Array8::load(points.z.data() + i), min_z_);
        // Nothing lies outside here, so that only roundings need the clamp at the upper end.
        const Int8 cx = ((x - min_x_) * per_m_x_).min(last_column_).truncated();
        const Int8 cz = ((z - min_z_) * per_m_z_).min(last_line_).truncated();
        const Int8 at = cz * static_cast<std::int32_t>(columns_) + cx;
        const Int8 none = Int8{} + static_cast<std::int32_t>(cells);
        const Int8 cells_of = (radius > 0.0F).select(at, none);
        std::memcpy(cell_of_.data() + i, &cells_of, sizeof(cells_of));
    }
    for (; i < size; ++i) {
        cell_of_[i] = points.radius_m[i] > 0.0F ? cell(points.x[i], points.z[i])
                                                : static_cast<std::uint32_t>(cells);
    }
    for (const std::uint32_t c : cell_of_) {
        ++counts_[c];
    }
    counts_.pop_back();
}

void IncrementalGrid::fill(const GridPoints& points) {
    const bool alike = smallest_radius_ == largest_radius_;
    if (alike) {
        std::fill(radius_.begin(), radius_.end(), largest_radius_);
    }
    for (std::size_t key = 0; key < points.x.size(); ++key) {
        const std::uint32_t c = cell_of_[key];
        if (c >= counts_.size()) {
            slot_of_[key] = kNone;
            continue;
        }
        const std::uint32_t slot = begins_[c] + counts_[c]++;
        slot_of_[key] = slot;
        keys_[slot] = static_cast<std::uint32_t>(key);
        x_at(slot) = points.x[key];
        z_at(slot) = points.z[key];
        if (!alike) {
            radius_[slot] = points.radius_m[key];
        }
    }
}

void IncrementalGrid::build(const GridPoints& points, float cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "a cell has a size");
    choose_cells(points, cell_m);
    count_points(points);
    const std::size_t cells = counts_.size();
    begins_.resize(cells + 1);
    std::uint32_t slots = 0;
    for (std::size_t c = 0; c < cells; ++c) {
        begins_[c] = slots;
        slots += counts_[c] + counts_[c] / kSpareShare + (c % kSpareEvery == 0 ? 1 : 0);
        counts_[c] = 0;
    }
    begins_[cells] = slots;
    const std::uint32_t padded = (slots + kLanes - 1) / kLanes * kLanes;
    blocks_.resize(padded / kLanes);
    radius_.resize(padded);
    keys_.resize(padded);
    slot_of_.resize(points.x.size());
    fill(points);
    for (std::size_t c = 0; c < cells; ++c) {
        for (std::uint32_t slot = begins_[c] + counts_[c]; slot < begins_[c + 1]; ++slot) {
            clear_slot(slot);
        }
    }
    for (std::uint32_t slot = slots; slot < padded; ++slot) {
        clear_slot(slot);
    }
}

// ---------------------------------------------------------------- following

void IncrementalGrid::move_slot(std::uint32_t from, std::uint32_t to) {
    x_at(to) = x_at(from);
    z_at(to) = z_at(from);
    radius_[to] = radius_[from];
    keys_[to] = keys_[from];
    slot_of_[keys_[to]] = to;
}

void IncrementalGrid::clear_slot(std::uint32_t slot) {
    x_at(slot) = z_at(slot) = kNoNumber;
    radius_[slot] = 0.0F;
}

/// Borders between cells move by a slot until the free one is in `wanted`.
bool IncrementalGrid::make_room(std::uint32_t wanted) {
    const auto free = [&](std::uint32_t c) {
        return begins_[c] + counts_[c] < begins_[c + 1];
    };
    const auto cells = static_cast<std::uint32_t>(counts_.size());
    for (std::uint32_t away = 0; away <= kBorrowCells; ++away) {
        if (wanted + away < cells && free(wanted + away)) {
            for (std::uint32_t c = wanted + away; c > wanted; --c) {
                const std::uint32_t first = begins_[c]++;
                if (counts_[c] > 0) {
                    move_slot(first, first + counts_[c]);
                }
                clear_slot(first);
            }
            return true;
        }
        if (away <= wanted && free(wanted - away)) {
            for (std::uint32_t c = wanted - away + 1; c <= wanted; ++c) {
                const std::uint32_t first = --begins_[c];
                if (counts_[c] > 0) {
                    move_slot(first + counts_[c], first);
                }
                clear_slot(first + counts_[c]);
            }
            return true;
        }
    }
    return false;
}

bool IncrementalGrid::put(std::uint32_t key, float x, float z, float radius_m) {
    if (counts_.empty()) {
        return false;
    }
    const std::uint32_t c = cell(x, z);
    if (!make_room(c)) {
        return false;
    }
    outside_ += x < min_x_ || x > max_x_ || z < min_z_ || z > max_z_ ? std::size_t{1} : 0;
    smallest_radius_ = std::min(smallest_radius_, radius_m);
    const std::uint32_t slot = begins_[c] + counts_[c]++;
    x_at(slot) = x;
    z_at(slot) = z;
    radius_[slot] = radius_m;
    keys_[slot] = key;
    slot_of_[key] = slot;
    return true;
}

void IncrementalGrid::take(std::uint32_t key) {
    const std::uint32_t slot = slot_of_[key];
    const std::uint32_t c = cell(x_at(slot), z_at(slot));
    const std::uint32_t last = begins_[c] + --counts_[c];
    slot_of_[key] = kNone;
    if (slot != last) {
        move_slot(last, slot);
    }
    clear_slot(last);
}

bool IncrementalGrid::change_cell(std::uint32_t key, float x, float z) {
    const float radius_m = radius_[slot_of_[key]];
    take(key);
    return put(key, x, z, radius_m);
}

bool IncrementalGrid::move_all(std::span<const std::uint32_t> keys,
                               std::span<const float> x,
                               std::span<const float> z) {
    constexpr std::size_t kAhead = 12;
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (i + kAhead < keys.size()) {
            const std::uint32_t soon = slot_of_[keys[i + kAhead]];
            __builtin_prefetch(&blocks_[soon == kNone ? 0 : soon / kLanes], 1);
        }
        const std::uint32_t key = keys[i];
        if (slot_of_[key] != kNone && !move(key, x[key], z[key])) {
            return false;
        }
    }
    return true;
}

// ---------------------------------------------------------------- asking

void IncrementalGrid::lay_out(std::span<const float> x,
                              std::span<const float> z,
                              std::vector<GridBlock>& out) const {
    out.resize(blocks_.size());
    if (x.empty()) {
        return;
    }
    // The former key of an empty slot may be no key any more.
    const auto last = static_cast<std::uint32_t>(x.size() - 1);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        for (std::size_t i = 0; i < kLanes; ++i) {
            const std::uint32_t key = std::min(keys_[b * kLanes + i], last);
            out[b].x[i] = x[key];
            out[b].z[i] = z[key];
        }
    }
}

template <bool kFlat>
std::size_t IncrementalGrid::gather_within(float x,
                                           float z,
                                           float radius_m,
                                           float widen,
                                           std::uint32_t own,
                                           std::uint32_t* out) const {
    // The differences below are rounded: a point may count as within the radius that lies a
    // rounding outside of it, in the next cell.
    const float reach = radius_m * widen * 1.0001F;
    const float reach_x = reach + 1e-6F * std::abs(x);
    const float reach_z = reach + 1e-6F * std::abs(z);
    const std::uint32_t own_slot = slot_of_[own];
    const float widest = radius_m * widen;
    const Array8 flat = widest * widest;
    std::size_t found = 0;
    const auto take_run = [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t b = begin; b < end; ++b) {
            const Array8 dx = Array8::load(blocks_[b].x.data()) - x;
            const Array8 dz = Array8::load(blocks_[b].z.data()) - z;
            std::uint32_t mask = 0;
            if constexpr (kFlat) {
                mask = spatial::lanes_at_most(dx * dx + dz * dz, flat);
            } else {
                const Array8 r = Array8::load(&radius_[b * kLanes]).min(radius_m) * widen;
                mask = spatial::lanes_at_most(dx * dx + dz * dz, r * r);
            }
            const std::uint32_t off = own_slot - b * kLanes;
            mask &= ~static_cast<std::uint32_t>(std::uint64_t{1} << std::min(off, 32U));
            compress_store(&keys_[b * kLanes], mask, out + found);
            found += static_cast<std::size_t>(std::popcount(mask));
        }
    };
    for_each_run(x - reach_x, x + reach_x, z - reach_z, z + reach_z, take_run);
    return found;
}

std::size_t IncrementalGrid::gather(float x,
                                    float z,
                                    float radius_m,
                                    float widen,
                                    std::uint32_t own,
                                    std::uint32_t* out) const {
    return all_reach(radius_m) ? gather_within<true>(x, z, radius_m, widen, own, out)
                               : gather_within<false>(x, z, radius_m, widen, own, out);
}

}  // namespace zoned::interest
