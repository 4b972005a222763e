#include "server/spatial/octree.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::spatial {

namespace {

/// Signs of the eight octants along each axis; bit i of an octant is set on the upper side of axis
/// i.
Array8 sign_along(int axis) {
    Array8 sign;
    for (int octant = 0; octant < 8; ++octant) {
        sign[octant] = ((octant >> axis) & 1) != 0 ? 1.0F : -1.0F;
    }
    return sign;
}

const std::array<Array8, 3> kSigns{sign_along(0), sign_along(1), sign_along(2)};

}  // namespace

Octree::Octree(const OctreeSettings& settings) : settings_(settings) {
    ZONED_ASSERT(settings.max_depth >= 1 && settings.max_depth <= 30, "max_depth out of range");
    ZONED_ASSERT(settings.boxes_per_cell >= 1 && settings.boxes_per_cell <= 1000,
                 "boxes_per_cell out of range");
}

void Octree::reserve(std::size_t boxes) {
    nodes_.reserve(boxes + 64);
    free_nodes_.reserve(boxes + 64);
    if (entries_.size() < boxes) {
        entries_.resize(boxes);
    }
}

float Octree::longest_side(const Aabb& box) const {
    const Vec3 sides = box.upper - box.lower;
    return settings_.flat ? std::max(sides.x(), sides.z()) : sides.maxCoeff();
}

/// Whether the box may lie in the cell: small enough and with its middle inside.
bool Octree::holds(const OctreeNode& node, const Aabb& box) const {
    const Vec3 off = (0.5F * (box.lower + box.upper) - node.middle).cwiseAbs();
    const bool inside =
        off.x() <= node.half && off.z() <= node.half && (settings_.flat || off.y() <= node.half);
    return inside && longest_side(box) <= 2.0F * node.half;
}

std::size_t Octree::octant_of(const OctreeNode& node, const Aabb& box) const {
    const Vec3 middle = 0.5F * (box.lower + box.upper);
    return (middle.x() > node.middle.x() ? 1U : 0U) |
           (!settings_.flat && middle.y() > node.middle.y() ? 2U : 0U) |
           (middle.z() > node.middle.z() ? 4U : 0U);
}

BoxLanes Octree::loose_children(const OctreeNode& node) const {
    BoxLanes boxes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (settings_.flat && axis == 1) {
            boxes.sides[1] = -BoxLanes::kFar;
            boxes.sides[4] = BoxLanes::kFar;
            continue;
        }
        // A little more than twice the cell: middles and sides are rounded.
        const Array8 middle =
            node.middle[static_cast<Eigen::Index>(axis)] + 0.5F * node.half * kSigns[axis];
        const Array8 reach = 1.0001F * node.half + 1.0e-6F * middle.abs();
        boxes.sides[axis] = middle - reach;
        boxes.sides[axis + 3] = middle + reach;
    }
    return boxes;
}

std::uint32_t Octree::new_node(const Vec3& middle, int level, std::uint32_t parent) {
    auto index = static_cast<std::uint32_t>(nodes_.size());
    if (free_nodes_.empty()) {
        nodes_.emplace_back();
    } else {
        index = free_nodes_.back();
        free_nodes_.pop_back();
        nodes_[index] = OctreeNode();
    }
    OctreeNode& node = nodes_[index];
    node.middle = middle;
    node.half = std::ldexp(1.0F, level);
    node.level = static_cast<std::int8_t>(level);
    node.parent = parent;
    return index;
}

std::uint32_t Octree::child_of(std::uint32_t index, std::size_t octant) {
    const OctreeNode node = nodes_[index];
    if ((node.children >> octant & 1U) != 0) {
        return node.child[octant];
    }
    Vec3 middle = node.middle;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(settings_.flat && axis == 1)) {
            middle[axis] += (octant >> axis & 1U) != 0 ? 0.5F * node.half : -0.5F * node.half;
        }
    }
    const std::uint32_t child = new_node(middle, node.level - 1, index);
    nodes_[index].child[octant] = child;
    nodes_[index].children = static_cast<std::uint8_t>(node.children | (1U << octant));
    return child;
}

/// Doubles the world until the root can hold the box.
void Octree::grow_root(const Aabb& box) {
    if (root_ == kNone) {
        int level = 0;
        while (level < kMaxLevel - 1 && std::ldexp(2.0F, level) < longest_side(box)) {
            ++level;
        }
        // On a lattice of its own size, so that the first box does not decide on roundings.
        const float size = std::ldexp(2.0F, level);
        const Vec3 middle = 0.5F * (box.lower + box.upper);
        const Vec3 corner = (middle / size).array().floor() * size;
        root_ = new_node(corner + Vec3::Constant(0.5F * size), level, kNone);
    }
    while (!holds(nodes_[root_], box) && nodes_[root_].level < kMaxLevel - 1) {
        const OctreeNode old = nodes_[root_];
        // Away from the side where the box is not.
        const std::size_t towards = octant_of(old, box);
        Vec3 middle = old.middle;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(settings_.flat && axis == 1)) {
                middle[axis] += (towards >> axis & 1U) != 0 ? old.half : -old.half;
            }
        }
        const std::uint32_t grown = new_node(middle, old.level + 1, kNone);
        OctreeNode& node = nodes_[grown];
        std::size_t octant = 7U & ~towards;
        if (settings_.flat) {
            octant &= 5U;
        }
        node.child[octant] = root_;
        node.children = static_cast<std::uint8_t>(1U << octant);
        node.split = true;
        node.total = old.total;
        nodes_[root_].parent = grown;
        root_ = grown;
    }
}

