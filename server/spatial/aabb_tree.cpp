#include "server/spatial/aabb_tree.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::spatial {

namespace {

/// A tree that was built with so few boxes is not worth a rebuild.
constexpr std::uint32_t kSmall = 64;
/// At least this many of nine children go to either half.
constexpr std::size_t kLeastPart = 3;
constexpr std::size_t kOverfull = kLanes + 1;

/// How nine entries part: the first `left` of `order` go left.
struct Parting {
    std::array<std::uint8_t, kOverfull> order{};
    std::size_t left = 0;
    float cost = std::numeric_limits<float>::infinity();
};

template <class Entries>
void part_along(const Entries& entries, int axis, Parting& best) {
    Parting p;
    std::array<float, kOverfull> middle{};
    for (std::size_t i = 0; i < kOverfull; ++i) {
        middle[i] = entries[i].box.lower[axis] + entries[i].box.upper[axis];
        std::size_t k = i;
        for (; k > 0 && middle[p.order[k - 1]] > middle[i]; --k) {
            p.order[k] = p.order[k - 1];
        }
        p.order[k] = static_cast<std::uint8_t>(i);
    }
    std::array<float, kOverfull> area_from{};  // of the entries from the i-th on
    Aabb box = entries[p.order[kOverfull - 1]].box;
    for (std::size_t i = kOverfull - 1; i > 0; --i) {
        box = merged(box, entries[p.order[i]].box);
        area_from[i] = half_area(box);
    }
    box = entries[p.order[0]].box;
    for (std::size_t left = 1; left <= kOverfull - kLeastPart; ++left) {
        box = merged(box, entries[p.order[left - 1]].box);
        p.left = left;
        p.cost = half_area(box) * static_cast<float>(left) +
                 area_from[left] * static_cast<float>(kOverfull - left);
        if (left >= kLeastPart && p.cost < best.cost) {
            best = p;
        }
    }
}

}  // namespace

void AabbTree::reserve(std::size_t boxes) {
    // A split leaves three children or more; nodes that lose more than that are rare.
    nodes_.reserve(boxes / 2 + 16);
    free_nodes_.reserve(boxes / 2 + 16);
    if (slot_of_.size() < boxes) {
        slot_of_.resize(boxes, kNone);
    }
    scratch_.reserve(boxes);
    left_.reserve(boxes);
    for (auto& list : dirty_) {
        list.reserve(&list == &dirty_[0] ? boxes / 2 + 16 : boxes / 4 + 16);
    }
}

std::uint32_t AabbTree::new_node(int level) {
    auto index = static_cast<std::uint32_t>(nodes_.size());
    if (free_nodes_.empty()) {
        nodes_.emplace_back();
    } else {
        index = free_nodes_.back();
        free_nodes_.pop_back();
        nodes_[index] = AabbTreeNode();
    }
    nodes_[index].level = static_cast<std::uint8_t>(level);
    return index;
}

void AabbTree::free_node(std::uint32_t index) {
    nodes_[index].count = 0;
    free_nodes_.push_back(index);
}

void AabbTree::put(std::uint32_t index, std::size_t lane, const AabbTreeEntry& entry) {
    AabbTreeNode& node = nodes_[index];
    node.boxes.set(lane, entry.box);
    node.child[lane] = entry.child;
    const auto slot = static_cast<std::uint32_t>(index * kLanes + lane);
    (node.level == 0 ? slot_of_[entry.child] : nodes_[entry.child].parent) = slot;
}

void AabbTree::append(std::uint32_t index, const AabbTreeEntry& entry) {
    put(index, nodes_[index].count++, entry);
}

/// Goes down to the node at level 0 that grows least by taking the box in. Grows the boxes that it
/// passes.
std::uint32_t AabbTree::choose(const Aabb& box) {
    std::uint32_t index = root_;
    while (nodes_[index].level > 0) {
        AabbTreeNode& node = nodes_[index];
        const auto& s = node.boxes.sides;
        const Array8 x = s[3] - s[0];
        const Array8 y = s[4] - s[1];
        const Array8 z = s[5] - s[2];
        const Array8 old_area = x * y + y * z + z * x;
        const Array8 wide = s[3].max(box.upper.x()) - s[0].min(box.lower.x());
        const Array8 high = s[4].max(box.upper.y()) - s[1].min(box.lower.y());
        const Array8 deep = s[5].max(box.upper.z()) - s[2].min(box.lower.z());
        const Array8 growth = wide * high + high * deep + deep * wide - old_area;
        std::size_t best = 0;
        for (std::size_t lane = 1; lane < node.count; ++lane) {
            const auto i = static_cast<Eigen::Index>(lane);
            const auto b = static_cast<Eigen::Index>(best);
            if (growth[i] < growth[b] || (growth[i] == growth[b] && old_area[i] < old_area[b])) {
                best = lane;
            }
        }
        node.boxes.set(best, merged(node.boxes.get(best), box));
        index = node.child[best];
    }
    return index;
}

