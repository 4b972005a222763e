#include "server/ai/navigation/cluster_graph.h"

#include <algorithm>

namespace zoned::ai::navigation {

namespace {

constexpr std::uint32_t kFromStart = ~0U;
/// What is ahead counts for more by one so-manieth: a way through portals may cost as much more
/// than the best of these (Pohl 1970), and where many are nearly as good fewer are looked at.
constexpr Cost kHaste = 48;

Cell cell_of(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

std::uint32_t squares(int cells) {
    return static_cast<std::uint32_t>((cells + ClusterGraph::kSide - 1) / ClusterGraph::kSide);
}

}  // namespace

ClusterGraph::ClusterGraph(const GridMap& map)
    : across_(squares(map.width())),
      down_(squares(map.height())) {
    clusters_.resize(std::size_t{across_} * down_);
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
        find_portals(map, c, true);
        find_portals(map, c, false);
    }
    number_nodes();
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
        measure(map, c);
    }
}

void ClusterGraph::update(const GridMap& map, std::span<const CellChange> changes) {
    std::vector<std::uint32_t> touched;
    bool others = false;  // portals than before
    const auto renew = [&](std::uint32_t cluster, bool right, std::uint32_t other) {
        others = find_portals(map, cluster, right) || others;
        touched.push_back(other);
    };
    for (const CellChange& change : changes) {
        const Cell c = change.cell;
        const std::uint32_t cluster = cluster_of(c);
        touched.push_back(cluster);
        const int x = c.x % kSide;
        const int y = c.y % kSide;
        if (x == 0 && c.x > 0) {
            renew(cluster - 1, true, cluster - 1);
        } else if (x == kSide - 1 && c.x + 1 < map.width()) {
            renew(cluster, true, cluster + 1);
        }
        if (y == 0 && c.y > 0) {
            renew(cluster - across_, false, cluster - across_);
        } else if (y == kSide - 1 && c.y + 1 < map.height()) {
            renew(cluster, false, cluster + across_);
        }
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    if (others) {
        number_nodes();
    }
    for (const std::uint32_t cluster : touched) {
        measure(map, cluster);
    }
}

bool ClusterGraph::find_portals(const GridMap& map, std::uint32_t cluster, bool right) {
    std::vector<Cell>& portals = right ? clusters_[cluster].right : clusters_[cluster].below;
    portals.swap(old_portals_);
    portals.clear();
    const GoalField::Window w = window(map, cluster);
    const int line = right ? w.right : w.bottom;
    if (line + 1 >= (right ? map.width() : map.height())) {
        return false;
    }
    const auto at = [right, line](int i, int beyond) {
        return right ? cell_of(line + beyond, i) : cell_of(i, line + beyond);
    };
    const int end = (right ? w.bottom : w.right) + 1;
    for (int first = right ? w.top : w.left; first < end; ++first) {
        int after = first;
        while (after < end && map.passable(at(after, 0)) && map.passable(at(after, 1))) {
            ++after;
        }
        // Evenly over where the border can be crossed, in the middles of their shares.
        const int length = after - first;
        const int count = (length + kSpacing - 1) / kSpacing;
        for (int i = 0; i < count; ++i) {
            portals.push_back(at(first + (2 * i + 1) * length / (2 * count), 0));
        }
        first = after;
    }
    return portals != old_portals_;
}

void ClusterGraph::number_nodes() {
    nodes_.clear();
    for (Cluster& c : clusters_) {
        c.nodes.clear();
    }
    const auto add = [this](Cell cell, std::uint32_t cluster, std::uint32_t twin) {
        Cluster& c = clusters_[cluster];
        const auto number = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({cell, cluster, static_cast<std::uint32_t>(c.nodes.size()), twin});
        c.nodes.push_back(number);
    };
    // Within a cluster the order hangs on its own borders alone: costs of others stay where they
    // are.
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
        for (const Cell cell : clusters_[c].right) {
            const auto number = static_cast<std::uint32_t>(nodes_.size());
            add(cell, c, number + 1);
            add(cell_of(cell.x + 1, cell.y), c + 1, number);
        }
        for (const Cell cell : clusters_[c].below) {
            const auto number = static_cast<std::uint32_t>(nodes_.size());
            add(cell, c, number + 1);
            add(cell_of(cell.x, cell.y + 1), c + across_, number);
        }
    }
    space_.resize(static_cast<std::uint32_t>(nodes_.size()) + 1);
    for (const Cluster& c : clusters_) {
        to_goal_.reserve(c.nodes.size());
    }
}

