#include "server/ai/navigation/node_clusters.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::ai::navigation {

namespace {

constexpr auto farther = [](const auto& a, const auto& b) {
    return a.cost > b.cost || (a.cost == b.cost && a.cluster > b.cluster);
};

/// Whether one gets along a link.
bool leads(const NodeGraph& graph, std::uint32_t link) {
    return graph.linked[link] != 0 && graph.open[graph.to[link]] != 0;
}

}  // namespace

void NodeClusters::build(const NodeGraph& graph) {
    const std::size_t nodes = graph.places.size();
    cluster_.assign(nodes, kNone);
    within_.assign(nodes, 0);
    first_node_.assign(1, 0);
    nodes_.clear();
    middle_.clear();
    for (std::uint32_t n = 0; n < nodes; ++n) {
        if (graph.open[n] != 0 && cluster_[n] == kNone) {
            gather(graph, n);
        }
    }
    ZONED_ASSERT(size() < kNowhere, "clusters of nodes are numbered with 16 bits");
    link_clusters(graph);
    if (tables_.size() < size()) {
        tables_.resize(size());
    }
    for (Table& t : tables_) {
        t.clear();
    }
}

/// The nodes next to a seed, by links both ways.
void NodeClusters::gather(const NodeGraph& graph, std::uint32_t seed) {
    const auto number = static_cast<std::uint32_t>(size());
    const std::size_t begin = nodes_.size();
    Vec3 sum = Vec3::Zero();
    const auto take = [&](std::uint32_t n) {
        cluster_[n] = number;
        within_[n] = static_cast<std::uint8_t>(nodes_.size() - begin);
        nodes_.push_back(n);
        sum += graph.places[n];
    };
    take(seed);
    for (std::size_t at = begin; at < nodes_.size(); ++at) {
        const std::uint32_t n = nodes_[at];
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            const std::uint32_t back = graph.return_[link];
            if (nodes_.size() - begin < kMost && leads(graph, link) && back != kNone &&
                graph.linked[back] != 0 && cluster_[graph.to[link]] == kNone) {
                take(graph.to[link]);
            }
        }
    }
    middle_.push_back(sum / static_cast<float>(nodes_.size() - begin));
    first_node_.push_back(static_cast<std::uint32_t>(nodes_.size()));
}

void NodeClusters::link_clusters(const NodeGraph& graph) {
    pairs_.clear();
    for (const std::uint32_t n : nodes_) {
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            const std::uint32_t a = cluster_[n];
            if (leads(graph, link) && cluster_[graph.to[link]] != a) {
                pairs_.push_back(std::uint64_t{cluster_[graph.to[link]]} << 32U | a);
            }
        }
    }
    const auto lay_out = [this](std::vector<std::uint32_t>& first,
                                std::vector<std::uint32_t>& others) {
        std::sort(pairs_.begin(), pairs_.end());
        pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
        first.assign(size() + 1, 0);
        others.clear();
        for (std::uint64_t& pair : pairs_) {
            ++first[(pair >> 32U) + 1];
            others.push_back(static_cast<std::uint32_t>(pair));
            pair = pair << 32U | pair >> 32U;
        }
        for (std::size_t c = 1; c < first.size(); ++c) {
            first[c] += first[c - 1];
        }
    };
    lay_out(first_link_, from_);
    lay_out(first_out_, out_);
}

bool NodeClusters::prepare(std::uint32_t goal) {
    const std::uint32_t last = cluster_[goal];
    if (last == kNone || !tables_[last].empty()) {
        return false;
    }
    Table& table = tables_[last];
    table.assign(size(), kNowhere);
    cost_.assign(size(), std::numeric_limits<float>::infinity());
    open_.clear();
    const auto reach = [&](std::uint32_t c, float cost, std::uint32_t next) {
        if (cost < cost_[c]) {
            cost_[c] = cost;
            table[c] = static_cast<std::uint16_t>(next);
            open_.push_back({cost, c});
            std::push_heap(open_.begin(), open_.end(), farther);
        }
    };
    reach(last, 0.0F, last);
    while (!open_.empty()) {
        std::pop_heap(open_.begin(), open_.end(), farther);
        const Open at = open_.back();
        open_.pop_back();
        if (at.cost > cost_[at.cluster]) {
            continue;
        }
        for (std::uint32_t i = first_link_[at.cluster]; i < first_link_[at.cluster + 1]; ++i) {
            reach(from_[i], at.cost + (middle_[from_[i]] - middle_[at.cluster]).norm(), at.cluster);
        }
    }
    return true;
}

