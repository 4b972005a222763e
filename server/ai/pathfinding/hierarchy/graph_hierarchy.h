// GraphHierarchy: a graph's nodes in small groups, and the next group from anywhere to any goal.
#pragma once

#include "server/ai/pathfinding/grid/corner_pool.h"
#include "server/ai/pathfinding/grid/search_heap.h"
#include "server/ai/pathfinding/hierarchy/graph_connectivity.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

/// NodeGraph: a view of a graph that others keep, with the links out of each node in compressed
/// rows.
struct NodeGraph {
    std::span<const Vec3> places;            ///< of nodes, m
    std::span<const std::uint32_t> first;    ///< by node, and one more
    std::span<const std::uint32_t> to;       ///< by link
    std::span<const std::uint8_t> open;      ///< by node, whether it is passable
    std::span<const std::uint8_t> linked;    ///< by link, whether it is passable
    std::span<const std::uint32_t> return_;  ///< by link, the reverse link; kNone: the link has one
                                             ///< direction only
};

/// Groups of up to kMost nodes each of which reaches the others within the group. A walker goes
/// from group to group, through each by a search of its few nodes. The groups passed bound its
/// cost, which is near the best one. Source for hierarchical planning: Botea, Mueller and
/// Schaeffer, "Near optimal hierarchical path-finding", Journal of Game Development 1, 2004.
///
/// Nodes are divided into shares once, as if all were open. A group is a joined part of such a
/// share. So groups depend only on the graph as it is, whatever it was before: building them anew
/// gives the same groups.
class GraphHierarchy {
  public:
    static constexpr std::uint32_t kNone = ~0U;
    static constexpr std::size_t kMost = 32;

    /// Builds the groups of all passable nodes. Costs as much as a look at every link. Drops the
    /// tables to goals.
    void build(const NodeGraph& graph);

    /// Updates after nodes or links of the built graph have opened or closed. `touched` are such
    /// nodes and both ends of such links, none twice. The groups of their shares are renewed; the
    /// rest stays as it is. Drops the tables to goals.
    void change(const NodeGraph& graph, std::span<const std::uint32_t> touched);

    /// The number of groups, with the unused numbers of groups that a change gave up.
    [[nodiscard]] std::size_t size() const { return count_.size(); }

    /// Makes the table to a goal's group, where there is none. It costs as much as a search of all
    /// groups. True: it was made now.
    bool prepare(std::uint32_t goal);

    [[nodiscard]] bool prepared(std::uint32_t goal) const {
        return cluster_[goal] != kNone && table_round_[cluster_[goal]] == round_;
    }

    /// A node of each group that has a table.
    [[nodiscard]] std::vector<std::uint32_t> prepared() const;

    /// True if a path leads from a node to the goal. prepared(goal) must hold.
    [[nodiscard]] bool joined(std::uint32_t from, std::uint32_t goal) const;

    /// The nodes of a path from a node (left out) to its entry into the next group, or to a goal in
    /// the same group. Returns their number; 0 where there is none. prepared(goal) must hold.
    std::size_t segment(const NodeGraph& graph,
                        std::uint32_t from,
                        std::uint32_t goal,
                        std::array<std::uint32_t, kMost + 1>& nodes) const;

    /// Marks the groups that can be reached from a node. Costs as much as a look at all groups.
    void flood(std::uint32_t from);

    /// True if the last flood() has reached the node.
    [[nodiscard]] bool flooded(std::uint32_t node) const {
        return cluster_[node] != kNone && flooded_[cluster_[node]] != 0;
    }

    /// True if more may be reachable from this node than before the last change(). Either links of
    /// any direction now join parts that were apart, or some links have one direction only. True
    /// before the first change.
    [[nodiscard]] bool joined_anew(std::uint32_t node) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    using Table = std::vector<std::uint16_t>;
    static constexpr std::uint16_t kNowhere = 0xFFFF;

    struct OpenGroup {
        float key;           ///< cost
        std::uint32_t node;  ///< its name
        std::uint32_t cluster;
    };

    /// A link whose reverse link does not have it as its own reverse link.
    struct Stray {
        std::uint32_t to;
        std::uint32_t from;
        std::uint32_t link;
    };

