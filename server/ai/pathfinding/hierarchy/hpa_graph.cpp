#include "server/ai/pathfinding/hierarchy/hpa_graph.h"

#include <algorithm>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::uint32_t kFromStart = ~0U;
/// The estimate of the path ahead is raised by this fraction (one in kHaste). A path through
/// portals may cost as much more than the best of these (Pohl 1970). Where many paths are nearly as
/// good, fewer are looked at.
constexpr Cost kHaste = 48;

Cell cell_of(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

std::uint32_t squares(int cells) {
    return static_cast<std::uint32_t>((cells + HpaGraph::kSide - 1) / HpaGraph::kSide);
}

}  // namespace

HpaGraph::HpaGraph(const GridMap& map)
    : across_(squares(map.width())),
      down_(squares(map.height())) {
    clusters_.resize(std::size_t{across_} * down_);
    nodes_.resize(clusters_.size() * kMostOfCluster);
    space_.resize(static_cast<std::uint32_t>(nodes_.size()) + 1);
    cells_.reserve(kMostOfCluster);
    to_goal_.reserve(kMostOfCluster);
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
        find_portals(map, c, kRight);
        find_portals(map, c, kBelow);
    }
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
        list_nodes(c);
        measure(map, c);
    }
}

void HpaGraph::update(const GridMap& map, std::span<const CellChange> changes) {
    touched_.clear();
    const auto renew = [&](std::uint32_t cluster, ClusterSide side) {
        if (find_portals(map, cluster, side)) {
            touched_.push_back(cluster);
            touched_.push_back(beyond(cluster, side));
        }
    };
    for (const CellChange& change : changes) {
        const Cell c = change.cell;
        const std::uint32_t cluster = cluster_of(c);
        touched_.push_back(cluster);
        const int x = c.x % kSide;
        const int y = c.y % kSide;
        if (x == 0 && c.x > 0) {
            renew(beyond(cluster, kLeft), kRight);
        } else if (x == kSide - 1 && c.x + 1 < map.width()) {
            renew(cluster, kRight);
        }
        if (y == 0 && c.y > 0) {
            renew(beyond(cluster, kAbove), kBelow);
        } else if (y == kSide - 1 && c.y + 1 < map.height()) {
            renew(cluster, kBelow);
        }
    }
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const std::uint32_t cluster : touched_) {
        list_nodes(cluster);
        measure(map, cluster);
    }
}

bool HpaGraph::find_portals(const GridMap& map, std::uint32_t cluster, ClusterSide side) {
    const bool right = side == kRight;
    const FlowField::Window w = window(map, cluster);
    const int line = right ? w.right : w.bottom;
    if (line + 1 >= (right ? map.width() : map.height())) {
        return false;
    }
    const auto at = [right, line](int i, int beyond) {
        return right ? cell_of(line + beyond, i) : cell_of(i, line + beyond);
    };
    const std::uint32_t here = first_node(cluster, side);
    const std::uint32_t there = twin(here);
    std::uint8_t& count = clusters_[cluster].count[side];
    std::uint8_t found = 0;
    bool others = false;
    const int end = (right ? w.bottom : w.right) + 1;
    for (int first = right ? w.top : w.left; first < end; ++first) {
        int after = first;
        while (after < end && map.passable(at(after, 0)) && map.passable(at(after, 1))) {
            ++after;
        }
        // Evenly over where the border can be crossed, in the middles of their shares.
        const int length = after - first;
        const int shares = (length + kSpacing - 1) / kSpacing;
        for (int i = 0; i < shares; ++i, ++found) {
            const int middle = first + (2 * i + 1) * length / (2 * shares);
            others = others || found >= count || nodes_[here + found].cell != at(middle, 0);
            nodes_[here + found].cell = at(middle, 0);
            nodes_[there + found].cell = at(middle, 1);
        }
        first = after;
    }
    others = others || found != count;
    portals_ = portals_ + found - count;
    count = found;
    clusters_[beyond(cluster, side)].count[kSides - 1 - side] = found;
    return others;
}

