// BoxGrid: uniform grids of doubling cell size; each box is in the grid whose cells fit it.
#pragma once

#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// One uniform grid serves boxes of one size well and a 300 m slab badly: it would lie in thousands
/// of cells. So there is a stack of uniform grids (Ericson, Real-Time Collision Detection, 2005,
/// section 7.2.1). A box goes to the finest level whose cells are at least as long as its longest
/// side, where it lies in at most 2 x 2 x 2 cells. Levels share one hash table; levels that are
/// empty cost nothing.
///
/// A query visits each overlapping box once and needs no marks for it. Of the cells that two boxes
/// share, only the one that holds the lower corner of their intersection reports the pair. It is a
/// grid of its own beside PointGrid, because boxes lie in several cells and in three dimensions.
class BoxGrid {
  public:
    /// `cell_m` is the cell size of one of the levels; the others are it times powers of two.
    explicit BoxGrid(float cell_m);

    /// Makes room for `boxes` boxes with rows below `boxes`, so that they move about without
    /// allocation.
    void reserve(std::size_t boxes);

    /// Rows below `rows` are taken without allocation, by as many boxes as reserve() said.
    void reserve_rows(std::size_t rows) { entries_.reserve(rows); }

    /// The row must not be there yet. Boxes are finite, lower <= upper.
    void insert(std::uint32_t row, const Aabb& box);
    void remove(std::uint32_t row);
    /// Gives the rows, which must be there, new boxes: `boxes[row]`.
    void update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes);

    [[nodiscard]] std::uint32_t size() const { return size_; }

    [[nodiscard]] bool contains(std::uint32_t row) const {
        return row < entries_.size() && entries_[row].level >= 0;
    }

    /// Calls visit(row, box) for all boxes, by row.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (std::uint32_t row = 0; row < entries_.size(); ++row) {
            if (entries_[row].level >= 0) {
                visit(row, entries_[row].box);
            }
        }
    }

    /// Calls visit(row) once for each box that overlaps `box` (touching counts), in an order that
    /// depends on the history of calls only.
    template <class Visit>
    void query(const Aabb& box, Visit&& visit) const;

    /// Calls visit(row, limit) for boxes that the sweep may meet within `limit` metres; visit
    /// returns the new limit, less than zero to stop. A row may come more than once. Returns the
    /// last limit.
    template <class Visit>
    float cast(const Sweep& sweep, float limit, Visit&& visit) const;

    /// Calls visit(row, limit) for boxes within `limit` metres of the point, nearer ones mostly
    /// first; visit returns the new limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float nearest(const Vec3& point, float limit, Visit&& visit) const;

    /// All of it: the order of visits depends on its history.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(levels_, entries_, nodes_, free_node_, keys_, heads_, mask_, used_, size_);
        archive(reserved_cells_);
    }

    /// Whether all links lead to nodes and entries that there are.
    [[nodiscard]] bool is_sound(std::size_t rows) const {
        const auto here = [this](std::uint32_t node) {
            return node == kNone || node < nodes_.size();
        };
        bool sound = here(free_node_) && size_ <= rows && keys_.size() == heads_.size() &&
                     (keys_.empty() ? mask_ == 0 : mask_ + 1 == keys_.size()) &&
                     std::has_single_bit(keys_.size() | (keys_.empty() ? 1U : 0U)) &&
                     (keys_.empty() || used_ < keys_.size());
        for (const std::uint32_t head : heads_) {
            sound = sound && here(head);
        }
        for (const BoxGridNode& node : nodes_) {
            sound = sound && (node.row == kNone || node.row < entries_.size()) && here(node.next) &&
                    here(node.previous) && here(node.sibling);
        }
        for (const BoxGridEntry& entry : entries_) {
            sound = sound && entry.level < kLevels && here(entry.first_node);
        }
        for (const BoxGridLevel& level : levels_) {
            for (const std::uint32_t row : level.rows) {
                sound = sound && row < entries_.size();
            }
        }
        return sound && entries_.size() <= std::max<std::size_t>(64, 2 * rows);
    }

  private:
    static constexpr int kLevels = 24;
    static constexpr int kFinestExponent = -3;  // of the cell size relative to cell_m
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    static constexpr std::uint64_t kEmptyKey = ~std::uint64_t{0};

    struct BoxGridCell {
        std::array<std::int32_t, 3> at{};
        bool operator==(const BoxGridCell&) const = default;
    };

    struct BoxGridEntry {
        Aabb box;
        BoxGridCell lower, upper;    // range of cells, inclusive
        std::int32_t level = -1;     // -1: not in the grid
        std::uint32_t position = 0;  // in levels_[level].rows
        std::uint32_t first_node = kNone;
    };

    struct BoxGridLevel {
        float cell = 1.0F;
        float inv_cell = 1.0F;
        std::vector<std::uint32_t> rows;
    };

    struct BoxGridNode {
        std::uint32_t row = kNone;
        std::uint32_t next = kNone;  // of the cell
        std::uint32_t previous = kNone;
        std::uint32_t sibling = kNone;  // of the box, in the next of its cells
    };

    [[nodiscard]] BoxGridCell cell_of(const BoxGridLevel& level, const Vec3& point) const {
        BoxGridCell cell;
        for (std::size_t i = 0; i < 3; ++i) {
            const float scaled = point[static_cast<int>(i)] * level.inv_cell;
            cell.at[i] = static_cast<std::int32_t>(std::floor(std::clamp(scaled, -1.0e9F, 1.0e9F)));
        }
        return cell;
    }

    static std::uint64_t key_of(int level, const BoxGridCell& cell) {
        // 19 bits per axis: far apart cells may share a key, which costs a test and no error,
        // because boxes are compared in the end.
        constexpr std::uint64_t kMask = (1U << 19) - 1;
        return (static_cast<std::uint64_t>(level) << 57) |
               ((static_cast<std::uint64_t>(cell.at[0]) & kMask) << 38) |
               ((static_cast<std::uint64_t>(cell.at[1]) & kMask) << 19) |
               (static_cast<std::uint64_t>(cell.at[2]) & kMask);
    }

    static std::uint64_t scatter(std::uint64_t key) {
        key *= 0x9E3779B97F4A7C15ull;
        return key ^ (key >> 32);
    }

    [[nodiscard]] std::uint32_t find_head(std::uint64_t key) const {
        for (std::size_t slot = scatter(key) & mask_;; slot = (slot + 1) & mask_) {
            if (keys_[slot] == key) {
                return heads_[slot];
            }
            if (keys_[slot] == kEmptyKey) {
                return kNone;
            }
        }
    }

    [[nodiscard]] int level_for(const Aabb& box) const;
    std::size_t slot_for(std::uint64_t key);
    void rehash();

    /// Calls visit(cell) for each cell that a box covers.
    template <class Visit>
    static void for_each_cell(const BoxGridEntry& entry, Visit&& visit) {
        BoxGridCell at;
        for (at.at[0] = entry.lower.at[0]; at.at[0] <= entry.upper.at[0]; ++at.at[0]) {
            for (at.at[1] = entry.lower.at[1]; at.at[1] <= entry.upper.at[1]; ++at.at[1]) {
                for (at.at[2] = entry.lower.at[2]; at.at[2] <= entry.upper.at[2]; ++at.at[2]) {
                    visit(at);
                }
            }
        }
    }

    void link(std::uint32_t row);
    void unlink(std::uint32_t row);
    template <class Visit>
    void query_level(const BoxGridLevel& level, int index, const Aabb& box, Visit&& visit) const;
    template <class Visit>
    float walk_ray(int index, const Sweep& sweep, float limit, Visit&& visit) const;
    template <class Visit>
    float walk_sweep(const BoxGridLevel& level,
                     int index,
                     const Sweep& sweep,
                     float limit,
                     Visit&& visit) const;
    void update_one(std::uint32_t row, const Aabb& box);

    std::array<BoxGridLevel, kLevels> levels_;
    std::vector<BoxGridEntry> entries_;  // by row
    std::vector<BoxGridNode> nodes_;
    std::uint32_t free_node_ = kNone;
    std::vector<std::uint64_t> keys_, spare_keys_;
    std::vector<std::uint32_t> heads_, spare_heads_;
    std::size_t mask_ = 0;
    std::size_t used_ = 0;  // slots with a key, cells that became empty included
    std::size_t reserved_cells_ = 0;
    std::uint32_t size_ = 0;
};

