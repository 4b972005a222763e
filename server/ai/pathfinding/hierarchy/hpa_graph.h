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

/// Hierarchical planning (Botea, Mueller and Schaeffer, "Near optimal hierarchical path-finding",
/// Journal of Game Development 1, 2004): pairs of cells on either side of a border are portals,
/// at most kSpacing cells apart where it can be crossed; within a square the best costs between its
/// portals are known. Paths through portals are not the best, but nearly.
class HpaGraph {
  public:
    static constexpr int kSide = HpaClusterCosts::kSide;  ///< of a square, cells
    static constexpr int kSpacing = 6;  ///< of portals along a border, cells at most

    explicit HpaGraph(const GridMap& map);

    /// After `changes` were made to the map: renews the squares that they lie in, and those across
    /// a border whose portals are others now; the rest costs nothing, however large the map is.
    void update(const GridMap& map, std::span<const CellChange> changes);

    /// Cells from start to goal, these two among them, that a good path goes through; neighbours in
    /// the list are in one square or in two next to each other. False where there is none, or
    /// query.max_work is exceeded. Start and goal are passable.
    bool run(const GridMap& map,
             const GridQuery& query,
             std::vector<Cell>& through,
             std::uint32_t& work);

    [[nodiscard]] std::size_t portals() const { return portals_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// Sides of a square.
    enum ClusterSide : std::uint32_t {
        kAbove,
        kLeft,
        kRight,
        kBelow,
        kSides
    };

    /// Two portals of a side don't lie next to each other.
    static constexpr std::uint32_t kMostOfSide = kSide / 2;
    static constexpr std::uint32_t kMostOfCluster = kSides * kMostOfSide;

    /// The portals of a cluster on its side of the borders. Their numbers hang on the cluster and
    /// the side alone, so that a change leaves the others theirs.
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

    /// The cells of both sides of a border, kRight or kBelow. True: they are others than before.
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
    std::vector<PortalNode> nodes_;  // by number; room for kMostOfCluster of each cluster
    std::size_t portals_ = 0;
    SearchSpace space_;  // nodes, then the goal
    FlowField field_;
    HpaClusterCosts square_;
    std::vector<Cell> cells_;  // of the nodes of the cluster that is looked at
    std::vector<std::uint32_t> touched_;
    std::vector<Cost> to_goal_;  // of the nodes in the goal's cluster
    Cost direct_ = kNoCost;      // from start to goal within one cluster
};

}  // namespace zoned::ai::pathfinding
