// Octree: a loose octree of boxes that grows at the root and splits where it is crowded; flat, it
// is a quadtree.
#pragma once

#include "server/spatial/box_lanes.h"
#include "server/spatial/ranked.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

struct OctreeSettings {
    int max_depth = 16;       ///< levels below the root, 1..30
    int boxes_per_cell = 16;  ///< a cell with more of them splits, 1..1000
    bool flat = false;        ///< a quadtree over x and z; boxes still differ along y
};

/// Each box lies in one cell. A cell takes boxes whose middle it holds and whose longest side is at
/// most its own. So it reaches half its size beyond itself and no box is ever cut (Ulrich, "Loose
/// octrees", Game Programming Gems, 2000). Cells split when they hold too many, and boxes that fit
/// into the parts go down; when few are left, the parts are given up.
///
/// Order of visits depends on the history of calls only. No allocation after reserve() unless boxes
/// crowd into ever more cells.
class Octree {
  public:
    explicit Octree(const OctreeSettings& settings = OctreeSettings());

    /// Makes room for `boxes` boxes with rows below `boxes`.
    void reserve(std::size_t boxes);

    /// The row must not be there yet. Boxes are finite, lower <= upper.
    void insert(std::uint32_t row, const Aabb& box);
    void remove(std::uint32_t row);
    /// Gives the rows, which must be there, new boxes: `boxes[row]`.
    void update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes);

    [[nodiscard]] std::uint32_t size() const { return size_; }

    [[nodiscard]] bool contains(std::uint32_t row) const {
        return row < entries_.size() && entries_[row].node != kNone;
    }

    /// How many cells there are, for tests and reports.
    [[nodiscard]] std::size_t cells() const { return nodes_.size() - free_nodes_.size(); }

    /// Calls visit(row, box) for all boxes, by row.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (std::uint32_t row = 0; row < entries_.size(); ++row) {
            if (entries_[row].node != kNone) {
                visit(row, entries_[row].box);
            }
        }
    }

    /// Calls visit(row) once for each box that overlaps `box` (touching counts).
    template <class Visit>
    void query(const Aabb& box, Visit&& visit) const;

    /// Calls visit(row, limit) for boxes that the sweep may meet within `limit` metres, nearer ones
    /// mostly first; visit returns the new limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float cast(const Sweep& sweep, float limit, Visit&& visit) const;

    /// Calls visit(row, limit) for boxes within `limit` metres of the point, nearer ones mostly
    /// first; visit returns the new limit, less than zero to stop. Returns the last limit.
    template <class Visit>
    float nearest(const Vec3& point, float limit, Visit&& visit) const;

    /// All of it: the order of visits depends on its history.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(nodes_, free_nodes_, entries_, root_, size_);
    }

    /// Whether all links lead to nodes and entries that there are, from cells to smaller ones.
    [[nodiscard]] bool is_sound(std::size_t rows) const {
        const auto node_here = [this](std::uint32_t node) {
            return node == kNone || node < nodes_.size();
        };
        const auto entry_here = [this](std::uint32_t entry) {
            return entry == kNone || entry < entries_.size();
        };
        bool sound = node_here(root_) && size_ <= rows;
        for (const OctreeNode& node : nodes_) {
            sound = sound && entry_here(node.first) && node_here(node.parent) &&
                    node.level >= -kMaxLevel && node.level <= kMaxLevel;
            for (std::size_t lane = 0; sound && lane < kLanes; ++lane) {
                sound = (node.children >> lane & 1U) == 0 ||
                        (node.child[lane] < nodes_.size() &&
                         nodes_[node.child[lane]].level < node.level);
            }
        }
        for (const OctreeEntry& entry : entries_) {
            sound = sound && node_here(entry.node) && entry_here(entry.next) &&
                    entry_here(entry.previous);
        }
        for (const std::uint32_t node : free_nodes_) {
            sound = sound && node < nodes_.size();
        }
        return sound;
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    /// Cells are halved and doubled between 2^-40 m and 2^40 m.
    static constexpr int kMaxLevel = 40;
    static constexpr std::size_t kMaxStack = 2 * kMaxLevel * (kLanes - 1) + kLanes;

    struct OctreeNode {
        Vec3 middle = Vec3::Zero();
        float half = 1.0F;  ///< of the cell's edge
        std::array<std::uint32_t, kLanes> child{};
        std::uint32_t parent = kNone;
        std::uint32_t first = kNone;  ///< of its own boxes
        std::uint32_t own = 0;        ///< how many those are
        std::uint32_t total = 0;      ///< with those of the cells below
        std::uint8_t children = 0;    ///< mask
        std::int8_t level = 0;        ///< half is 2^level
        bool split = false;           ///< small boxes go to the children
    };

    struct OctreeEntry {
        Aabb box;
        std::uint32_t node = kNone;
        std::uint32_t next = kNone;
        std::uint32_t previous = kNone;
    };

    [[nodiscard]] float longest_side(const Aabb& box) const;
    [[nodiscard]] bool holds(const OctreeNode& node, const Aabb& box) const;
    [[nodiscard]] std::size_t octant_of(const OctreeNode& node, const Aabb& box) const;
    /// The loose boxes of a node's eight possible children.
    [[nodiscard]] BoxLanes loose_children(const OctreeNode& node) const;

    std::uint32_t new_node(const Vec3& middle, int level, std::uint32_t parent);
    std::uint32_t child_of(std::uint32_t index, std::size_t octant);
    void grow_root(const Aabb& box);
    [[nodiscard]] std::uint32_t descend(std::uint32_t index, const Aabb& box);
    void link(std::uint32_t row, std::uint32_t index);
    void unlink(std::uint32_t row);
    void add(std::uint32_t row, std::uint32_t start);
    void split(std::uint32_t index);
    void give_up_parts(std::uint32_t index);
    void take_boxes_of(std::uint32_t from, std::uint32_t to);
    void withdraw(std::uint32_t row);

    OctreeSettings settings_;
    std::vector<OctreeNode> nodes_;
    std::vector<std::uint32_t> free_nodes_;
    std::vector<OctreeEntry> entries_;  // by row
    std::uint32_t root_ = kNone;
    std::uint32_t size_ = 0;
};

