// BoxIndex: one of the structures over boxes, chosen at run time.
#pragma once

#include "server/spatial/aabb_tree.h"
#include "server/spatial/all_pairs.h"
#include "server/spatial/box_grid.h"
#include "server/spatial/broadphase_kind.h"
#include "server/spatial/octree.h"
#include "server/spatial/sort_and_sweep.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>

namespace zoned::spatial {

/// The boxes by place and by row. All kinds answer alike but for the order of visits: a caller that
/// needs an order independent of the kind sorts the answer. Queries may come from several threads
/// at once as long as nobody changes anything.
class BoxIndex {
  public:
    /// `kind` is not kAutomatic: see choose_kind.
    BoxIndex(BroadphaseKind kind, const BroadphaseSettings& settings);

    [[nodiscard]] BroadphaseKind kind() const { return kind_; }

    /// Moves all boxes over to another structure, which gets room for `boxes`.
    void change_to(BroadphaseKind kind, std::size_t boxes);

    /// Makes room for `boxes` boxes with rows below `boxes`.
    void reserve(std::size_t boxes);
    /// The row must not be there yet. Boxes are finite, lower <= upper.
    void insert(std::uint32_t row, const Aabb& box);
    void remove(std::uint32_t row);
    /// Gives the rows, which must be there, new boxes: `boxes[row]`.
    void update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes);
    [[nodiscard]] std::uint32_t size() const;

    /// Calls visit(row) once for each box that overlaps `box` (touching counts).
    template <class Visit>
    void query(const Aabb& box, Visit&& visit) const {
        std::visit([&](const auto& boxes) { boxes.query(box, visit); }, boxes_);
    }

    /// For each of the rows: visit(row, other) for each `other` whose box overlaps `boxes[row]`.
    template <class Visit>
    void query_each(std::span<const std::uint32_t> rows,
                    std::span<const Aabb> boxes,
                    Visit&& visit) const {
        std::visit(
            [&](const auto& structure) {
                for (const std::uint32_t row : rows) {
                    structure.query(boxes[row], [&](std::uint32_t other) { visit(row, other); });
                }
            },
            boxes_);
    }

    /// Calls visit(row, limit) for boxes that the sweep may meet within `limit` metres; visit
    /// returns the new limit, less than zero to stop. A row may come more than once. Returns the
    /// last limit.
    template <class Visit>
    float cast(const Sweep& sweep, float limit, Visit&& visit) const {
        return std::visit([&](const auto& boxes) { return boxes.cast(sweep, limit, visit); },
                          boxes_);
    }

    /// Calls visit(row, limit) for boxes within `limit` metres of the point; visit returns the new
    /// limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float nearest(const Vec3& point, float limit, Visit&& visit) const {
        return std::visit([&](const auto& boxes) { return boxes.nearest(point, limit, visit); },
                          boxes_);
    }

    /// The structure as it is, with its kind.
    template <class Archive>
    void serialize(Archive& archive) {
        BroadphaseKind kind = kind_;
        archive(kind);
        if constexpr (Archive::kReads) {
            if (kind == BroadphaseKind::kAutomatic || kind > BroadphaseKind::kTree) {
                archive.fail("boxes are in a structure that there is not");
                return;
            }
            kind_ = kind;
            boxes_ = make(kind, settings_);
        }
        std::visit([&](auto& boxes) { archive(boxes); }, boxes_);
    }

    /// Whether no call leaves the structure, whatever bytes it was loaded from.
    [[nodiscard]] bool is_sound(std::size_t rows) const {
        return std::visit([rows](const auto& boxes) { return boxes.is_sound(rows); }, boxes_);
    }

  private:
    using Structure = std::variant<AllPairs, BoxGrid, Octree, SortAndSweep, AabbTree>;

    static Structure make(BroadphaseKind kind, const BroadphaseSettings& settings);

    BroadphaseKind kind_;
    BroadphaseSettings settings_;
    Structure boxes_;
};

}  // namespace zoned::spatial