GoalField::Window ClusterGraph::window(const GridMap& map, std::uint32_t cluster) const {
    const auto left = static_cast<int>(cluster % across_) * kSide;
    const auto top = static_cast<int>(cluster / across_) * kSide;
    return {left,
            top,
            std::min(left + kSide, map.width()) - 1,
            std::min(top + kSide, map.height()) - 1};
}

void ClusterGraph::measure(const GridMap& map, std::uint32_t cluster) {
    Cluster& c = clusters_[cluster];
    const std::size_t n = c.nodes.size();
    c.cost.resize(n * n);
    for (std::size_t i = 0; i < n; ++i) {
        field_.build(map, nodes_[c.nodes[i]].cell, window(map, cluster));
        for (std::size_t j = 0; j < n; ++j) {
            c.cost[i * n + j] = field_.cost(map.place(nodes_[c.nodes[j]].cell));
        }
    }
}

void ClusterGraph::reach(std::uint32_t node, Cost cost, std::uint32_t from, Cell goal) {
    if (cost < space_.cost(node)) {
        space_.reach(node, cost, from);
        const bool at_goal = node == nodes_.size();
        const Cost h =
            at_goal ? 0 : octile(goal.x - nodes_[node].cell.x, goal.y - nodes_[node].cell.y);
        space_.open.push(node, (std::uint64_t{cost} + h + h / kHaste) << 32U | h);
    }
}

/// From the start through the portals of its square, and from those of the goal's to the goal. What
/// is looked at are the cells behind portals only: two legs within one square are never shorter
/// than the one between their ends.
void ClusterGraph::open_ends(const GridMap& map, const Query& query) {
    const Cluster& first = clusters_[cluster_of(query.start)];
    const Cluster& last = clusters_[cluster_of(query.goal)];
    to_goal_.clear();
    field_.build(map, query.goal, window(map, cluster_of(query.goal)));
    for (const std::uint32_t n : last.nodes) {
        to_goal_.push_back(field_.cost(map.place(nodes_[n].cell)));
    }
    direct_ = &first == &last ? field_.cost(map.place(query.start)) : kNoCost;
    field_.build(map, query.start, window(map, cluster_of(query.start)));
    for (const std::uint32_t n : first.nodes) {
        const Cost cost = field_.cost(map.place(nodes_[n].cell));
        if (cost != kNoCost) {
            reach(nodes_[n].twin, cost + kStraight, kFromStart, query.goal);
        }
    }
    if (direct_ != kNoCost) {
        reach(static_cast<std::uint32_t>(nodes_.size()), direct_, kFromStart, query.goal);
    }
}

bool ClusterGraph::run(const GridMap& map,
                       const Query& query,
                       std::vector<Cell>& through,
                       std::uint32_t& work) {
    const auto goal = static_cast<std::uint32_t>(nodes_.size());
    const std::uint32_t last = cluster_of(query.goal);
    space_.begin();
    open_ends(map, query);
    through.assign(1, query.goal);
    work = 0;
    while (!space_.open.empty() && work != query.max_work) {
        const std::uint32_t at = space_.open.pop();
        ++work;
        if (at == goal) {
            for (std::uint32_t n = space_.from(goal); n != kFromStart; n = space_.from(n)) {
                through.push_back(nodes_[n].cell);
                through.push_back(nodes_[nodes_[n].twin].cell);
            }
            through.push_back(query.start);
            std::reverse(through.begin(), through.end());
            return true;
        }
        const Node& node = nodes_[at];
        const Cluster& cluster = clusters_[node.cluster];
        const Cost g = space_.cost(at);
        if (node.cluster == last && to_goal_[node.local] != kNoCost) {
            reach(goal, g + to_goal_[node.local], at, query.goal);
        }
        const Cost* const row = cluster.cost.data() + node.local * cluster.nodes.size();
        for (std::size_t i = 0; i < cluster.nodes.size(); ++i) {
            if (row[i] != kNoCost && i != node.local) {
                reach(nodes_[cluster.nodes[i]].twin, g + row[i] + kStraight, at, query.goal);
            }
        }
    }
    through.clear();
    return false;
}

std::size_t ClusterGraph::bytes() const {
    std::size_t bytes = nodes_.capacity() * sizeof(Node);
    for (const Cluster& c : clusters_) {
        bytes += sizeof(Cluster) + (c.right.capacity() + c.below.capacity()) * sizeof(Cell) +
                 c.nodes.capacity() * sizeof(std::uint32_t) + c.cost.capacity() * sizeof(Cost);
    }
    return bytes;
}

}  // namespace zoned::ai::navigation