template <class Visit>
void Octree::query(const Aabb& box, Visit&& visit) const {
    if (root_ == kNone) {
        return;
    }
    std::array<std::uint32_t, kMaxStack> stack;
    stack[0] = root_;
    for (std::size_t top = 1; top > 0;) {
        const OctreeNode& node = nodes_[stack[--top]];
        for (std::uint32_t row = node.first; row != kNone; row = entries_[row].next) {
            if (entries_[row].box.overlaps(box)) {
                visit(row);
            }
        }
        if (node.children != 0) {
            for_each_lane(loose_children(node).overlapping(box) & node.children,
                          [&](std::size_t lane) { stack[top++] = node.child[lane]; });
        }
    }
}

template <class Visit>
float Octree::cast(const Sweep& sweep, float limit, Visit&& visit) const {
    if (root_ == kNone) {
        return limit;
    }
    const SweepLanes lanes(sweep);
    std::array<Ranked, kMaxStack> stack;
    stack[0] = {0.0F, root_};
    for (std::size_t top = 1; top > 0;) {
        const Ranked next = stack[--top];
        if (next.distance > limit) {
            continue;
        }
        const OctreeNode& node = nodes_[next.child];
        for (std::uint32_t row = node.first; row != kNone; row = entries_[row].next) {
            if (lanes.meets(entries_[row].box, limit)) {
                limit = visit(row, limit);
            }
        }
        if (limit < 0.0F) {
            return limit;
        }
        if (node.children != 0) {
            Array8 enter;
            const std::uint32_t mask =
                loose_children(node).met_by(lanes, limit, enter) & node.children;
            top = push_ranked(mask, enter, node.child, stack.data(), top);
        }
    }
    return limit;
}

template <class Visit>
float Octree::nearest(const Vec3& point, float limit, Visit&& visit) const {
    if (root_ == kNone) {
        return limit;
    }
    std::array<Ranked, kMaxStack> stack;  // distances are squared here
    stack[0] = {0.0F, root_};
    for (std::size_t top = 1; top > 0;) {
        const Ranked next = stack[--top];
        if (next.distance > limit * limit) {
            continue;
        }
        const OctreeNode& node = nodes_[next.child];
        for (std::uint32_t row = node.first; row != kNone; row = entries_[row].next) {
            if (squared_distance(entries_[row].box, point) <= limit * limit) {
                limit = visit(row, limit);
                if (limit < 0.0F) {
                    return limit;
                }
            }
        }
        if (node.children != 0) {
            const Array8 squared = loose_children(node).squared_distance(point);
            const std::uint32_t mask = lanes_at_most(squared, limit * limit) & node.children;
            top = push_ranked(mask, squared, node.child, stack.data(), top);
        }
    }
    return limit;
}

}  // namespace zoned::spatial
