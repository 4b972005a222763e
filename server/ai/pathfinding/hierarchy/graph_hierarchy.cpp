#include "server/ai/pathfinding/hierarchy/graph_hierarchy.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::ai::pathfinding {

namespace {

/// True if a link can be passed.
bool leads(const NodeGraph& graph, std::uint32_t link) {
    return graph.linked[link] != 0 && graph.open[graph.to[link]] != 0;
}

/// And back.
bool leads_both_ways(const NodeGraph& graph, std::uint32_t link) {
    const std::uint32_t back = graph.return_[link];
    return leads(graph, link) && back != GraphHierarchy::kNone && graph.linked[back] != 0;
}

}  // namespace

void GraphHierarchy::build(const NodeGraph& graph) {
    const std::size_t nodes = graph.places.size();
    cluster_.assign(nodes, kNone);
    within_.assign(nodes, 0);
    for (std::uint32_t c = 0; c < size(); ++c) {
        beside_.give_back(in_[c]);
        beside_.give_back(out_[c]);
    }
    count_.clear();
    nodes_.clear();
    middle_.clear();
    in_.clear();
    out_.clear();
    is_dirty_.clear();
    is_one_way_.clear();
    one_way_ = 0;
    free_.clear();
    ++round_;
    compared_ = false;
    find_strays(graph);
    share_out(graph);
    share_out_blocks(graph);
    for (std::uint32_t n = 0; n < nodes; ++n) {
        if (graph.open[n] != 0 && cluster_[n] == kNone) {
            gather(graph, n);
        }
    }
    parts_.start(blocks_);
    for (std::uint32_t c = 0; c < size(); ++c) {
        link(graph, c);
        parts_.add(c, block_of(c));
    }
    renew_parts();
}

void GraphHierarchy::find_strays(const NodeGraph& graph) {
    strays_.clear();
    for (std::uint32_t n = 0; n < graph.places.size(); ++n) {
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            const std::uint32_t back = graph.return_[link];
            if (back == kNone || graph.return_[back] != link) {
                strays_.push_back({graph.to[link], n, link});
            }
        }
    }
    std::sort(strays_.begin(), strays_.end(), [](const Stray& a, const Stray& b) {
        return a.to != b.to ? a.to < b.to : a.link < b.link;
    });
}

/// Up to kMost nodes next to each other are a share.
void GraphHierarchy::share_out(const NodeGraph& graph) {
    const std::size_t nodes = graph.places.size();
    share_.assign(nodes, kNone);
    first_share_.assign(1, 0);
    share_nodes_.clear();
    for (std::uint32_t seed = 0; seed < nodes; ++seed) {
        if (share_[seed] != kNone) {
            continue;
        }
        const std::size_t begin = share_nodes_.size();
        const auto number = static_cast<std::uint32_t>(first_share_.size()) - 1;
        share_[seed] = number;
        share_nodes_.push_back(seed);
        for (std::size_t at = begin; at < share_nodes_.size(); ++at) {
            const std::uint32_t n = share_nodes_[at];
            for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
                const std::uint32_t other = graph.to[link];
                if (share_nodes_.size() - begin < kMost && share_[other] == kNone &&
                    graph.return_[link] != kNone) {
                    share_[other] = number;
                    share_nodes_.push_back(other);
                }
            }
        }
        std::sort(share_nodes_.begin() + static_cast<std::ptrdiff_t>(begin), share_nodes_.end());
        first_share_.push_back(static_cast<std::uint32_t>(share_nodes_.size()));
    }
}

std::uint32_t GraphHierarchy::take_number() {
    if (!free_.empty()) {
        const std::uint32_t number = free_.back();
        free_.pop_back();
        return number;
    }
    const auto number = static_cast<std::uint32_t>(size());
    ZONED_ASSERT(number < kNowhere, "clusters of nodes are numbered with 16 bits");
    count_.push_back(0);
    nodes_.resize(nodes_.size() + kMost);
    middle_.emplace_back(Vec3::Zero());
    in_.emplace_back();
    out_.emplace_back();
    is_dirty_.push_back(0);
    is_one_way_.push_back(0);
    if (tables_.size() < size()) {
        tables_.emplace_back();
        table_round_.push_back(0);
    }
    return number;
}

void GraphHierarchy::put(std::uint32_t node, std::uint32_t cluster) {
    cluster_[node] = cluster;
    within_[node] = count_[cluster];
    nodes_[cluster * kMost + count_[cluster]++] = node;
}

