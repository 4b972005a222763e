// ClusterGraph: a map cut into squares, and the portals between them; a change touches few squares.
#pragma once

#include "server/ai/navigation/goal_field.h"
#include "server/ai/navigation/open_list.h"
#include "server/ai/navigation/query.h"

#include <span>
#include <vector>

namespace zoned::ai::navigation {

/// Hierarchical planning (Botea, Mueller and Schaeffer, "Near optimal hierarchical path-finding",
/// Journal of Game Development 1, 2004): pairs of cells on either side of a border are portals,
/// at most kSpacing cells apart where it can be crossed; within a square the best costs between its
/// portals are known. Ways through portals are not the best, but nearly.
class ClusterGraph {
  public:
    static constexpr int kSide = 32;    ///< of a square, cells
    static constexpr int kSpacing = 6;  ///< of portals along a border, cells at most

    explicit ClusterGraph(const GridMap& map);

    /// After `changes` were made to the map: renews the squares that they touch.
    void update(const GridMap& map, std::span<const CellChange> changes);

    /// Cells from start to goal, these two among them, that a good way goes through; neighbours in
    /// the list are in one square or in two next to each other. False where there is none, or
    /// query.max_work is exceeded. Start and goal are passable.
    bool run(const GridMap& map,
             const Query& query,
             std::vector<Cell>& through,
             std::uint32_t& work);

    [[nodiscard]] std::size_t portals() const { return nodes_.size() / 2; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    struct Node {
        Cell cell;
        std::uint32_t cluster = 0;
        std::uint32_t local = 0;  ///< place in its cluster's list
        std::uint32_t twin = 0;   ///< across the border
    };

    struct Cluster {
        std::vector<Cell> right;           ///< portals on its right border, and below it: the cells
        std::vector<Cell> below;           ///< on this side
        std::vector<std::uint32_t> nodes;  ///< numbers
        std::vector<Cost> cost;            ///< between its nodes, row by row
    };

    [[nodiscard]] std::uint32_t cluster_of(Cell c) const {
        return c.y / kSide * across_ + c.x / kSide;
    }

    /// True: they are others than before.
    bool find_portals(const GridMap& map, std::uint32_t cluster, bool right);
    void number_nodes();
    void measure(const GridMap& map, std::uint32_t cluster);
    [[nodiscard]] GoalField::Window window(const GridMap& map, std::uint32_t cluster) const;
    void open_ends(const GridMap& map, const Query& query);
    void reach(std::uint32_t node, Cost cost, std::uint32_t from, Cell goal);

    std::uint32_t across_;
    std::uint32_t down_;
    std::vector<Cluster> clusters_;
    std::vector<Node> nodes_;
    SearchSpace space_;  // nodes, then the goal
    GoalField field_;
    std::vector<Cell> old_portals_;  // of the border that is looked at
    std::vector<Cost> to_goal_;      // of the nodes in the goal's cluster
    Cost direct_ = kNoCost;          // from start to goal within one cluster
};

}  // namespace zoned::ai::navigation
