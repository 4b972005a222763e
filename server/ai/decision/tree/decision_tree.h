// DecisionTree: questions about senses, one after the other, down to an action; flat, and without a
// branch that depends on an answer.
#pragma once

#include "server/ai/decision/senses.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::tree {

inline constexpr std::size_t kMaxNodes = 4096;
inline constexpr std::size_t kMaxDepth = 32;

/// A question, or an answer where `yes` and `no` are both below 0.
struct NodeDef {
    std::string name;
    Condition test;
    int yes = -1;              ///< index of the node that goes on where the test holds
    int no = -1;               ///< and where it does not
    std::uint16_t action = 0;  ///< of an answer
};

struct TreeDef {
    std::string name;
    std::vector<NodeDef> nodes;  ///< begins at the first
};

enum class TreeDefectKind : std::uint8_t {
    kNoNodes,
    kUnknownNode,  ///< leads to no node, or only one of yes and no does
    kUnknownSense,
    kUnreachable,
    kTwoWaysIn,  ///< a node below itself, or below two others: no tree
    kNeverYes,   ///< questions above have answered it: the same way each time
    kNeverNo,
    kTooMany,  ///< beyond kMaxNodes or kMaxDepth
};

struct TreeDefect {
    TreeDefectKind kind = TreeDefectKind::kNoNodes;
    int node = 0;
};

/// Without any, DecisionTree takes it.
std::vector<TreeDefect> defects_of(const TreeDef& def, std::size_t senses);

std::string text_of(const TreeDefect& defect);

/// Both answers to a question stand side by side, so that the answer is added to a place in the
/// table (predicated trees: Asadi, Lin, de Vries, "Runtime optimizations for tree-based machine
/// learning models", IEEE TKDE 26, 2014, section 3.2). Who is down early stays there.
class DecisionTree {
  public:
    DecisionTree(const TreeDef& def, std::size_t senses);

    /// The action of each agent; `actions` has senses.count places.
    void decide(const SenseColumns& senses, std::span<std::uint16_t> actions) const;

    /// The action of one agent that senses `values`.
    [[nodiscard]] std::uint16_t decide(std::span<const float> values) const;

    /// DecisionNode of the definition in which the agent that senses `values` ends; `way` gets
    /// those on the way there.
    std::uint16_t explain(std::span<const float> values, std::vector<std::uint16_t>& way) const;

    [[nodiscard]] std::size_t depth() const { return depth_; }

  private:
    /// The question is value * sign < threshold; an answer is one that is never so and leads to
    /// itself.
    struct DecisionNode {
        float threshold = -1.0F;
        float sign = 0.0F;
        SenseIndex sense = 0;
        std::uint16_t next = 0;  ///< where a no leads; a yes leads one further
        std::uint16_t action = 0;
        std::uint16_t number = 0;  ///< of the definition
    };

    std::size_t depth_ = 0;
    std::size_t senses_ = 0;
    std::vector<DecisionNode> nodes_;
};

}  // namespace zoned::ai::tree
