// NodeClusters: nodes of a graph in small groups, and which group next from anywhere to anywhere.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::navigation {

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
class NodeClusters {
  public:
    static constexpr std::uint32_t kNone = ~0U;
    static constexpr std::size_t kMost = 32;

    /// Of all passable nodes. Costs as much as a look at every link. Tables to goals are gone.
    void build(const NodeGraph& graph);

    [[nodiscard]] std::size_t size() const { return first_node_.size() - 1; }

    /// Makes the table to a goal's group, where there is none: as much as a search of all groups.
    /// True: it was made now.
    bool prepare(std::uint32_t goal);

    [[nodiscard]] bool prepared(std::uint32_t goal) const {
        return cluster_[goal] != kNone && !tables_[cluster_[goal]].empty();
    }

    /// A node of each group that has a table.
    [[nodiscard]] std::vector<std::uint32_t> prepared() const;

    /// Whether a way leads from a node to the goal. prepared(goal).
    [[nodiscard]] bool joined(std::uint32_t from, std::uint32_t goal) const;

    /// Nodes of a way from a node, without it, to where it enters the next group, or to the goal in
    /// the same one; 0 where there is none. prepared(goal).
    std::size_t leg(const NodeGraph& graph,
                    std::uint32_t from,
                    std::uint32_t goal,
                    std::array<std::uint32_t, kMost + 1>& nodes) const;

    /// Marks the groups that are reached from a node. Costs as much as a look at all groups.
    void flood(std::uint32_t from);

    /// Whether the last flood() has reached the node.
    [[nodiscard]] bool flooded(std::uint32_t node) const {
        return cluster_[node] != kNone && flooded_[cluster_[node]] != 0;
    }

    [[nodiscard]] std::size_t bytes() const;

  private:
    using Table = std::vector<std::uint16_t>;
    static constexpr std::uint16_t kNowhere = 0xFFFF;

    struct Open {
        float cost;
        std::uint32_t cluster;
    };

    void gather(const NodeGraph& graph, std::uint32_t seed);
    void link_clusters(const NodeGraph& graph);

    std::vector<std::uint32_t> cluster_;     // by node
    std::vector<std::uint8_t> within_;       // by node, its number within its cluster
    std::vector<std::uint32_t> first_node_;  // by cluster, and one more
    std::vector<std::uint32_t> nodes_;
    std::vector<Vec3> middle_;               // by cluster
    std::vector<std::uint32_t> first_link_;  // by cluster, and one more: clusters that lead there
    std::vector<std::uint32_t> from_;
    std::vector<std::uint32_t> first_out_;  // and those that one gets to from there
    std::vector<std::uint32_t> out_;
    std::vector<Table> tables_;  // by cluster of the goal: the next one, by cluster
    std::vector<std::uint64_t> pairs_;
    std::vector<float> cost_;
    std::vector<Open> open_;
    std::vector<std::uint8_t> flooded_;
    std::vector<std::uint32_t> queue_;
};

}  // namespace zoned::ai::navigation