/// Parts the eight children of a node and one more into two nodes, and tells the nodes above.
void AabbTree::split(std::uint32_t index, const AabbTreeEntry& entry) {
    std::array<AabbTreeEntry, kOverfull> entries;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        entries[lane] = {nodes_[index].boxes.get(lane), nodes_[index].child[lane]};
    }
    entries[kLanes] = entry;
    Parting best;
    for (int axis = 0; axis < 3; ++axis) {
        part_along(entries, axis, best);
    }
    if (best.left == 0) {
        // Surfaces that overflow compare with nothing: any parting serves.
        best.left = kOverfull / 2;
        for (std::size_t i = 0; i < kOverfull; ++i) {
            best.order[i] = static_cast<std::uint8_t>(i);
        }
    }
    const std::uint32_t other = new_node(nodes_[index].level);
    const std::uint32_t parent = nodes_[index].parent;
    nodes_[index].boxes = BoxLanes();
    nodes_[index].count = 0;
    for (std::size_t i = 0; i < kOverfull; ++i) {
        append(i < best.left ? index : other, entries[best.order[i]]);
    }
    const AabbTreeEntry right{nodes_[other].boxes.bounds(), other};
    if (parent == kNone) {
        const int level = nodes_[index].level + 1;
        root_ = new_node(level);
        append(root_, {nodes_[index].boxes.bounds(), index});
        append(root_, right);
        return;
    }
    const std::uint32_t above = parent / kLanes;
    nodes_[above].boxes.set(parent % kLanes, nodes_[index].boxes.bounds());
    if (nodes_[above].count < kLanes) {
        append(above, right);
    } else {
        split(above, right);
    }
}

void AabbTree::insert_unchecked(std::uint32_t row, const Aabb& box) {
    if (root_ == kNone) {
        root_ = new_node(0);
    }
    const std::uint32_t leaf = choose(box);
    if (nodes_[leaf].count < kLanes) {
        append(leaf, {box, row});
    } else {
        split(leaf, {box, row});
    }
    ++size_;
    ++changes_;
}

void AabbTree::insert(std::uint32_t row, const Aabb& box) {
    if (row >= slot_of_.size()) {
        slot_of_.resize(row + 1, kNone);
    }
    ZONED_ASSERT(slot_of_[row] == kNone, "a box was inserted twice");
    insert_unchecked(row, box);
    if (changes_ > kSmall && changes_ > built_size_) {
        rebuild();
    }
}

/// Takes the child in a slot out of its node; nodes that become empty go too.
void AabbTree::erase(std::uint32_t slot) {
    const std::uint32_t index = slot / kLanes;
    const std::size_t lane = slot % kLanes;
    AabbTreeNode& node = nodes_[index];
    const std::size_t last = --node.count;
    if (node.count == 0) {
        const std::uint32_t parent = node.parent;
        free_node(index);
        if (parent == kNone) {
            root_ = kNone;
        } else {
            erase(parent);
        }
        return;
    }
    if (lane != last) {
        put(index, lane, {node.boxes.get(last), node.child[last]});
    }
    node.boxes.clear(last);
    refit_above(index);
}

/// Fits the boxes above a node to its children.
void AabbTree::refit_above(std::uint32_t index) {
    while (nodes_[index].parent != kNone) {
        const std::uint32_t parent = nodes_[index].parent;
        const Aabb box = nodes_[index].boxes.bounds();
        const Aabb old = nodes_[parent / kLanes].boxes.get(parent % kLanes);
        if (box.lower == old.lower && box.upper == old.upper) {
            return;
        }
        nodes_[parent / kLanes].boxes.set(parent % kLanes, box);
        index = parent / kLanes;
    }
}

void AabbTree::remove_unchecked(std::uint32_t row) {
    erase(slot_of_[row]);
    slot_of_[row] = kNone;
    --size_;
    while (root_ != kNone && nodes_[root_].level > 0 && nodes_[root_].count == 1) {
        const std::uint32_t only = nodes_[root_].child[0];
        free_node(root_);
        root_ = only;
        nodes_[root_].parent = kNone;
    }
}

void AabbTree::remove(std::uint32_t row) {
    ZONED_ASSERT(contains(row), "the box is not in the tree");
    remove_unchecked(row);
}

double AabbTree::cost() const {
    double cost = 0.0;
    for (const AabbTreeNode& node : nodes_) {
        if (node.count > 0) {
            cost += half_area(node.boxes.bounds());
        }
    }
    return cost;
}

bool AabbTree::consistent() const {
    std::uint32_t rows = 0;
    for (std::uint32_t index = 0; index < nodes_.size(); ++index) {
        const AabbTreeNode& node = nodes_[index];
        if (node.dirty || (node.count > 0 && (node.parent == kNone) != (index == root_))) {
            return false;
        }
        for (std::size_t lane = 0; lane < node.count; ++lane) {
            const auto slot = static_cast<std::uint32_t>(index * kLanes + lane);
            if (node.level == 0) {
                ++rows;
                if (slot_of_[node.child[lane]] != slot) {
                    return false;
                }
                continue;
            }
            const AabbTreeNode& child = nodes_[node.child[lane]];
            const Aabb box = child.boxes.bounds();
            const Aabb known = node.boxes.get(lane);
            if (child.parent != slot || child.level + 1 != node.level || child.count == 0 ||
                box.lower != known.lower || box.upper != known.upper) {
                return false;
            }
        }
    }
    return rows == size_ && (size_ > 0) == (root_ != kNone);
}

bool AabbTree::is_sound(std::size_t rows) const {
    const std::size_t slots = nodes_.size() * kLanes;
    bool sound = (size_ == 0 || root_ < nodes_.size()) && size_ <= rows;
    for (const AabbTreeNode& node : nodes_) {
        sound = sound && node.count <= kLanes && node.level < 20 && !node.dirty &&
                (node.parent == kNone || node.parent < slots);
        for (std::size_t lane = 0; sound && lane < node.count; ++lane) {
            const std::uint32_t child = node.child[lane];
            sound = node.level == 0
                        ? child < rows
                        : child < nodes_.size() && nodes_[child].level + 1 == node.level;
        }
    }
    for (const std::uint32_t slot : slot_of_) {
        sound = sound && (slot == kNone || slot < slots);
    }
    for (const std::uint32_t index : free_nodes_) {
        sound = sound && index < nodes_.size();
    }
    return sound;
}

}  // namespace zoned::spatial