    static constexpr std::uint8_t kDirty = 1;    ///< its links have to be found anew
    static constexpr std::uint8_t kRenewed = 2;  ///< its nodes have changed too

    /// The other clusters next to one cluster.
    using Beside = CornerBlock;

    [[nodiscard]] std::span<const std::uint32_t> nodes_of(std::uint32_t cluster) const {
        return {nodes_.data() + cluster * kMost, count_[cluster]};
    }

    /// Shares next to each other that form a block of GraphConnectivity. A change renews some nine
    /// of these, and then looks at the joints of all blocks.
    static constexpr std::uint32_t kSharesOfBlock = 64;

    void find_strays(const NodeGraph& graph);
    void share_out(const NodeGraph& graph);
    void share_out_blocks(const NodeGraph& graph);

    [[nodiscard]] std::span<const std::uint32_t> nodes_of_share(std::uint32_t share) const {
        return {share_nodes_.data() + first_share_[share],
                share_nodes_.data() + first_share_[share + 1]};
    }

    [[nodiscard]] std::uint32_t block_of(std::uint32_t cluster) const {
        return share_block_[share_[name_of(cluster)]];
    }

    /// The first node of a cluster: its name, whatever its number.
    [[nodiscard]] std::uint32_t name_of(std::uint32_t cluster) const {
        return nodes_[cluster * kMost];
    }

    std::uint32_t take_number();
    void put(std::uint32_t node, std::uint32_t cluster);
    std::uint32_t gather(const NodeGraph& graph, std::uint32_t seed);
    void dissolve(std::uint32_t cluster);
    void give_up(std::uint32_t cluster);
    void find_middle(const NodeGraph& graph, std::uint32_t cluster);
    /// Finds the clusters that this one leads to, and those that lead to it.
    void link(const NodeGraph& graph, std::uint32_t cluster);
    void mark_dirty(std::uint32_t cluster);
    void mark_renewed(std::uint32_t cluster);
    void mark_beside_dirty(std::uint32_t cluster);
    void renew_parts();
    void note_one_way(std::uint32_t cluster, bool one_way);
    void remember_parts(const NodeGraph& graph, std::span<const std::uint32_t> touched);
    void compare_parts();

    std::vector<std::uint32_t> share_;        // by node
    std::vector<std::uint32_t> first_share_;  // by share, and one more
    std::vector<std::uint32_t> share_nodes_;  // ascending
    std::vector<std::uint32_t> share_block_;  // by share
    std::uint32_t blocks_ = 0;
    std::vector<std::uint32_t> cluster_;  // by node
    std::vector<std::uint8_t> within_;    // by node, its number within its cluster
    std::vector<Stray> strays_;           // ascending by target
    std::vector<std::uint8_t> count_;     // by cluster; 0: given up
    std::vector<std::uint32_t> nodes_;    // room for kMost of each cluster
    std::vector<Vec3> middle_;            // by cluster
    std::vector<Beside> in_;              // by cluster, within beside_
    std::vector<Beside> out_;
    BlockPool<std::uint32_t> beside_;
    std::vector<std::uint32_t> free_;  // unused numbers
    std::vector<Table> tables_;        // by cluster of the goal: the next cluster, by cluster
    std::vector<std::uint32_t> table_round_;
    std::uint32_t round_ = 1;
    GraphConnectivity parts_;
    std::vector<std::uint8_t> is_one_way_;  // by cluster: another cluster reaches it and it does
                                            // not reach that one
    std::uint32_t one_way_ = 0;             // number of one-way clusters
    bool were_one_way_ = false;             // some were one-way before the last change
    bool compared_ = false;                 // set by the last change
    std::vector<std::pair<std::uint32_t, std::uint32_t>> touched_;  // node, part before; then after
    std::vector<std::uint32_t> joined_;                             // parts, ascending
    std::vector<std::uint8_t> is_dirty_;                            // by cluster, during a change
    std::vector<std::uint32_t> dirty_;
    std::vector<std::uint32_t> loose_;  // nodes, during a change
    std::vector<std::uint32_t> links_;
    std::vector<float> cost_;
    SearchHeap<OpenGroup> open_;
    std::vector<std::uint8_t> flooded_;
    std::vector<std::uint32_t> queue_;
};

}  // namespace zoned::ai::pathfinding
