// NodeClusters: what links join whichever way they lead, and what a change has joined.
#include "server/ai/navigation/node_clusters.h"

#include <algorithm>
#include <numeric>

namespace zoned::ai::navigation {

void NodeClusters::watch_parts() {
    if (!watched_) {
        watched_ = true;
        label_parts();
    }
}

/// Clusters that links join, whichever way these lead.
void NodeClusters::label_parts() {
    part_.resize(size());
    std::iota(part_.begin(), part_.end(), 0U);
    const auto root = [this](std::uint32_t c) {
        while (part_[c] != c) {
            part_[c] = part_[part_[c]];
            c = part_[c];
        }
        return c;
    };
    for (std::uint32_t c = 0; c < size(); ++c) {
        for (const std::uint32_t other : beside_.of(out_[c])) {
            const std::uint32_t a = root(c);
            const std::uint32_t b = root(other);
            part_[std::max(a, b)] = std::min(a, b);
        }
    }
    for (std::uint32_t& part : part_) {
        part = part_[part];
    }
    one_way_ = false;
    for (std::uint32_t c = 0; c < size() && !one_way_; ++c) {
        const std::span<const std::uint32_t> in = beside_.of(in_[c]);
        const std::span<const std::uint32_t> out = beside_.of(out_[c]);
        one_way_ = !std::equal(in.begin(), in.end(), out.begin(), out.end());
    }
}

void NodeClusters::remember_parts(const NodeGraph& graph, std::span<const std::uint32_t> touched) {
    touched_.clear();
    if (!watched_) {
        return;
    }
    const auto remember = [this](std::uint32_t node) {
        touched_.emplace_back(node, cluster_[node] == kNone ? kNone : part_[cluster_[node]]);
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

void NodeClusters::compare_parts() {
    compared_ = watched_;
    joined_.clear();
    if (!watched_) {
        return;
    }
    const bool were_one_way = one_way_;
    label_parts();
    for (auto& [now, before] : touched_) {
        now = cluster_[now] == kNone ? kNone : part_[cluster_[now]];
    }
    std::sort(touched_.begin(), touched_.end());
    for (std::size_t i = 0; i < touched_.size(); ++i) {
        // Where links lead one way only, who was in the same part may not have reached all of it.
        const auto [now, before] = touched_[i];
        const bool first = i == 0 || touched_[i - 1].first != now;
        const bool several = !first && before != kNone && touched_[i - 1].second != before;
        if (now != kNone && (several || one_way_ || were_one_way) &&
            (joined_.empty() || joined_.back() != now)) {
            joined_.push_back(now);
        }
    }
}

bool NodeClusters::joined_anew(std::uint32_t node) const {
    return !compared_ || cluster_[node] == kNone ||
           std::binary_search(joined_.begin(), joined_.end(), part_[cluster_[node]]);
}

}  // namespace zoned::ai::navigation