template <class Visit>
void BoxGrid::query_level(const BoxGridLevel& level,
                          int index,
                          const Aabb& box,
                          Visit&& visit) const {
    const BoxGridCell lower = cell_of(level, box.lower);
    const BoxGridCell upper = cell_of(level, box.upper);
    double cells = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        cells *= static_cast<double>(upper.at[i]) - lower.at[i] + 1.0;
    }
    if (cells >= static_cast<double>(level.rows.size())) {
        for (const std::uint32_t row : level.rows) {
            if (entries_[row].box.overlaps(box)) {
                visit(row);
            }
        }
        return;
    }
    BoxGridCell at;
    for (at.at[0] = lower.at[0]; at.at[0] <= upper.at[0]; ++at.at[0]) {
        for (at.at[1] = lower.at[1]; at.at[1] <= upper.at[1]; ++at.at[1]) {
            for (at.at[2] = lower.at[2]; at.at[2] <= upper.at[2]; ++at.at[2]) {
                for (std::uint32_t n = find_head(key_of(index, at)); n != kNone;
                     n = nodes_[n].next) {
                    const BoxGridEntry& entry = entries_[nodes_[n].row];
                    if (!entry.box.overlaps(box)) {
                        continue;
                    }
                    const bool reports = at.at[0] == std::max(lower.at[0], entry.lower.at[0]) &&
                                         at.at[1] == std::max(lower.at[1], entry.lower.at[1]) &&
                                         at.at[2] == std::max(lower.at[2], entry.lower.at[2]);
                    if (reports) {
                        visit(nodes_[n].row);
                    }
                }
            }
        }
    }
}