/// Gathers the nodes of a share that are joined with a seed, the least of them, by two-way links.
std::uint32_t GraphHierarchy::gather(const NodeGraph& graph, std::uint32_t seed) {
    const std::uint32_t number = take_number();
    put(seed, number);
    for (std::size_t at = 0; at < count_[number]; ++at) {
        const std::uint32_t n = nodes_[number * kMost + at];
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            if (share_[graph.to[link]] == share_[seed] && leads_both_ways(graph, link) &&
                cluster_[graph.to[link]] == kNone) {
                put(graph.to[link], number);
            }
        }
    }
    find_middle(graph, number);
    return number;
}

void GraphHierarchy::find_middle(const NodeGraph& graph, std::uint32_t cluster) {
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t n : nodes_of(cluster)) {
        sum += graph.places[n];
    }
    middle_[cluster] = sum / static_cast<float>(count_[cluster]);
}

void GraphHierarchy::link(const NodeGraph& graph, std::uint32_t cluster) {
    const auto keep = [&](Beside& beside) {
        std::sort(links_.begin(), links_.end());
        links_.erase(std::unique(links_.begin(), links_.end()), links_.end());
        beside_.give_back(beside);
        beside = beside_.take(static_cast<std::uint32_t>(links_.size()));
        std::copy(links_.begin(), links_.end(), beside_.of(beside).begin());
        links_.clear();
    };
    const auto note = [&](std::uint32_t node) {
        if (cluster_[node] != kNone && cluster_[node] != cluster) {
            links_.push_back(cluster_[node]);
        }
    };
    links_.clear();
    for (const std::uint32_t n : nodes_of(cluster)) {
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            if (leads(graph, link)) {
                note(graph.to[link]);
            }
        }
    }
    keep(out_[cluster]);
    for (const std::uint32_t n : nodes_of(cluster)) {
        for (std::uint32_t link = graph.first[n]; link < graph.first[n + 1]; ++link) {
            const std::uint32_t back = graph.return_[link];
            if (back != kNone && graph.linked[back] != 0) {
                note(graph.to[link]);
            }
        }
        auto stray = std::lower_bound(
            strays_.begin(), strays_.end(), n, [](const Stray& s, std::uint32_t to) {
                return s.to < to;
            });
        for (; stray != strays_.end() && stray->to == n; ++stray) {
            if (graph.linked[stray->link] != 0) {
                note(stray->from);
            }
        }
    }
    keep(in_[cluster]);
    const std::span<const std::uint32_t> in = beside_.of(in_[cluster]);
    const std::span<const std::uint32_t> out = beside_.of(out_[cluster]);
    note_one_way(cluster, !std::equal(in.begin(), in.end(), out.begin(), out.end()));
}

void GraphHierarchy::mark_dirty(std::uint32_t cluster) {
    if (is_dirty_[cluster] == 0) {
        is_dirty_[cluster] = kDirty;
        dirty_.push_back(cluster);
    }
}

void GraphHierarchy::mark_renewed(std::uint32_t cluster) {
    mark_dirty(cluster);
    is_dirty_[cluster] = kRenewed;
}

void GraphHierarchy::mark_beside_dirty(std::uint32_t cluster) {
    for (const Beside& beside : {in_[cluster], out_[cluster]}) {
        for (const std::uint32_t other : beside_.of(beside)) {
            mark_dirty(other);
        }
    }
}

/// Its nodes are in no cluster from now on.
void GraphHierarchy::dissolve(std::uint32_t cluster) {
    parts_.remove(cluster);
    for (const std::uint32_t n : nodes_of(cluster)) {
        cluster_[n] = kNone;
    }
    give_up(cluster);
}

void GraphHierarchy::give_up(std::uint32_t cluster) {
    mark_beside_dirty(cluster);
    for (Beside* beside : {&in_[cluster], &out_[cluster]}) {
        beside_.give_back(*beside);
        *beside = {};
    }
    note_one_way(cluster, false);
    count_[cluster] = 0;
    free_.push_back(cluster);
}

