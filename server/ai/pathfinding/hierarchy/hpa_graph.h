// HpaGraph: a map cut into squares, and the portals between them; a change touches few squares.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/hierarchy/hpa_cluster_costs.h"

#include <array>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Hierarchical planning (HPA*). A portal is a pair of cells on either side of a border. Portals
/// are at most kSpacing cells apart where the border can be crossed. Within a square the best costs
/// between its portals are stored. Paths through portals are nearly the best. Source: Botea,
/// Mueller and Schaeffer, "Near optimal hierarchical path-finding", Journal of Game Development 1,
/// 2004.
class HpaGraph {
  public:
    static constexpr int kSide = HpaClusterCosts::kSide;  ///< side of a square, cells
    static constexpr int kSpacing = 6;  ///< of portals along a border, at most, cells

    explicit HpaGraph(const GridMap& map);

    /// Updates after `changes` to the map. It renews the squares of the changed cells, and the
    /// squares across a border whose portals have changed. The rest costs nothing, however large
    /// the map is.
    void update(const GridMap& map, std::span<const CellChange> changes);

    /// Lists cells of a good path from start to goal, both included. Neighbours in the list are in
    /// one square or in two adjacent squares. False where there is no path, or query.max_work is
    /// exceeded. Start and goal must be passable.
    bool run(const GridMap& map,
             const GridQuery& query,
             std::vector<Cell>& through,
             std::uint32_t& work);

    [[nodiscard]] std::size_t portals() const { return portals_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// The sides of a square.
    enum ClusterSide : std::uint32_t {
        kAbove,
        kLeft,
        kRight,
        kBelow,
        kSides
    };

    /// Two portals of a side are never adjacent.
    static constexpr std::uint32_t kMostOfSide = kSide / 2;
    static constexpr std::uint32_t kMostOfCluster = kSides * kMostOfSide;

    /// The portals of a cluster on its side of the borders. Their numbers depend on the cluster and
    /// the side alone, so a change leaves the numbers of other portals alone.
    struct HpaCluster {
        std::array<std::uint8_t, kSides> count{};
        std::vector<std::uint32_t> nodes;  ///< numbers, ascending
        std::vector<Cost> cost;            ///< between its nodes, row by row
    };

    struct PortalNode {
        Cell cell;
        std::uint32_t local = 0;  ///< place in its cluster's list
    };

    [[nodiscard]] std::uint32_t cluster_of(Cell c) const {
        return c.y / kSide * across_ + c.x / kSide;
    }

    /// Finds the cells of both sides of a border, kRight or kBelow. True: they have changed.
    bool find_portals(const GridMap& map, std::uint32_t cluster, ClusterSide side);
    void list_nodes(std::uint32_t cluster);

    [[nodiscard]] static std::uint32_t first_node(std::uint32_t cluster, ClusterSide side) {
        return cluster * kMostOfCluster + side * kMostOfSide;
    }

    /// The cluster across a border.
    [[nodiscard]] std::uint32_t beyond(std::uint32_t cluster, ClusterSide side) const {
        const std::array<std::uint32_t, kSides> by{~across_ + 1, ~0U, 1, across_};
        return cluster + by[side];
    }

    /// The node across the border.
    [[nodiscard]] std::uint32_t twin(std::uint32_t node) const {
        const auto side = static_cast<ClusterSide>(node / kMostOfSide % kSides);
        const auto other = static_cast<ClusterSide>(kSides - 1 - side);
        return first_node(beyond(node / kMostOfCluster, side), other) + node % kMostOfSide;
    }

    void measure(const GridMap& map, std::uint32_t cluster);
    [[nodiscard]] FlowField::Window window(const GridMap& map, std::uint32_t cluster) const;
    void open_ends(const GridMap& map, const GridQuery& query);
    void reach(std::uint32_t node, Cost cost, std::uint32_t from, Cell goal);

    std::uint32_t across_;
    std::uint32_t down_;
    std::vector<HpaCluster> clusters_;
    std::vector<PortalNode> nodes_;  // by number; each cluster has room for kMostOfCluster
    std::size_t portals_ = 0;
    SearchSpace space_;  // for nodes, and the goal as the last one
    FlowField field_;
    HpaClusterCosts square_;
    std::vector<Cell> cells_;  // cells of the nodes of the present cluster
    std::vector<std::uint32_t> touched_;
    std::vector<Cost> to_goal_;  // costs from the nodes in the goal's cluster
    Cost direct_ = kNoCost;      // cost from start to goal within one cluster
};

}  // namespace zoned::ai::pathfinding
