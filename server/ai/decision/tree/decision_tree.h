// DecisionTree: a flat, branch-free tree of questions about senses that leads to an action.
#pragma once

#include "server/ai/decision/senses.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::tree {

inline constexpr std::size_t kMaxNodes = 4096;
inline constexpr std::size_t kMaxDepth = 32;

/// NodeDef: a question, or an answer where `yes` and `no` are both below 0.
struct NodeDef {
    std::string name;
    Condition test;
    int yes = -1;              ///< index of the next node where the test holds
    int no = -1;               ///< index of the next node where it does not hold
    std::uint16_t action = 0;  ///< the action of an answer
};

struct TreeDef {
    std::string name;
    std::vector<NodeDef> nodes;  ///< the first is the root
};

enum class TreeDefectKind : std::uint8_t {
    kNoNodes,
    kUnknownNode,  ///< leads to no node, or has only one of yes and no
    kUnknownSense,
    kUnreachable,
    kTwoWaysIn,  ///< leads to a node above itself, or to one below two others: no tree
    kNeverYes,   ///< the questions above have already answered it, always the same
    kNeverNo,
    kTooMany,  ///< beyond kMaxNodes or kMaxDepth
};

struct TreeDefect {
    TreeDefectKind kind = TreeDefectKind::kNoNodes;
    int node = 0;
};

/// All defects of `def`. A definition without any is accepted by DecisionTree.
std::vector<TreeDefect> defects_of(const TreeDef& def, std::size_t senses);

std::string text_of(const TreeDefect& defect);

/// Both answers to a question stand side by side, so that the result of the test is added to a
/// table index. An agent that reaches its answer early stays there. Source for predicated trees:
/// Asadi, Lin, de Vries, "Runtime optimizations for tree-based machine learning models", IEEE TKDE
/// 26, 2014, section 3.2.
class DecisionTree {
  public:
    DecisionTree(const TreeDef& def, std::size_t senses);

    /// The action of an agent that senses `values`.
    [[nodiscard]] std::uint16_t decide(std::span<const float> values) const;

    /// The node of the definition in which the agent that senses `values` ends. `way` gets the
    /// nodes on the path there.
    std::uint16_t explain(std::span<const float> values, std::vector<std::uint16_t>& way) const;

  private:
    /// The question is value * sign < threshold. An answer is a question that is never true and
    /// leads to itself.
    struct DecisionNode {
        float threshold = -1.0F;
        float sign = 0.0F;
        SenseIndex sense = 0;
        std::uint16_t next = 0;  ///< the node for a no; the node for a yes is the next one
        std::uint16_t action = 0;
        std::uint16_t number = 0;  ///< number in the definition
    };

    std::vector<DecisionNode> nodes_;
};

}  // namespace zoned::ai::tree
