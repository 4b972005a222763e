#include "server/ai/pathfinding/hierarchy/graph_connectivity.h"

#include <algorithm>

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
        joined_.grow(block_.size());
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
        if (joined_.root(c) == c) {
            region_[c] = block.regions++;
        }
    }
    for (const std::uint32_t c : block.clusters) {
        region_[c] = region_[joined_.root(c)];
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
    joined_regions_.reset(regions);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        for (const BlockLink& link : blocks_[b].links) {
            joined_regions_.join(first_[b] + link.region, first_[link.block] + link.other);
        }
    }
    root_.clear();
    for (std::uint32_t region = 0; region < regions; ++region) {
        root_.push_back(joined_regions_.root(region));
    }
}

std::size_t GraphConnectivity::bytes() const {
    std::size_t bytes =
        (block_.capacity() + within_.capacity() + region_.capacity() + first_.capacity() +
         root_.capacity() + stale_.capacity() + noted_.capacity()) *
            sizeof(std::uint32_t) +
        joined_.bytes() + joined_regions_.bytes();
    for (const NodeBlock& b : blocks_) {
        bytes += sizeof(NodeBlock) + b.clusters.capacity() * sizeof(std::uint32_t) +
                 b.links.capacity() * sizeof(BlockLink);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
