// SortAndSweep: boxes sorted along one axis, kept sorted as they move.
#pragma once

#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// Boxes lie in the order of their lower ends along the axis in which they are spread most (Baraff,
/// PhD thesis, Cornell 1992, section 3.2; Ericson, Real-Time Collision Detection, section 7.5). The
/// order of the last step is nearly that of the next, so that insertion sort takes linear time.
///
/// A query looks at the run of boxes whose intervals may overlap its own, eight at a time. The
/// farthest upper end of all boxes so far gives the begin of the run. Boxes that come one at a time
/// wait unsorted at the end of the list until they are many.
class SortAndSweep {
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

    /// Along which axis boxes are sorted: 0, 1 or 2.
    [[nodiscard]] int axis() const { return axis_; }

    /// Calls visit(row, box) for all boxes.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (const SweepBlock& block : blocks_) {
            for_each_lane(block.valid, [&](std::size_t lane) {
                visit(block.rows[lane], block.boxes.get(lane));
            });
        }
    }

    /// Calls visit(row) once for each box that overlaps `box` (touching counts).
    template <class Visit>
    void query(const Aabb& box, Visit&& visit) const {
        for_each_block(box.lower[axis_], box.upper[axis_], [&](const SweepBlock& block) {
            for_each_lane(block.boxes.overlapping(box) & block.valid,
                          [&](std::size_t lane) { visit(block.rows[lane]); });
        });
    }

    /// Calls visit(row, limit) for boxes that the sweep may meet within `limit` metres; visit
    /// returns the new limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float cast(const Sweep& sweep, float limit, Visit&& visit) const {
        const SweepLanes lanes(sweep);
        Array8 enter;
        const float from = sweep.origin[axis_];
        // A sweep across the axis stays where it is, however far it goes.
        const float along = sweep.direction[axis_];
        const float to = along != 0.0F ? from + along * limit : from;
        const float rounding = 1.0e-6F * (std::abs(from) + std::min(std::abs(to), 1.0e6F));
        const float half = sweep.half_extents[axis_] + rounding;
        for_each_block(
            std::min(from, to) - half, std::max(from, to) + half, [&](const SweepBlock& b) {
                const std::uint32_t mask = b.boxes.met_by(lanes, limit, enter) & b.valid;
                for_each_lane(mask, [&](std::size_t lane) {
                    if (enter[static_cast<Eigen::Index>(lane)] <= limit) {
                        limit = visit(b.rows[lane], limit);
                    }
                });
            });
        return limit;
    }

    /// Calls visit(row, limit) for boxes within `limit` metres of the point; visit returns the new
    /// limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float nearest(const Vec3& point, float limit, Visit&& visit) const {
        const float at = point[axis_];
        const float reach = limit + 1.0e-5F * std::abs(at);
        for_each_block(at - reach, at + reach, [&](const SweepBlock& b) {
            const Array8 squared = b.boxes.squared_distance(point);
            for_each_lane(b.valid, [&](std::size_t lane) {
                if (limit >= 0.0F && squared[static_cast<Eigen::Index>(lane)] <= limit * limit) {
                    limit = visit(b.rows[lane], limit);
                }
            });
        });
        return limit;
    }

    /// All of it: the order of visits depends on its history.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(blocks_, first_lower_, reach_, order_, boxes_, place_of_);
        archive(axis_, size_, end_, restless_);
    }

    /// Whether all numbers name places that there are and rows below `rows`.
    [[nodiscard]] bool is_sound(std::size_t rows) const {
        const std::size_t places = blocks_.size() * kLanes;
        bool sound = axis_ >= 0 && axis_ < 3 && size_ <= rows && end_ <= places &&
                     reach_.size() <= blocks_.size() && first_lower_.size() == reach_.size();
        for (const SweepBlock& block : blocks_) {
            sound = sound && block.valid < (1U << kLanes);
            for_each_lane(block.valid & 0xFFU, [&](std::size_t lane) {
                sound = sound && block.rows[lane] < boxes_.size() && block.rows[lane] < rows;
            });
        }
        for (const SweepKey& key : order_) {
            sound = sound && (key.row == kNone || key.row < boxes_.size());
        }
        for (const std::uint32_t place : place_of_) {
            sound = sound && (place == kNone || place < places);
        }
        return sound && place_of_.size() <= boxes_.size();
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    struct SweepBlock {
        BoxLanes boxes;
        std::array<std::uint32_t, kLanes> rows{};
        std::uint32_t valid = 0;
    };

    struct SweepKey {
        float lower = 0.0F;
        std::uint32_t row = kNone;

        bool operator<(const SweepKey& other) const {
            return lower != other.lower ? lower < other.lower : row < other.row;
        }
    };

    /// Calls visit(block) for all blocks that may hold boxes that reach into [lower, upper].
    template <class Visit>
    void for_each_block(float lower, float upper, Visit&& visit) const {
        const auto first = std::lower_bound(reach_.begin(), reach_.end(), lower);
        for (auto i = static_cast<std::size_t>(first - reach_.begin());
             i < reach_.size() && first_lower_[i] <= upper;
             ++i) {
            visit(blocks_[i]);
        }
        for (std::size_t i = reach_.size(); i < blocks_.size(); ++i) {
            visit(blocks_[i]);
        }
    }

    void append(std::uint32_t row);
    void drop(std::uint32_t row);
    void settle();
    void choose_axis();
    void sort_order();
    void write_blocks();

    std::vector<SweepBlock> blocks_;       // sorted ones, then those of boxes that wait
    std::vector<float> first_lower_;       // of each sorted block: its least lower end
    std::vector<float> reach_;             // of each sorted block: the farthest upper end up to it
    std::vector<SweepKey> order_;          // boxes by lower end, when they were last sorted
    std::vector<Aabb> boxes_;              // by row
    std::vector<std::uint32_t> place_of_;  // by row
    int axis_ = 0;
    std::uint32_t size_ = 0;
    std::uint32_t end_ = 0;       // places in use and gaps
    std::uint32_t restless_ = 0;  // gaps, and boxes that wait
};

}  // namespace zoned::spatial
