// GraphHierarchy: nodes of a graph in small groups, and which group next from anywhere to anywhere.
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

/// A graph as others keep it: links out of each node, in compressed rows.
struct NodeGraph {
    std::span<const Vec3> places;            ///< of nodes, m
    std::span<const std::uint32_t> first;    ///< by node, and one more
    std::span<const std::uint32_t> to;       ///< by link
    std::span<const std::uint8_t> open;      ///< by node, whether it is passable
    std::span<const std::uint8_t> linked;    ///< by link, likewise
    std::span<const std::uint32_t> return_;  ///< by link, the one back; kNone: one way
};

/// Groups of up to kMost nodes each of which reaches the others within the group. So who goes from
/// group to group, through each by a search of its few nodes, gets to the goal at a cost that is
/// bounded by the groups on the way, which is near the best one: hierarchical planning as of Botea,
/// Mueller and Schaeffer, "Near optimal hierarchical path-finding", Journal of Game Development 1,
/// 2004.
///
/// Nodes are shared out once, as if all were open; a group is what is joined within such a share.
/// So groups are those of the graph as it is, whatever it was before: who builds them anew gets
/// the same.
class GraphHierarchy {
  public:
    static constexpr std::uint32_t kNone = ~0U;
    static constexpr std::size_t kMost = 32;

    /// Of all passable nodes. Costs as much as a look at every link. Tables to goals are gone.
    void build(const NodeGraph& graph);

    /// After nodes or links of the graph that was built have opened or closed; `touched` are such
    /// nodes and both ends of such links, none twice. The groups of their shares are renewed; the
    /// rest stays as it is. Tables to goals are gone.
    void change(const NodeGraph& graph, std::span<const std::uint32_t> touched);

    /// Groups, and numbers of groups that were given up by a change.
    [[nodiscard]] std::size_t size() const { return count_.size(); }

    /// Makes the table to a goal's group, where there is none: as much as a search of all groups.
    /// True: it was made now.
    bool prepare(std::uint32_t goal);

    [[nodiscard]] bool prepared(std::uint32_t goal) const {
        return cluster_[goal] != kNone && table_round_[cluster_[goal]] == round_;
    }

    /// A node of each group that has a table.
    [[nodiscard]] std::vector<std::uint32_t> prepared() const;

    /// Whether a path leads from a node to the goal. prepared(goal).
    [[nodiscard]] bool joined(std::uint32_t from, std::uint32_t goal) const;

    /// Nodes of a path from a node, without it, to where it enters the next group, or to the goal
    /// in the same one; 0 where there is none. prepared(goal).
    std::size_t segment(const NodeGraph& graph,
                        std::uint32_t from,
                        std::uint32_t goal,
                        std::array<std::uint32_t, kMost + 1>& nodes) const;

    /// Marks the groups that are reached from a node. Costs as much as a look at all groups.
    void flood(std::uint32_t from);

    /// Whether the last flood() has reached the node.
    [[nodiscard]] bool flooded(std::uint32_t node) const {
        return cluster_[node] != kNone && flooded_[cluster_[node]] != 0;
    }

    /// Whether what can be reached from this node may be more than before the last change(): what
    /// links join there, whichever way they lead, was apart before, or there are links that lead
    /// one way only. True before the first change.
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

    /// A link that is not the path back of the one that is its path back.
    struct Stray {
        std::uint32_t to;
        std::uint32_t from;
        std::uint32_t link;
    };

    static constexpr std::uint8_t kDirty = 1;    ///< its links are to be found anew
    static constexpr std::uint8_t kRenewed = 2;  ///< it has other nodes too

    /// Other clusters next to one.
    using Beside = CornerBlock;

    [[nodiscard]] std::span<const std::uint32_t> nodes_of(std::uint32_t cluster) const {
        return {nodes_.data() + cluster * kMost, count_[cluster]};
    }

    /// Shares next to each other that are a block of GraphConnectivity: a change renews some nine
    /// of these, and looks at what joins all of them.
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

    /// The first node of a cluster: what it is called whatever its number.
    [[nodiscard]] std::uint32_t name_of(std::uint32_t cluster) const {
        return nodes_[cluster * kMost];
    }

    std::uint32_t take_number();
    void put(std::uint32_t node, std::uint32_t cluster);
    std::uint32_t gather(const NodeGraph& graph, std::uint32_t seed);
    void dissolve(std::uint32_t cluster);
    void give_up(std::uint32_t cluster);
    void find_middle(const NodeGraph& graph, std::uint32_t cluster);
    /// Clusters that one gets to from this one, and those from which one gets to it.
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
    std::vector<std::uint32_t> free_;  // numbers
    std::vector<Table> tables_;        // by cluster of the goal: the next one, by cluster
    std::vector<std::uint32_t> table_round_;
    std::uint32_t round_ = 1;
    GraphConnectivity parts_;
    std::vector<std::uint8_t> is_one_way_;  // by cluster: reached by another that it doesn't reach
    std::uint32_t one_way_ = 0;             // how many are
    bool were_one_way_ = false;             // some were, before the last change
    bool compared_ = false;                 // by the last change
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
