// IncrementalGrid: a uniform grid over points in the x-z plane; points may move, come and go
// without a rebuild.
#pragma once

#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace zoned::interest {

/// Points and their radii by key (0 .. size - 1). A point without a positive radius is no point.
struct GridPoints {
    std::span<const float> x;  ///< m, finite where the radius is positive
    std::span<const float> z;  ///< likewise
    std::span<const float> radius_m;
};

/// Cells stand in one row of slots, line by line, so that a query reads a few long runs. Eight
/// slots' places share a line of the cache: a query reads such a line and a step writes it. Every
/// fourth cell has a spare slot at first; a cell that is full borrows one from a neighbour, as in a
/// packed memory array (Bender, Demaine and Farach-Colton, "Cache-oblivious B-trees", SIAM Journal
/// on Computing 35, 2005, section 2). Empty slots hold NaN and fail every comparison. The order
/// within a cell depends on the past; nobody may depend on it. It is a grid of its own beside
/// spatial::PointGrid, because that sorts all points anew, which costs more than matching does.
class IncrementalGrid {
  public:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    /// Positions of eight slots: one line of the cache.
    struct alignas(64) GridBlock {
        std::array<float, spatial::kLanes> x;
        std::array<float, spatial::kLanes> z;
    };

    /// Indexes all points afresh, in cells that are `cell_m` > 0 deep and a quarter as wide; they
    /// grow where the extent would need more than 1,048,576 of them.
    void build(const GridPoints& points, float cell_m);

    [[nodiscard]] bool holds(std::uint32_t key) const { return slot_of_[key] != kNone; }

    /// Keys up to `keys` exist, new ones without a point.
    void resize(std::size_t keys) { slot_of_.resize(keys, kNone); }

    /// False where no slot is free nearby: then the grid has to be built anew, and the point is not
    /// in it.
    bool move(std::uint32_t key, float x, float z) {
        const std::uint32_t slot = slot_of_[key];
        GridBlock& block = blocks_[slot / kLanes];
        const std::size_t lane = slot % kLanes;
        if (cell(x, z) == cell(block.x[lane], block.z[lane])) {
            block.x[lane] = x;
            block.z[lane] = z;
            return true;
        }
        return change_cell(key, x, z);
    }

    /// Moves the keys among `keys` that the grid holds to their places in `x` and `z` (by key).
    /// False as in move(): then some are where they were.
    bool move_all(std::span<const std::uint32_t> keys,
                  std::span<const float> x,
                  std::span<const float> z);
    /// False as in move().
    bool put(std::uint32_t key, float x, float z, float radius_m);
    void take(std::uint32_t key);

    [[nodiscard]] float radius_m(std::uint32_t key) const { return radius_[slot_of_[key]]; }

    /// Calls visit(key) for all points, cell by cell.
    template <class Visit>
    void for_each_key(Visit&& visit) const {
        for (std::size_t c = 0; c < counts_.size(); ++c) {
            for (std::uint32_t i = begins_[c]; i < begins_[c] + counts_[c]; ++i) {
                visit(keys_[i]);
            }
        }
    }

    /// Neighbours in the plane have slots near each other.
    [[nodiscard]] std::uint32_t slot(std::uint32_t key) const { return slot_of_[key]; }

    [[nodiscard]] std::size_t slots() const { return keys_.size(); }

    /// Line of cells that a point lies in, from 0.
    [[nodiscard]] std::uint32_t line_of(float z) const {
        return static_cast<std::uint32_t>(line(z));
    }

    /// At most so many of as many points leave their cells when each moves that far, m.
    [[nodiscard]] double leaving(std::size_t points, float step_m) const {
        const double share = static_cast<double>(step_m) * (per_m_x_ + per_m_z_);
        return static_cast<double>(points) * std::min(1.0, share);
    }

    [[nodiscard]] float cell_m() const { return cell_m_; }

    /// True where so many points lie beyond the extent of the last build() that queries suffer.
    [[nodiscard]] bool worn() const { return outside_ > 64 + slot_of_.size() / 16; }

