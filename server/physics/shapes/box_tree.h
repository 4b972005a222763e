// BoxTree: a tree of axis-aligned boxes over fixed items, built once.
#pragma once

#include "shared/core/result.h"
#include "shared/math/aabb.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace zoned::physics {

/// Binary tree in depth-first order, split by the surface area heuristic over bins (Wald, "On fast
/// construction of SAH-based bounding volume hierarchies", RT 2007). Queries visit items in the
/// order of the tree, which depends on the boxes alone.
class BoxTree {
  public:
    BoxTree() = default;
    /// Items are numbered as the boxes are.
    explicit BoxTree(std::span<const Aabb> boxes);

    /// All that a tree is besides its boxes, for files.
    struct Layout {
        std::vector<std::uint8_t> nodes;   ///< depth first; 0: inner, else a leaf of so many items
        std::vector<std::uint32_t> order;  ///< items, leaf by leaf
    };

    [[nodiscard]] Layout layout() const;
    /// The tree of that layout over the boxes: the very same as the one that gave the layout away.
    /// Any bytes may be given. Fails with the reason when the nodes are no tree of at most
    /// kMaxDepth levels, a leaf is larger than those of built trees, or the order is none of all
    /// items.
    static core::Result<BoxTree> restore(Layout layout, std::span<const Aabb> boxes);

    /// Calls visit(item) for each item whose leaf's box overlaps `area`.
    template <class Visit>
    void query(const Aabb& area, Visit&& visit) const {
        std::array<std::uint32_t, kMaxDepth> stack;
        std::size_t height = 0;
        for (std::uint32_t at = 0; at < nodes_.size();) {
            const BoxTreeNode& node = nodes_[at];
            if (node.box.overlaps(area)) {
                if (node.items == 0) {
                    stack[height++] = node.next;
                    ++at;
                    continue;
                }
                for (std::uint32_t i = 0; i < node.items; ++i) {
                    visit(order_[node.next + i]);
                }
            }
            if (height == 0) {
                return;
            }
            at = stack[--height];
        }
    }

    /// Calls limit = test(item, limit) for items whose leaf's box the ray origin + t direction
    /// meets within 0 <= t <= limit, nearer boxes first. Returns the last limit.
    template <class Test>
    float cast(const Vec3& origin, const Vec3& direction, float limit, Test&& test) const {
        const BoxTreeRay ray(origin, direction);
        std::array<std::pair<std::uint32_t, float>, kMaxDepth + 1> stack;
        std::size_t height = 0;
        if (!nodes_.empty()) {
            stack[height++] = {0, ray.enter(nodes_[0].box)};
        }
        while (height > 0) {
            const auto [at, enter] = stack[--height];
            if (!(enter <= limit)) {
                continue;
            }
            const BoxTreeNode& node = nodes_[at];
            for (std::uint32_t i = 0; i < node.items; ++i) {
                limit = test(order_[node.next + i], limit);
            }
            if (node.items == 0) {
                std::pair<std::uint32_t, float> near{at + 1, ray.enter(nodes_[at + 1].box)};
                std::pair<std::uint32_t, float> far{node.next, ray.enter(nodes_[node.next].box)};
                if (far.second < near.second) {
                    std::swap(near, far);
                }
                stack[height++] = far;
                stack[height++] = near;
            }
        }
        return limit;
    }

    /// Of everything; only valid when there are items.
    [[nodiscard]] const Aabb& box() const { return nodes_[0].box; }

    [[nodiscard]] std::size_t items() const { return order_.size(); }

    [[nodiscard]] std::size_t nodes() const { return nodes_.size(); }

    /// Levels, 1 for a single leaf.
    [[nodiscard]] std::size_t depth() const;

    /// Of memory.
    [[nodiscard]] std::size_t bytes() const {
        return nodes_.size() * sizeof(BoxTreeNode) + order_.size() * sizeof(order_[0]);
    }

    /// Whether both are the same bit for bit, boxes included.
    [[nodiscard]] bool same_as(const BoxTree& other) const;

    static constexpr std::size_t kMaxDepth = 64;

  private:
    /// Splits are halves of the items from this depth on, so that no tree is deeper than kMaxDepth.
    static constexpr std::uint32_t kHalvesFrom = 32;

    struct BoxTreeNode {
        Aabb box;
        std::uint32_t next = 0;  ///< inner: the right child (the left one follows); leaf: its items
        std::uint32_t items = 0;  ///< leaf: how many
    };

    /// A ray with its inverse direction, for slabs.
    struct BoxTreeRay {
        Vec3 origin, inverse;

        BoxTreeRay(const Vec3& o, const Vec3& d) : origin(o), inverse(d.cwiseInverse()) {}

        /// Where the ray enters the box; infinite when it misses it.
        [[nodiscard]] float enter(const Aabb& box) const;
    };

    void build(std::span<const Aabb> boxes,
               std::uint32_t first,
               std::uint32_t last,
               std::uint32_t depth);
    std::uint32_t split(std::span<const Aabb> boxes,
                        std::uint32_t first,
                        std::uint32_t last,
                        std::uint32_t depth);

    void fit(std::span<const Aabb> boxes);

    std::vector<BoxTreeNode> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace zoned::physics
