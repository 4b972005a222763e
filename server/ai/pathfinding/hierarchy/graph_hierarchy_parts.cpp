// GraphHierarchy: the parts that links of any direction join, and the parts that a change has
// joined.
#include "server/ai/pathfinding/hierarchy/graph_hierarchy.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::pathfinding {

/// Forms blocks of adjacent shares, in the same manner as nodes are divided into shares.
void GraphHierarchy::share_out_blocks(const NodeGraph& graph) {
    const std::size_t shares = first_share_.size() - 1;
    share_block_.assign(shares, kNone);
    blocks_ = 0;
    for (std::uint32_t seed = 0; seed < shares; ++seed) {
        if (share_block_[seed] != kNone) {
            continue;
        }
        queue_.assign(1, seed);
        share_block_[seed] = blocks_;
        for (std::size_t at = 0; at < queue_.size(); ++at) {
            for (const std::uint32_t n : nodes_of_share(queue_[at])) {
                for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
                    const std::uint32_t other = share_[graph.to[link]];
                    if (queue_.size() < kSharesOfBlock && share_block_[other] == kNone) {
                        share_block_[other] = blocks_;
                        queue_.push_back(other);
                    }
                }
            }
        }
        ++blocks_;
    }
}

void GraphHierarchy::note_one_way(std::uint32_t cluster, bool one_way) {
    const std::uint8_t is = one_way ? 1 : 0;
    one_way_ = one_way_ + is - is_one_way_[cluster];
    is_one_way_[cluster] = is;
}

void GraphHierarchy::renew_parts() {
    const auto beside = [this](const std::vector<Beside>& of) {
        return [this, &of](std::uint32_t c) {
            return std::as_const(beside_).of(of[c]);
        };
    };
    parts_.renew(beside(out_), beside(in_));
}

void GraphHierarchy::remember_parts(const NodeGraph& graph,
                                    std::span<const std::uint32_t> touched) {
    touched_.clear();
    were_one_way_ = one_way_ != 0;
    const auto remember = [this](std::uint32_t node) {
        touched_.emplace_back(node, cluster_[node] == kNone ? kNone : parts_.of(cluster_[node]));
    };
    for (const std::uint32_t n : touched) {
        remember(n);
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            remember(graph.to[link]);
        }
        auto stray = std::lower_bound(
            strays_.begin(), strays_.end(), n, [](const Stray& s, std::uint32_t to) {
                return s.to < to;
            });
        for (; stray != strays_.end() && stray->to == n; ++stray) {
            remember(stray->from);
        }
    }
}

void GraphHierarchy::compare_parts() {
    compared_ = true;
    joined_.clear();
    renew_parts();
    for (auto& [now, before] : touched_) {
        now = cluster_[now] == kNone ? kNone : parts_.of(cluster_[now]);
    }
    std::sort(touched_.begin(), touched_.end());
    for (std::size_t i = 0; i < touched_.size(); ++i) {
        // Where links have one direction only, a node may not have reached all of its part.
        const auto [now, before] = touched_[i];
        const bool first = i == 0 || touched_[i - 1].first != now;
        const bool several = !first && before != kNone && touched_[i - 1].second != before;
        if (now != kNone && (several || one_way_ != 0 || were_one_way_) &&
            (joined_.empty() || joined_.back() != now)) {
            joined_.push_back(now);
        }
    }
}

bool GraphHierarchy::joined_anew(std::uint32_t node) const {
    return !compared_ || cluster_[node] == kNone ||
           std::binary_search(joined_.begin(), joined_.end(), parts_.of(cluster_[node]));
}

}  // namespace zoned::ai::pathfinding