    /// Appends to `out` the keys of all points within min(radius, their radius) x `widen` of (x,
    /// z), except `own`; closed, in the arithmetic of hears(). `out` has room for keys() + 8.
    std::size_t gather(float x,
                       float z,
                       float radius_m,
                       float widen,
                       std::uint32_t own,
                       std::uint32_t* out) const;

    [[nodiscard]] std::size_t keys() const { return slot_of_.size(); }

    /// Calls visit(begin, end) for runs of blocks that together hold all points of a box, closed,
    /// m, and some beyond it; no block twice.
    template <class Visit>
    void for_each_run(float x0, float x1, float z0, float z1, Visit&& visit) const {
        if (counts_.empty()) {
            return;
        }
        const auto first = static_cast<std::size_t>(column(x0));
        const auto past = static_cast<std::size_t>(column(x1)) + 1;
        const auto bottom = static_cast<std::size_t>(line(z0));
        const auto top = static_cast<std::size_t>(line(z1));
        std::uint32_t done = 0;
        for (std::size_t row = bottom * columns_; row <= top * columns_; row += columns_) {
            const std::uint32_t begin = std::max(done, begins_[row + first] / kLanes);
            const std::uint32_t end = (begins_[row + past] + kLanes - 1) / kLanes;
            if (begin < end) {
                visit(begin, end);
                done = end;
            }
        }
    }

    /// True where no point has a radius below this: whose own radius is that small needs no others.
    [[nodiscard]] bool all_reach(float radius_m) const { return radius_m <= smallest_radius_; }

