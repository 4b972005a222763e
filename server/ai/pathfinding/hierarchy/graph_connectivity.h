// GraphConnectivity: the connected sets of node clusters, kept up to date as some clusters change.
#pragma once

#include "shared/core/containers/union_find.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Connects clusters by links, whatever their direction, in two levels, as Components does for
/// cells. Clusters lie in blocks. Clusters that are linked within a block are a region, and links
/// between blocks join regions. A change costs the blocks in which clusters or their links have
/// changed, the blocks beside these, and a look at all regions. The cost is a small share of a look
/// at all clusters.
class GraphConnectivity {
  public:
    static constexpr std::uint32_t kNone = ~0U;

    /// Starts with no clusters and this many blocks.
    void start(std::uint32_t blocks);

    /// Adds a new cluster to a block.
    void add(std::uint32_t cluster, std::uint32_t block);

    /// Removes a cluster; all clusters that it had links with count as touched.
    void remove(std::uint32_t cluster);

    /// Marks a cluster whose links have changed.
    void touch(std::uint32_t cluster) { mark(block_[cluster]); }

    /// Call once all changes are reported. `out(c)` are the clusters that links from c lead to, and
    /// `in(c)` the clusters from which links lead to c.
    template <class Out, class In>
    void renew(const Out& out, const In& in);

    /// A number that two clusters share exactly where they are joined, valid until the next
    /// renew().
    [[nodiscard]] std::uint32_t of(std::uint32_t cluster) const {
        return root_[first_[block_[cluster]] + region_[cluster]];
    }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// A link from a region to a region of another block.
    struct BlockLink {
        std::uint32_t region;
        std::uint32_t block;
        std::uint32_t other;

        friend auto operator<=>(const BlockLink&, const BlockLink&) = default;
    };

    struct NodeBlock {
        std::vector<std::uint32_t> clusters;
        std::vector<BlockLink> links;  ///< ascending, each once
        std::uint32_t regions = 0;
        bool stale = false;  ///< during a change: its regions are out of date
        bool noted = false;  ///< during a change: its links are out of date
    };

    void mark(std::uint32_t block);
    void note(std::uint32_t block);
    void number_regions(NodeBlock& block);
    void keep_links(NodeBlock& block);
    void join_regions();

    std::vector<NodeBlock> blocks_;
    std::vector<std::uint32_t> block_;   // by cluster
    std::vector<std::uint32_t> within_;  // by cluster, its place in its block
    std::vector<std::uint32_t> region_;  // by cluster, its region's number in its block
    core::UnionFind joined_;             // clusters, while a block is looked at
    core::UnionFind joined_regions_;     // of all blocks
    std::vector<std::uint32_t> first_;   // by block: the number of its first region
    std::vector<std::uint32_t> root_;    // by region of all
    std::vector<std::uint32_t> stale_;   // blocks, during a change
    std::vector<std::uint32_t> noted_;
};

template <class Out, class In>
void GraphConnectivity::renew(const Out& out, const In& in) {
    for (const std::uint32_t b : stale_) {
        for (const std::uint32_t c : blocks_[b].clusters) {
            joined_.part(c);
        }
        for (const std::uint32_t c : blocks_[b].clusters) {
            for (const std::uint32_t other : out(c)) {
                if (block_[other] == b) {
                    joined_.join(c, other);
                }
            }
        }
        number_regions(blocks_[b]);
    }
    // Blocks with links to renumbered regions update their links.
    for (const std::uint32_t b : stale_) {
        note(b);
        for (const std::uint32_t c : blocks_[b].clusters) {
            for (const std::uint32_t other : in(c)) {
                note(block_[other]);
            }
        }
    }
    for (const std::uint32_t b : noted_) {
        NodeBlock& block = blocks_[b];
        block.links.clear();
        for (const std::uint32_t c : block.clusters) {
            for (const std::uint32_t other : out(c)) {
                if (block_[other] != b) {
                    block.links.push_back({region_[c], block_[other], region_[other]});
                }
            }
        }
        keep_links(block);
    }
    join_regions();
}

}  // namespace zoned::ai::pathfinding