void GraphHierarchy::change(const NodeGraph& graph, std::span<const std::uint32_t> touched) {
    ++round_;
    dirty_.clear();
    remember_parts(graph, touched);
    loose_.clear();
    for (const std::uint32_t n : touched) {
        loose_.push_back(share_[n]);
    }
    std::sort(loose_.begin(), loose_.end());
    loose_.erase(std::unique(loose_.begin(), loose_.end()), loose_.end());
    for (const std::uint32_t share : loose_) {
        const std::span<const std::uint32_t> nodes = nodes_of_share(share);
        for (const std::uint32_t n : nodes) {
            if (cluster_[n] != kNone) {
                dissolve(cluster_[n]);
            }
        }
        for (const std::uint32_t n : nodes) {
            if (graph.open[n] != 0 && cluster_[n] == kNone) {
                const std::uint32_t renewed = gather(graph, n);
                mark_renewed(renewed);
                parts_.add(renewed, block_of(renewed));
            }
        }
    }
    // Renewed clusters have new links out, and other clusters have new links to them.
    for (std::size_t i = 0; i < dirty_.size(); ++i) {
        if (count_[dirty_[i]] != 0) {
            link(graph, dirty_[i]);
            if (is_dirty_[dirty_[i]] == kRenewed) {
                mark_beside_dirty(dirty_[i]);
            }
        }
    }
    for (const std::uint32_t c : dirty_) {
        is_dirty_[c] = 0;
        if (count_[c] != 0) {
            parts_.touch(c);
        }
    }
    compare_parts();
}

bool GraphHierarchy::prepare(std::uint32_t goal) {
    const std::uint32_t last = cluster_[goal];
    if (last == kNone || prepared(goal)) {
        return false;
    }
    table_round_[last] = round_;
    Table& table = tables_[last];
    table.assign(size(), kNowhere);
    cost_.assign(size(), std::numeric_limits<float>::infinity());
    open_.clear();
    const auto reach = [&](std::uint32_t c, float cost, std::uint32_t next) {
        if (cost < cost_[c]) {
            cost_[c] = cost;
            table[c] = static_cast<std::uint16_t>(next);
            open_.push({cost, name_of(c), c});
        }
    };
    reach(last, 0.0F, last);
    while (!open_.empty()) {
        const OpenGroup at = open_.pop();
        if (at.key > cost_[at.cluster]) {
            continue;
        }
        for (const std::uint32_t from : beside_.of(in_[at.cluster])) {
            reach(from, at.key + (middle_[from] - middle_[at.cluster]).norm(), at.cluster);
        }
    }
    return true;
}

std::vector<std::uint32_t> GraphHierarchy::prepared() const {
    std::vector<std::uint32_t> goals;
    for (std::uint32_t c = 0; c < size(); ++c) {
        if (count_[c] != 0 && table_round_[c] == round_) {
            goals.push_back(name_of(c));
        }
    }
    std::sort(goals.begin(), goals.end());  // whatever their groups are numbered
    return goals;
}

bool GraphHierarchy::joined(std::uint32_t from, std::uint32_t goal) const {
    return cluster_[from] != kNone && prepared(goal) &&
           tables_[cluster_[goal]][cluster_[from]] != kNowhere;
}

std::size_t GraphHierarchy::segment(const NodeGraph& graph,
                                    std::uint32_t from,
                                    std::uint32_t goal,
                                    std::array<std::uint32_t, kMost + 1>& nodes) const {
    if (!joined(from, goal)) {
        return 0;
    }
    const std::uint32_t here = cluster_[from];
    const std::uint32_t next = tables_[cluster_[goal]][here];
    // Breadth first within the group; a node of the next group ends the search.
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

void GraphHierarchy::flood(std::uint32_t from) {
    flooded_.assign(size(), 0);
    queue_.clear();
    if (cluster_[from] == kNone) {
        return;
    }
    queue_.push_back(cluster_[from]);
    flooded_[cluster_[from]] = 1;
    for (std::size_t at = 0; at < queue_.size(); ++at) {
        for (const std::uint32_t to : std::as_const(beside_).of(out_[queue_[at]])) {
            if (flooded_[to] == 0) {
                flooded_[to] = 1;
                queue_.push_back(to);
            }
        }
    }
}

std::size_t GraphHierarchy::bytes() const {
    std::size_t bytes =
        (share_.capacity() + first_share_.capacity() + share_nodes_.capacity() +
         cluster_.capacity() + nodes_.capacity() + free_.capacity() + table_round_.capacity() +
         share_block_.capacity() + joined_.capacity() + dirty_.capacity() + loose_.capacity() +
         links_.capacity() + queue_.capacity()) *
            sizeof(std::uint32_t) +
        within_.capacity() + count_.capacity() + is_dirty_.capacity() + flooded_.capacity() +
        strays_.capacity() * sizeof(Stray) + middle_.capacity() * sizeof(Vec3) +
        (in_.capacity() + out_.capacity()) * sizeof(Beside) + beside_.bytes() +
        touched_.capacity() * sizeof(touched_[0]) + cost_.capacity() * sizeof(float) +
        open_.bytes() + parts_.bytes() + is_one_way_.capacity() +
        tables_.capacity() * sizeof(Table);
    for (const Table& t : tables_) {
        bytes += t.capacity() * sizeof(std::uint16_t);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