    /// Calls visit(key) for all points near a box (m) that `test` chooses, eight at a time: by
    /// their x, z and, unless kFlat, their radii.
    template <bool kFlat, class Test, class Visit>
    void for_each_chosen(float x0, float x1, float z0, float z1, const Test& test, Visit&& visit)
        const {
        for_each_run(x0, x1, z0, z1, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t b = begin; b < end; ++b) {
                for (std::uint32_t mask = choose<kFlat>(b, test); mask != 0; mask &= mask - 1) {
                    visit(keys_[b * kLanes + static_cast<std::uint32_t>(std::countr_zero(mask))]);
                }
            }
        });
    }

    /// Eight neighbouring slots and which of them are meant, for a question of number `asker`.
    struct Note {
        std::uint32_t asker = 0;
        std::uint32_t block = 0;
        std::uint32_t mask = 0;
    };

    /// As for_each_chosen(), but only writes the choices down, without a branch for each eight;
    /// `out` has room for blocks() + 1 notes. Returns how many.
    template <bool kFlat, class Test>
    std::size_t note_chosen(float x0,
                            float x1,
                            float z0,
                            float z1,
                            const Test& test,
                            std::uint32_t asker,
                            Note* out) const {
        std::size_t found = 0;
        for_each_run(x0, x1, z0, z1, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t b = begin; b < end; ++b) {
                const std::uint32_t mask = choose<kFlat>(b, test);
                out[found] = {asker, b, mask};
                found += mask != 0 ? 1U : 0U;
            }
        });
        return found;
    }

    [[nodiscard]] std::size_t blocks() const { return blocks_.size(); }

    [[nodiscard]] std::uint32_t key_at(std::uint32_t block, std::uint32_t lane) const {
        return keys_[block * kLanes + lane];
    }

    /// Which of the slots of a block `test` chooses; an empty one is never chosen by a comparison
    /// of its place.
    template <bool kFlat, class Test>
    [[nodiscard]] std::uint32_t chosen_of(std::uint32_t block, const Test& test) const {
        return choose<kFlat>(block, test);
    }

    /// Other places of the points, `x` and `z` by key, in the order of the slots; empty slots hold
    /// any number.
    void lay_out(std::span<const float> x,
                 std::span<const float> z,
                 std::vector<GridBlock>& out) const;

    /// Asks for the places that a query for the same box will read soon.
    void prefetch(float x0, float x1, float z0, float z1) const {
        for_each_run(x0, x1, z0, z1, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t b = begin; b < end; ++b) {
                __builtin_prefetch(&blocks_[b]);
            }
        });
    }

    /// Asks for where a point stands; then, once that is there, for its place.
    void prefetch_slot(std::uint32_t key) const { __builtin_prefetch(&slot_of_[key], 1); }

    void prefetch_place(std::uint32_t key) const {
        const std::uint32_t slot = slot_of_[key];
        if (slot != kNone) {
            __builtin_prefetch(&blocks_[slot / kLanes], 1);
            __builtin_prefetch(&radius_[slot], 1);
            __builtin_prefetch(&keys_[slot], 1);
        }
    }

    /// Asks for the keys of a block that will be read soon.
    void prefetch(std::uint32_t block) const { __builtin_prefetch(&keys_[block * kLanes]); }

  private:
    static constexpr std::uint32_t kLanes = static_cast<std::uint32_t>(spatial::kLanes);

    template <bool kFlat, class Test>
    [[gnu::always_inline]] std::uint32_t choose(std::uint32_t b, const Test& test) const {
        const Array8 x = Array8::load(blocks_[b].x.data());
        const Array8 z = Array8::load(blocks_[b].z.data());
        if constexpr (kFlat) {
            return test.flat(x, z);
        } else {
            return test(x, z, Array8::load(&radius_[b * kLanes]));
        }
    }

    template <bool kFlat>
    std::size_t gather_within(float x,
                              float z,
                              float radius_m,
                              float widen,
                              std::uint32_t own,
                              std::uint32_t* out) const;
    bool change_cell(std::uint32_t key, float x, float z);

    float& x_at(std::uint32_t slot) { return blocks_[slot / kLanes].x[slot % kLanes]; }

    float& z_at(std::uint32_t slot) { return blocks_[slot / kLanes].z[slot % kLanes]; }

    [[nodiscard]] int column(float x) const { return place(x, min_x_, per_m_x_, last_column_); }

    [[nodiscard]] int line(float z) const { return place(z, min_z_, per_m_z_, last_line_); }

    /// Monotonic, so that no rounding parts a point from a query that holds it.
    static int place(float at, float origin, float per_m, float last) {
        const float cells = (at - origin) * per_m;
        return static_cast<int>(cells > 0.0F ? (cells < last ? cells : last) : 0.0F);
    }

    [[nodiscard]] std::uint32_t cell(float x, float z) const {
        return static_cast<std::uint32_t>(line(z)) * static_cast<std::uint32_t>(columns_) +
               static_cast<std::uint32_t>(column(x));
    }

    void choose_cells(const GridPoints& points, float cell_m);
    void count_points(const GridPoints& points);
    void fill(const GridPoints& points);
    bool make_room(std::uint32_t cell);
    void move_slot(std::uint32_t from, std::uint32_t to);
    void clear_slot(std::uint32_t slot);

    std::vector<std::uint32_t> begins_;  // first slot of each cell, and one past the end
    std::vector<std::uint32_t> counts_;  // points in each cell; its slots may be more
    std::vector<GridBlock> blocks_;
    std::vector<float> radius_;
    std::vector<std::uint32_t> keys_;
    std::vector<std::uint32_t> slot_of_;  // by key
    std::vector<std::uint32_t> cell_of_;  // by key, scratch of build()
    std::size_t columns_ = 0;
    std::size_t outside_ = 0;       // points put beyond the extent since build()
    float smallest_radius_ = 0.0F;  // of all points that are or were here
    float largest_radius_ = 0.0F;
    float cell_m_ = 0.0F;
    float per_m_x_ = 0.0F;
    float per_m_z_ = 0.0F;
    float min_x_ = 0.0F;
    float min_z_ = 0.0F;
    float max_x_ = 0.0F;
    float max_z_ = 0.0F;
    float last_column_ = 0.0F;
    float last_line_ = 0.0F;
};

}  // namespace zoned::interest