std::vector<std::uint32_t> NodeClusters::prepared() const {
    std::vector<std::uint32_t> goals;
    for (std::uint32_t c = 0; c < size(); ++c) {
        if (!tables_[c].empty()) {
            goals.push_back(nodes_[first_node_[c]]);
        }
    }
    return goals;
}

bool NodeClusters::joined(std::uint32_t from, std::uint32_t goal) const {
    return cluster_[from] != kNone && prepared(goal) &&
           tables_[cluster_[goal]][cluster_[from]] != kNowhere;
}

std::size_t NodeClusters::leg(const NodeGraph& graph,
                              std::uint32_t from,
                              std::uint32_t goal,
                              std::array<std::uint32_t, kMost + 1>& nodes) const {
    if (!joined(from, goal)) {
        return 0;
    }
    const std::uint32_t here = cluster_[from];
    const std::uint32_t next = tables_[cluster_[goal]][here];
    // Breadth first within the group; what lies in the next one ends it.
    std::array<std::uint32_t, kMost> found{};
    std::array<std::uint8_t, kMost> before{};
    std::array<bool, kMost> seen{};
    std::size_t count = 1;
    found[0] = from;
    seen[within_[from]] = true;
    const auto trace = [&](std::size_t at, std::size_t length) {
        for (std::size_t i = at; i != 0; i = before[i]) {
            ++length;
        }
        std::size_t back = length;
        if (back > 0 && nodes[0] != kNone) {
            nodes[--back] = nodes[0];
        }
        for (std::size_t i = at; i != 0; i = before[i]) {
            nodes[--back] = found[i];
        }
        return length;
    };
    for (std::size_t at = 0; at < count; ++at) {
        if (found[at] == goal) {
            nodes[0] = kNone;
            return trace(at, 0);
        }
        for (std::uint32_t i = graph.first[found[at]]; i < graph.first[found[at] + 1]; ++i) {
            const std::uint32_t to = graph.to[i];
            if (!leads(graph, i)) {
                continue;
            }
            if (next != here && cluster_[to] == next) {
                nodes[0] = to;
                return trace(at, 1);
            }
            if (cluster_[to] == here && !seen[within_[to]]) {
                seen[within_[to]] = true;
                before[count] = static_cast<std::uint8_t>(at);
                found[count++] = to;
            }
        }
    }
    return 0;
}

void NodeClusters::flood(std::uint32_t from) {
    flooded_.assign(size(), 0);
    queue_.clear();
    if (cluster_[from] == kNone) {
        return;
    }
    queue_.push_back(cluster_[from]);
    flooded_[cluster_[from]] = 1;
    for (std::size_t at = 0; at < queue_.size(); ++at) {
        for (std::uint32_t i = first_out_[queue_[at]]; i < first_out_[queue_[at] + 1]; ++i) {
            if (flooded_[out_[i]] == 0) {
                flooded_[out_[i]] = 1;
                queue_.push_back(out_[i]);
            }
        }
    }
}

std::size_t NodeClusters::bytes() const {
    std::size_t bytes =
        (cluster_.capacity() + first_node_.capacity() + nodes_.capacity() + first_link_.capacity() +
         from_.capacity() + first_out_.capacity() + out_.capacity() + queue_.capacity()) *
            sizeof(std::uint32_t) +
        within_.capacity() + flooded_.capacity() + middle_.capacity() * sizeof(Vec3) +
        pairs_.capacity() * sizeof(std::uint64_t) + cost_.capacity() * sizeof(float) +
        open_.capacity() * sizeof(Open) + tables_.capacity() * sizeof(Table);
    for (const Table& t : tables_) {
        bytes += t.capacity() * sizeof(std::uint16_t);
    }
    return bytes;
}

}  // namespace zoned::ai::navigation
