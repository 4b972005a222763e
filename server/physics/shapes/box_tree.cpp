#include "server/physics/shapes/box_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

namespace zoned::physics {

namespace {

constexpr std::uint32_t kLeafItems = 4;
constexpr std::size_t kBins = 12;

Aabb join(const Aabb& a, const Aabb& b) {
    return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

Aabb nothing() {
    return {Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
}

float half_area(const Aabb& box) {
    const Vec3 d = box.upper - box.lower;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

/// Twice the centre.
Vec3 middle(const Aabb& box) {
    return box.lower + box.upper;
}

struct Bin {
    Aabb box = nothing();
    std::uint32_t items = 0;
};

/// Index of the last bin of the left side with the least cost: area times items of both sides.
std::size_t cheapest_cut(const std::array<Bin, kBins>& bins) {
    std::array<float, kBins> right_cost{};
    Aabb box = nothing();
    std::uint32_t items = 0;
    for (std::size_t i = kBins - 1; i > 0; --i) {
        box = join(box, bins[i].box);
        items += bins[i].items;
        right_cost[i] = items == 0 ? INFINITY : half_area(box) * static_cast<float>(items);
    }
    box = nothing();
    items = 0;
    std::size_t best = 0;
    float least = INFINITY;
    for (std::size_t i = 0; i + 1 < kBins; ++i) {
        box = join(box, bins[i].box);
        items += bins[i].items;
        const float cost =
            items == 0 ? INFINITY : half_area(box) * static_cast<float>(items) + right_cost[i + 1];
        if (cost < least) {
            least = cost;
            best = i;
        }
    }
    return best;
}

/// Whether each of the numbers below `count` is there once.
bool is_order(const std::vector<std::uint32_t>& order, std::size_t count) {
    if (order.size() != count) {
        return false;
    }
    std::vector<bool> seen(count);
    for (const std::uint32_t item : order) {
        if (item >= count || seen[item]) {
            return false;
        }
        seen[item] = true;
    }
    return true;
}

}  // namespace

BoxTree::BoxTree(std::span<const Aabb> boxes) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    if (!boxes.empty()) {
        nodes_.reserve(boxes.size());
        build(boxes, 0, static_cast<std::uint32_t>(boxes.size()), 0);
        fit(boxes);
    }
}

std::size_t BoxTree::depth() const {
    std::size_t deepest = 0;
    std::array<std::size_t, kMaxDepth> waiting{};  // depths of the right children to come
    std::size_t height = 0;
    std::size_t depth = 1;
    for (const BoxTreeNode& node : nodes_) {
        deepest = std::max(deepest, depth);
        if (node.items == 0) {
            waiting[height++] = ++depth;
        } else if (height > 0) {
            depth = waiting[--height];
        }
    }
    return deepest;
}

bool BoxTree::same_as(const BoxTree& other) const {
    static_assert(sizeof(BoxTreeNode) == 32, "nodes are compared byte by byte: no padding");
    return order_ == other.order_ && nodes_.size() == other.nodes_.size() &&
           (nodes_.empty() ||
            std::memcmp(nodes_.data(), other.nodes_.data(), nodes_.size() * sizeof(BoxTreeNode)) ==
                0);
}

BoxTree::Layout BoxTree::layout() const {
    Layout out;
    out.nodes.reserve(nodes_.size());
    for (const BoxTreeNode& node : nodes_) {
        out.nodes.push_back(static_cast<std::uint8_t>(node.items));
    }
    out.order = order_;
    return out;
}

core::Result<BoxTree> BoxTree::restore(Layout layout, std::span<const Aabb> boxes) {
    using Restored = core::Result<BoxTree>;
    BoxTree tree;
    if (!is_order(layout.order, boxes.size())) {
        return Restored::failure("tree: its order is none of all items");
    }
    tree.order_ = std::move(layout.order);
    tree.nodes_.reserve(layout.nodes.size());

    struct Waiting {
        std::size_t parent, depth;  // of the right child to come
    };

    std::array<Waiting, kMaxDepth> waiting;
    std::size_t height = 0;
    std::size_t depth = 1;
    std::uint32_t taken = 0;
    bool complete = boxes.empty();
    for (const std::uint8_t items : layout.nodes) {
        const std::size_t at = tree.nodes_.size();
        const auto wrong = [at](const char* what) {
            return Restored::failure("tree: node " + std::to_string(at) + what);
        };
        if (complete) {
            return wrong(" lies beyond the last leaf");
        }
        BoxTreeNode& node = tree.nodes_.emplace_back();
        if (items == 0) {
            if (depth == kMaxDepth) {
                return wrong(" is too deep");
            }
            waiting[height++] = {at, ++depth};
            continue;
        }
        if (items > kLeafItems || items > boxes.size() - taken) {
            return wrong(" has too many items");
        }
        node.next = taken;
        node.items = items;
        taken += items;
        complete = height == 0;
        if (!complete) {
            const Waiting& next = waiting[--height];
            tree.nodes_[next.parent].next = static_cast<std::uint32_t>(at + 1);
            depth = next.depth;
        }
    }
    if (!complete || taken != boxes.size()) {
        return Restored::failure("tree: ends before it holds all items");
    }
    tree.fit(boxes);
    return tree;
}

/// The nodes' boxes, from the leaves up: children stand behind their parents.
void BoxTree::fit(std::span<const Aabb> boxes) {
    for (std::size_t at = nodes_.size(); at-- > 0;) {
        BoxTreeNode& node = nodes_[at];
        if (node.items == 0) {
            node.box = join(nodes_[at + 1].box, nodes_[node.next].box);
            continue;
        }
        node.box = nothing();
        for (std::uint32_t i = 0; i < node.items; ++i) {
            node.box = join(node.box, boxes[order_[node.next + i]]);
        }
    }
}

void BoxTree::build(std::span<const Aabb> boxes,
                    std::uint32_t first,
                    std::uint32_t last,
                    std::uint32_t depth) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    if (last - first <= kLeafItems) {
        nodes_[at].next = first;
        nodes_[at].items = last - first;
        return;
    }
    const std::uint32_t cut = split(boxes, first, last, depth);
    build(boxes, first, cut, depth + 1);
    nodes_[at].next = static_cast<std::uint32_t>(nodes_.size());
    build(boxes, cut, last, depth + 1);
}

/// Arranges the items so that the left child's come first; returns where the right child's begin.
std::uint32_t BoxTree::split(std::span<const Aabb> boxes,
                             std::uint32_t first,
                             std::uint32_t last,
                             std::uint32_t depth) {
    Aabb centres = nothing();
    for (std::uint32_t i = first; i < last; ++i) {
        const Vec3 c = middle(boxes[order_[i]]);
        centres = join(centres, {c, c});
    }
    int axis = 0;
    const float extent = (centres.upper - centres.lower).maxCoeff(&axis);
    const auto begin = order_.begin() + first;
    const auto end = order_.begin() + last;
    if (extent > 0.0F && depth < kHalvesFrom) {
        const auto bin_of = [&](std::uint32_t item) {
            const float share = (middle(boxes[item])[axis] - centres.lower[axis]) / extent;
            const auto bin = static_cast<std::size_t>(share * static_cast<float>(kBins));
            return std::min(bin, kBins - 1);
        };
        std::array<Bin, kBins> bins;
        for (std::uint32_t i = first; i < last; ++i) {
            Bin& bin = bins[bin_of(order_[i])];
            bin.box = join(bin.box, boxes[order_[i]]);
            ++bin.items;
        }
        // The extreme centres lie in the first and the last bin, so neither side is empty.
        const std::size_t cut = cheapest_cut(bins);
        const auto right = std::stable_partition(
            begin, end, [&](std::uint32_t item) { return bin_of(item) <= cut; });
        return static_cast<std::uint32_t>(right - order_.begin());
    }
    const auto half = begin + (last - first) / 2;
    std::nth_element(begin, half, end, [&](std::uint32_t a, std::uint32_t b) {
        const float ca = middle(boxes[a])[axis];
        const float cb = middle(boxes[b])[axis];
        return ca < cb || (ca == cb && a < b);
    });
    return static_cast<std::uint32_t>(half - order_.begin());
}

float BoxTree::BoxTreeRay::enter(const Aabb& box) const {
    float enter = 0.0F;
    float leave = INFINITY;
    for (int i = 0; i < 3; ++i) {
        if (std::isinf(inverse[i])) {
            if (origin[i] < box.lower[i] || origin[i] > box.upper[i]) {
                return INFINITY;
            }
            continue;
        }
        const float t0 = (box.lower[i] - origin[i]) * inverse[i];
        const float t1 = (box.upper[i] - origin[i]) * inverse[i];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    return enter <= leave ? enter : INFINITY;
}

}  // namespace zoned::physics
