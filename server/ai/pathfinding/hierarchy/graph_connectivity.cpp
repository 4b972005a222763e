#include "server/ai/pathfinding/hierarchy/graph_connectivity.h"

#include <algorithm>
#include <numeric>

namespace zoned::ai::pathfinding {

void GraphConnectivity::start(std::uint32_t blocks) {
    for (NodeBlock& b : blocks_) {
        b.clusters.clear();
        b.links.clear();
        b.regions = 0;
        b.stale = false;
        b.noted = false;
    }
    blocks_.resize(blocks);
    stale_.clear();
    noted_.clear();
}

void GraphConnectivity::mark(std::uint32_t block) {
    if (!blocks_[block].stale) {
        blocks_[block].stale = true;
        stale_.push_back(block);
    }
}

void GraphConnectivity::note(std::uint32_t block) {
    if (!blocks_[block].noted) {
        blocks_[block].noted = true;
        noted_.push_back(block);
    }
}

void GraphConnectivity::add(std::uint32_t cluster, std::uint32_t block) {
    if (cluster >= block_.size()) {
        block_.resize(cluster + std::size_t{1}, kNone);
        within_.resize(block_.size());
        region_.resize(block_.size());
        parent_.resize(block_.size());
    }
    block_[cluster] = block;
    within_[cluster] = static_cast<std::uint32_t>(blocks_[block].clusters.size());
    blocks_[block].clusters.push_back(cluster);
    mark(block);
}

void GraphConnectivity::remove(std::uint32_t cluster) {
    std::vector<std::uint32_t>& clusters = blocks_[block_[cluster]].clusters;
    const std::uint32_t last = clusters.back();
    clusters[within_[cluster]] = last;
    within_[last] = within_[cluster];
    clusters.pop_back();
    mark(block_[cluster]);
    block_[cluster] = kNone;
}

void GraphConnectivity::number_regions(NodeBlock& block) {
    block.regions = 0;
    for (const std::uint32_t c : block.clusters) {
        if (parent_[c] == c) {
            region_[c] = block.regions++;
        }
    }
    for (const std::uint32_t c : block.clusters) {
        region_[c] = region_[core::root_of_set(core::parents_in(parent_), c)];
    }
}

void GraphConnectivity::keep_links(NodeBlock& block) {
    std::sort(block.links.begin(), block.links.end());
    block.links.erase(std::unique(block.links.begin(), block.links.end()), block.links.end());
}

void GraphConnectivity::join_regions() {
    for (const std::uint32_t b : stale_) {
        blocks_[b].stale = false;
    }
    for (const std::uint32_t b : noted_) {
        blocks_[b].noted = false;
    }
    stale_.clear();
    noted_.clear();
    first_.clear();
    std::uint32_t regions = 0;
    for (const NodeBlock& b : blocks_) {
        first_.push_back(regions);
        regions += b.regions;
    }
    root_.resize(regions);
    std::iota(root_.begin(), root_.end(), 0U);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        for (const BlockLink& link : blocks_[b].links) {
            core::join_sets(
                core::parents_in(root_), first_[b] + link.region, first_[link.block] + link.other);
        }
    }
    // Roots come first: theirs is final.
    for (std::uint32_t& root : root_) {
        root = root_[root];
    }
}

std::size_t GraphConnectivity::bytes() const {
    std::size_t bytes =
        (block_.capacity() + within_.capacity() + region_.capacity() + parent_.capacity() +
         first_.capacity() + root_.capacity() + stale_.capacity() + noted_.capacity()) *
        sizeof(std::uint32_t);
    for (const NodeBlock& b : blocks_) {
        bytes += sizeof(NodeBlock) + b.clusters.capacity() * sizeof(std::uint32_t) +
                 b.links.capacity() * sizeof(BlockLink);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