void HpaGraph::list_nodes(std::uint32_t cluster) {
    HpaCluster& c = clusters_[cluster];
    c.nodes.clear();
    for (const ClusterSide side : {kAbove, kLeft, kRight, kBelow}) {
        const std::uint32_t first = first_node(cluster, side);
        for (std::uint32_t i = 0; i < c.count[side]; ++i) {
            nodes_[first + i].local = static_cast<std::uint32_t>(c.nodes.size());
            c.nodes.push_back(first + i);
        }
    }
}

FlowField::Window HpaGraph::window(const GridMap& map, std::uint32_t cluster) const {
    const auto left = static_cast<int>(cluster % across_) * kSide;
    const auto top = static_cast<int>(cluster / across_) * kSide;
    return {left,
            top,
            std::min(left + kSide, map.width()) - 1,
            std::min(top + kSide, map.height()) - 1};
}

void HpaGraph::measure(const GridMap& map, std::uint32_t cluster) {
    HpaCluster& c = clusters_[cluster];
    cells_.clear();
    for (const std::uint32_t n : c.nodes) {
        cells_.push_back(nodes_[n].cell);
    }
    c.cost.resize(cells_.size() * cells_.size());
    const FlowField::Window w = window(map, cluster);
    square_.measure(
        map, cell_of(w.left, w.top), w.right - w.left + 1, w.bottom - w.top + 1, cells_, c.cost);
}

void HpaGraph::reach(std::uint32_t node, Cost cost, std::uint32_t from, Cell goal) {
    if (cost < space_.cost(node)) {
        space_.reach(node, cost, from);
        const bool at_goal = node == nodes_.size();
        const Cost h =
            at_goal ? 0 : octile(goal.x - nodes_[node].cell.x, goal.y - nodes_[node].cell.y);
        space_.open.push(node, (std::uint64_t{cost} + h + h / kHaste) << 32U | h);
    }
}

/// Links the start with the portals of its square, and the portals of the goal's square with the
/// goal. Only the cells behind portals are looked at. Two segments within one square are never
/// shorter than the one between their ends.
void HpaGraph::open_ends(const GridMap& map, const GridQuery& query) {
    const HpaCluster& first = clusters_[cluster_of(query.start)];
    const HpaCluster& last = clusters_[cluster_of(query.goal)];
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
            reach(twin(n), cost + kStraight, kFromStart, query.goal);
        }
    }
    if (direct_ != kNoCost) {
        reach(static_cast<std::uint32_t>(nodes_.size()), direct_, kFromStart, query.goal);
    }
}

bool HpaGraph::run(const GridMap& map,
                   const GridQuery& query,
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
                through.push_back(nodes_[twin(n)].cell);
            }
            through.push_back(query.start);
            std::reverse(through.begin(), through.end());
            return true;
        }
        const PortalNode& node = nodes_[at];
        const std::uint32_t here = at / kMostOfCluster;
        const HpaCluster& cluster = clusters_[here];
        const Cost g = space_.cost(at);
        if (here == last && to_goal_[node.local] != kNoCost) {
            reach(goal, g + to_goal_[node.local], at, query.goal);
        }
        const Cost* const row = cluster.cost.data() + node.local * cluster.nodes.size();
        for (std::size_t i = 0; i < cluster.nodes.size(); ++i) {
            if (row[i] != kNoCost && i != node.local) {
                reach(twin(cluster.nodes[i]), g + row[i] + kStraight, at, query.goal);
            }
        }
    }
    through.clear();
    return false;
}

std::size_t HpaGraph::bytes() const {
    std::size_t bytes = nodes_.capacity() * sizeof(PortalNode);
    for (const HpaCluster& c : clusters_) {
        bytes += sizeof(HpaCluster) + c.nodes.capacity() * sizeof(std::uint32_t) +
                 c.cost.capacity() * sizeof(Cost);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
