// AabbTree: a dynamic tree of bounding boxes, eight to a node.
#pragma once

#include "server/spatial/box_lanes.h"
#include "server/spatial/ranked.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// A node holds the boxes of up to eight children side by side, so that one wide test decides on
/// all of them, and the tree is a third as high as a binary one. All boxes lie at the same depth.
///
/// - One box is inserted where it enlarges the surfaces of the nodes least; a node that overflows
///   is split where the surface area heuristic wants it (Guttman, "R-trees", SIGMOD 1984; Goldsmith
///   and Salmon, "Automatic creation of object hierarchies for ray tracing", 1987).
/// - Boxes that move are written in place and the nodes above them fitted again, all at once; a box
///   that left its node is taken out and inserted anew.
/// - When the surfaces have grown by half since, or as many boxes were inserted as there were, the
///   tree is built afresh from above, which is cheap: about 0.15 us a box.
///
/// Order of visits depends on the history of calls only. No allocation after reserve().
class AabbTree {
  public:
    /// Makes room for `boxes` boxes with rows below `boxes`.
    void reserve(std::size_t boxes);

    /// The row must not be in the tree. Boxes are finite, lower <= upper.
    void insert(std::uint32_t row, const Aabb& box);
    /// The row must be in the tree.
    void remove(std::uint32_t row);
    /// Gives the rows, which must be in the tree, new boxes: `boxes[row]`.
    void update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes);

    [[nodiscard]] std::uint32_t size() const { return size_; }

    [[nodiscard]] bool contains(std::uint32_t row) const {
        return row < slot_of_.size() && slot_of_[row] != kNone;
    }

    /// Calls visit(row, box) for all boxes, by row.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (std::uint32_t row = 0; row < slot_of_.size(); ++row) {
            if (slot_of_[row] != kNone) {
                visit(row, nodes_[slot_of_[row] / kLanes].boxes.get(slot_of_[row] % kLanes));
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

    /// Builds the tree afresh, for the best queries.
    void rebuild();

    /// The sum of half the surfaces of all nodes, m2: the cost of a query grows with it.
    [[nodiscard]] double cost() const;

    /// All of the tree: the order of visits depends on its history.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(nodes_, free_nodes_, slot_of_, root_, size_);
        archive(built_size_, built_cost_, stretch_, changes_);
    }

    /// Whether all links lead to nodes that there are, downwards, and to rows below `rows`: no
    /// query leaves the tree, whatever bytes it was loaded from.
    [[nodiscard]] bool is_sound(std::size_t rows) const;

    /// For tests: whether links, boxes and counts agree with each other.
    [[nodiscard]] bool consistent() const;

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    /// At least two children a node when it is made: 2^20 boxes are at most 20 levels high.
    static constexpr std::size_t kMaxStack = 20 * (kLanes - 1) + kLanes;

    struct alignas(64) AabbTreeNode {
        BoxLanes boxes;
        std::array<std::uint32_t, kLanes> child{};  // rows at level 0, else nodes
        std::uint32_t parent = kNone;               // node * 8 + lane
        std::uint8_t count = 0;
        std::uint8_t level = 0;
        bool dirty = false;

        [[nodiscard]] std::uint32_t valid() const { return (1U << count) - 1; }
    };

    /// A box to be inserted into a node: of a row (level 0) or of a node.
    struct AabbTreeEntry {
        Aabb box;
        std::uint32_t child = kNone;
    };

    // One box at a time, aabb_tree.cpp.
    std::uint32_t new_node(int level);
    void free_node(std::uint32_t index);
    void put(std::uint32_t index, std::size_t lane, const AabbTreeEntry& entry);
    void append(std::uint32_t index, const AabbTreeEntry& entry);
    [[nodiscard]] std::uint32_t choose(const Aabb& box);
    void split(std::uint32_t index, const AabbTreeEntry& entry);
    void erase(std::uint32_t slot);
    void refit_above(std::uint32_t index);
    void insert_unchecked(std::uint32_t row, const Aabb& box);
    void remove_unchecked(std::uint32_t row);

    // Many at once, aabb_tree_batch.cpp.
    void mark_dirty(std::uint32_t index);
    void refit_dirty();
    std::uint32_t build(std::span<AabbTreeEntry> entries, int level);
    void build_children(std::uint32_t index, std::span<AabbTreeEntry> entries, std::size_t slots);

    std::vector<AabbTreeNode> nodes_;
    std::vector<std::uint32_t> free_nodes_;
    std::vector<std::uint32_t> slot_of_;  // by row: node * 8 + lane
    std::uint32_t root_ = kNone;
    std::uint32_t size_ = 0;

    std::uint32_t built_size_ = 0;        // when the tree was last built
    double built_cost_ = 0.0;             // likewise
    double stretch_ = 0.0;                // by how much fitting has changed the cost since
    std::uint32_t changes_ = 0;           // boxes inserted since
    std::vector<AabbTreeEntry> scratch_;  // of rebuild
    std::vector<std::uint32_t> left_;     // rows that left their nodes
    std::array<std::vector<std::uint32_t>, 24> dirty_;  // nodes by level
};

template <class Visit>
void AabbTree::query(const Aabb& box, Visit&& visit) const {
    if (size_ == 0) {
        return;
    }
    std::array<std::uint32_t, kMaxStack> stack;
    stack[0] = root_;
    for (std::size_t top = 1; top > 0;) {
        const AabbTreeNode& node = nodes_[stack[--top]];
        const std::uint32_t mask = node.boxes.overlapping(box) & node.valid();
        if (node.level == 0) {
            for_each_lane(mask, [&](std::size_t lane) { visit(node.child[lane]); });
        } else {
            for_each_lane(mask, [&](std::size_t lane) { stack[top++] = node.child[lane]; });
        }
    }
}

template <class Visit>
float AabbTree::cast(const Sweep& sweep, float limit, Visit&& visit) const {
    if (size_ == 0) {
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
        const AabbTreeNode& node = nodes_[next.child];
        Array8 enter;
        const std::uint32_t mask = node.boxes.met_by(lanes, limit, enter) & node.valid();
        const std::size_t end = push_ranked(mask, enter, node.child, stack.data(), top);
        if (node.level != 0) {
            top = end;
            continue;
        }
        for (std::size_t i = end; i > top; --i) {
            if (stack[i - 1].distance <= limit) {
                limit = visit(stack[i - 1].child, limit);
            }
        }
        if (limit < 0.0F) {
            return limit;
        }
    }
    return limit;
}

template <class Visit>
float AabbTree::nearest(const Vec3& point, float limit, Visit&& visit) const {
    if (size_ == 0) {
        return limit;
    }
    std::array<Ranked, kMaxStack> stack;  // distances are squared here
    stack[0] = {0.0F, root_};
    for (std::size_t top = 1; top > 0;) {
        const Ranked next = stack[--top];
        if (next.distance > limit * limit) {
            continue;
        }
        const AabbTreeNode& node = nodes_[next.child];
        const Array8 squared = node.boxes.squared_distance(point);
        const std::uint32_t mask = lanes_at_most(squared, limit * limit) & node.valid();
        const std::size_t end = push_ranked(mask, squared, node.child, stack.data(), top);
        if (node.level != 0) {
            top = end;
            continue;
        }
        for (std::size_t i = end; i > top; --i) {
            if (stack[i - 1].distance <= limit * limit) {
                limit = visit(stack[i - 1].child, limit);
                if (limit < 0.0F) {
                    return limit;
                }
            }
        }
    }
    return limit;
}

}  // namespace zoned::spatial