template <class Visit>
void BoxGrid::query(const Aabb& box, Visit&& visit) const {
    for (int index = 0; index < kLevels; ++index) {
        const BoxGridLevel& level = levels_[static_cast<std::size_t>(index)];
        if (!level.rows.empty()) {
            query_level(level, index, box, visit);
        }
    }
}

/// Walks the grid cell by cell along a ray (Amanatides and Woo, "A fast voxel traversal algorithm
/// for ray tracing", Eurographics 1987).
template <class Visit>
float BoxGrid::walk_ray(int index, const Sweep& ray, float limit, Visit&& visit) const {
    const BoxGridLevel& level = levels_[static_cast<std::size_t>(index)];
    BoxGridCell at = cell_of(level, ray.origin);
    std::array<std::int32_t, 3> step{};
    std::array<float, 3> next{};
    std::array<float, 3> delta{};
    for (std::size_t i = 0; i < 3; ++i) {
        const float d = ray.direction[static_cast<int>(i)];
        const float o = ray.origin[static_cast<int>(i)];
        step[i] = d > 0.0F ? 1 : -1;
        const auto edge = static_cast<float>(at.at[i] + (d > 0.0F ? 1 : 0)) * level.cell;
        next[i] = d != 0.0F ? (edge - o) / d : INFINITY;
        delta[i] = d != 0.0F ? level.cell / std::abs(d) : INFINITY;
    }
    for (float entered = 0.0F; entered <= limit;) {
        for (std::uint32_t n = find_head(key_of(index, at)); n != kNone; n = nodes_[n].next) {
            limit = visit(nodes_[n].row, limit);
        }
        const std::size_t axis = next[0] <= next[1] && next[0] <= next[2] ? 0
                                 : next[1] <= next[2]                     ? 1
                                                                          : 2;
        entered = next[axis];
        next[axis] += delta[axis];
        at.at[axis] += step[axis];
    }
    return limit;
}

/// Piece by piece along the path of a box.
template <class Visit>
float BoxGrid::walk_sweep(const BoxGridLevel& level,
                          int index,
                          const Sweep& sweep,
                          float limit,
                          Visit&& visit) const {
    const float piece = level.cell;
    for (float from = 0.0F; from <= limit; from += piece) {
        const Vec3 a = sweep.origin + from * sweep.direction;
        const Vec3 b = a + piece * sweep.direction;
        // A little more than the piece: its ends are rounded.
        const Vec3 reach =
            sweep.half_extents + 1.0e-6F * (a.cwiseAbs() + b.cwiseAbs() + sweep.half_extents);
        query_level(
            level, index, {a.cwiseMin(b) - reach, a.cwiseMax(b) + reach}, [&](std::uint32_t row) {
                limit = visit(row, limit);
            });
    }
    return limit;
}

template <class Visit>
float BoxGrid::cast(const Sweep& sweep, float limit, Visit&& visit) const {
    const SweepLanes lanes(sweep);
    const auto test = [&](std::uint32_t row, float current) -> float {
        return lanes.meets(entries_[row].box, current) ? visit(row, current) : current;
    };
    for (int index = 0; index < kLevels; ++index) {
        const BoxGridLevel& level = levels_[static_cast<std::size_t>(index)];
        const double pieces = static_cast<double>(limit) * level.inv_cell + 2.0;
        const Vec3 span = 2.0F * level.inv_cell * sweep.half_extents + Vec3::Constant(3.0F);
        const bool ray = sweep.half_extents.isZero(0.0F);
        const double cells = pieces * (ray ? 3.0 : static_cast<double>(span.prod()));
        // A path through more cells than the level has boxes: the boxes are the shorter list.
        if (!(cells < static_cast<double>(level.rows.size()))) {
            for (const std::uint32_t row : level.rows) {
                limit = test(row, limit);
            }
        } else if (ray) {
            limit = walk_ray(index, sweep, limit, test);
        } else {
            limit = walk_sweep(level, index, sweep, limit, test);
        }
    }
    return limit;
}

/// Looks in boxes about the point that double until they reach as far as asked or hold all.
template <class Visit>
float BoxGrid::nearest(const Vec3& point, float limit, Visit&& visit) const {
    float searched = -1.0F;  // squared
    std::uint32_t seen = 0;
    for (float reach = levels_[-kFinestExponent].cell; limit >= 0.0F && seen < size_;
         reach *= 2.0F) {
        const float radius = std::min(reach, limit);
        const float outer = radius * radius;
        const float room = radius + 1.0e-6F * (radius + point.cwiseAbs().maxCoeff());
        query(Aabb{point, point}.grown(room), [&](std::uint32_t row) {
            const float squared = squared_distance(entries_[row].box, point);
            if (squared > searched && squared <= outer) {
                ++seen;
                if (squared <= limit * limit) {
                    limit = visit(row, limit);
                }
            }
        });
        searched = outer;
        if (radius >= limit) {
            break;
        }
    }
    return limit;
}

}  // namespace zoned::spatial
