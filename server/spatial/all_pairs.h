// AllPairs: boxes in no order; every query tests every box, eight at a time.
#pragma once

#include "server/spatial/box_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// Has nothing to keep up to date, so that nothing beats it for some dozens of boxes; and it is too
/// simple to be wrong, so that the other structures are compared with it.
class AllPairs {
  public:
    /// Makes room for `boxes` boxes with rows below `boxes`.
    void reserve(std::size_t boxes);

    /// The row must not be there yet. Boxes are finite, lower <= upper.
    void insert(std::uint32_t row, const Aabb& box);
    void remove(std::uint32_t row);
    /// Gives the rows, which must be there, new boxes: `boxes[row]`.
    void update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes);

    [[nodiscard]] std::uint32_t size() const { return size_; }

    [[nodiscard]] bool contains(std::uint32_t row) const {
        return row < place_of_.size() && place_of_[row] != kNone;
    }

    /// Calls visit(row, box) for all boxes.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (std::uint32_t place = 0; place < size_; ++place) {
            const PairBlock& block = blocks_[place / kLanes];
            visit(block.rows[place % kLanes], block.boxes.get(place % kLanes));
        }
    }

    /// Calls visit(row) once for each box that overlaps `box` (touching counts).
    template <class Visit>
    void query(const Aabb& box, Visit&& visit) const {
        for (const PairBlock& block : blocks_) {
            for_each_lane(block.boxes.overlapping(box) & block.valid,
                          [&](std::size_t lane) { visit(block.rows[lane]); });
        }
    }

    /// Calls visit(row, limit) for boxes that the sweep may meet within `limit` metres; visit
    /// returns the new limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float cast(const Sweep& sweep, float limit, Visit&& visit) const {
        const SweepLanes lanes(sweep);
        Array8 enter;
        for (const PairBlock& block : blocks_) {
            const std::uint32_t mask = block.boxes.met_by(lanes, limit, enter) & block.valid;
            for_each_lane(mask, [&](std::size_t lane) {
                if (enter[static_cast<Eigen::Index>(lane)] <= limit) {
                    limit = visit(block.rows[lane], limit);
                }
            });
        }
        return limit;
    }

    /// Calls visit(row, limit) for boxes within `limit` metres of the point; visit returns the new
    /// limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float nearest(const Vec3& point, float limit, Visit&& visit) const {
        for (const PairBlock& block : blocks_) {
            const Array8 squared = block.boxes.squared_distance(point);
            for_each_lane(block.valid, [&](std::size_t lane) {
                if (limit >= 0.0F && squared[static_cast<Eigen::Index>(lane)] <= limit * limit) {
                    limit = visit(block.rows[lane], limit);
                }
            });
        }
        return limit;
    }

    /// All of it: the order of visits depends on its history.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(blocks_, place_of_, size_);
    }

    /// Whether all numbers name places that there are and rows below `rows`.
    [[nodiscard]] bool is_sound(std::size_t rows) const {
        bool sound = size_ <= rows && size_ <= blocks_.size() * kLanes;
        for (const PairBlock& block : blocks_) {
            for_each_lane(block.valid & 0xFFU,
                          [&](std::size_t lane) { sound = sound && block.rows[lane] < rows; });
            sound = sound && block.valid < (1U << kLanes);
        }
        for (const std::uint32_t place : place_of_) {
            sound = sound && (place == kNone || place < size_);
        }
        return sound;
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    struct PairBlock {
        BoxLanes boxes;
        std::array<std::uint32_t, kLanes> rows{};
        std::uint32_t valid = 0;
    };

    std::vector<PairBlock> blocks_;
    std::vector<std::uint32_t> place_of_;  // by row
    std::uint32_t size_ = 0;
};

}  // namespace zoned::spatial