/// The cell below `index` that the box belongs to; it is made where it was missing.
std::uint32_t Octree::descend(std::uint32_t index, const Aabb& box) {
    const float side = longest_side(box);
    while (nodes_[index].split && side <= nodes_[index].half) {
        index = child_of(index, octant_of(nodes_[index], box));
    }
    return index;
}

void Octree::link(std::uint32_t row, std::uint32_t index) {
    OctreeEntry& entry = entries_[row];
    OctreeNode& node = nodes_[index];
    entry.node = index;
    entry.previous = kNone;
    entry.next = node.first;
    if (node.first != kNone) {
        entries_[node.first].previous = row;
    }
    node.first = row;
    ++node.own;
}

void Octree::unlink(std::uint32_t row) {
    const OctreeEntry& entry = entries_[row];
    (entry.previous == kNone ? nodes_[entry.node].first : entries_[entry.previous].next) =
        entry.next;
    if (entry.next != kNone) {
        entries_[entry.next].previous = entry.previous;
    }
    --nodes_[entry.node].own;
}

/// Puts a box into the cell below `start` that it belongs to, and splits that when it is crowded.
void Octree::add(std::uint32_t row, std::uint32_t start) {
    const std::uint32_t index = descend(start, entries_[row].box);
    link(row, index);
    for (std::uint32_t i = index; i != kNone; i = nodes_[i].parent) {
        ++nodes_[i].total;
    }
    const OctreeNode& node = nodes_[index];
    const int floor = nodes_[root_].level - settings_.max_depth;
    if (!node.split && node.own > static_cast<std::uint32_t>(settings_.boxes_per_cell) &&
        node.level > floor && node.level > -kMaxLevel) {
        split(index);
    }
}

/// Hands the boxes of a cell that fit into its parts to them.
void Octree::split(std::uint32_t index) {
    nodes_[index].split = true;
    const float half = nodes_[index].half;
    for (std::uint32_t row = nodes_[index].first; row != kNone;) {
        const std::uint32_t next = entries_[row].next;
        if (longest_side(entries_[row].box) <= half) {
            unlink(row);
            const std::uint32_t child =
                child_of(index, octant_of(nodes_[index], entries_[row].box));
            link(row, child);
            ++nodes_[child].total;
        }
        row = next;
    }
}

/// Moves all boxes of a cell and of those below it to another one, and gives the cells up.
void Octree::take_boxes_of(std::uint32_t from, std::uint32_t to) {
    while (nodes_[from].first != kNone) {
        const std::uint32_t row = nodes_[from].first;
        unlink(row);
        link(row, to);
    }
    const OctreeNode node = nodes_[from];
    for_each_lane(node.children, [&](std::size_t lane) { take_boxes_of(node.child[lane], to); });
    nodes_[from].children = 0;
    free_nodes_.push_back(from);
}

void Octree::give_up_parts(std::uint32_t index) {
    const OctreeNode node = nodes_[index];
    for_each_lane(node.children, [&](std::size_t lane) { take_boxes_of(node.child[lane], index); });
    nodes_[index].children = 0;
    nodes_[index].split = false;
}

/// Takes a box out of its cell; the highest cell above that holds few boxes gives up its parts.
void Octree::withdraw(std::uint32_t row) {
    std::uint32_t index = entries_[row].node;
    unlink(row);
    entries_[row].node = kNone;
    std::uint32_t sparse = kNone;
    for (; index != kNone; index = nodes_[index].parent) {
        --nodes_[index].total;
        if (nodes_[index].split &&
            2 * nodes_[index].total <= static_cast<std::uint32_t>(settings_.boxes_per_cell)) {
            sparse = index;
        }
    }
    if (sparse != kNone) {
        give_up_parts(sparse);
    }
}

void Octree::insert(std::uint32_t row, const Aabb& box) {
    if (row >= entries_.size()) {
        entries_.resize(row + 1);
    }
    ZONED_ASSERT(entries_[row].node == kNone, "a box was inserted twice");
    entries_[row].box = box;
    grow_root(box);
    add(row, root_);
    ++size_;
}

void Octree::remove(std::uint32_t row) {
    ZONED_ASSERT(contains(row), "the box is not there");
    withdraw(row);
    if (--size_ == 0) {
        free_nodes_.clear();
        nodes_.clear();
        root_ = kNone;
    }
}

void Octree::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    for (const std::uint32_t row : rows) {
        ZONED_ASSERT(contains(row), "the box is not there");
        OctreeEntry& entry = entries_[row];
        const OctreeNode& node = nodes_[entry.node];
        const Aabb& box = boxes[row];
        const bool stays = holds(node, box) && !(node.split && longest_side(box) <= node.half);
        entry.box = box;
        if (!stays) {
            withdraw(row);
            grow_root(box);
            add(row, root_);
        }
    }
}

}  // namespace zoned::spatial
