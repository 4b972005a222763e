#include "server/ai/decision/tree/decision_tree.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::tree {

namespace {

bool is_answer(const NodeDef& node) {
    return node.yes < 0 && node.no < 0;
}

/// Walks down all branches, and keeps the bounds that the answers above have set.
class TreeInspection {
  public:
    TreeInspection(const TreeDef& def, std::size_t senses)
        : def_(def),
          senses_(senses),
          ways_in_(def.nodes.size(), 0) {}

    std::vector<TreeDefect> run() {
        if (def_.nodes.empty()) {
            add(TreeDefectKind::kNoNodes, 0);
            return std::move(found_);
        }
        if (def_.nodes.size() > kMaxNodes) {
            add(TreeDefectKind::kTooMany, static_cast<int>(kMaxNodes));
        }
        ways_in_[0] = 1;
        walk(0, 1);
        for (std::size_t n = 0; n < def_.nodes.size(); ++n) {
            if (ways_in_[n] == 0) {
                add(TreeDefectKind::kUnreachable, static_cast<int>(n));
            }
        }
        return std::move(found_);
    }

  private:
    struct Known {
        Condition test;
        bool yes;
    };

    void add(TreeDefectKind kind, int node) { found_.push_back({kind, node}); }

    void walk(int at, std::size_t depth) {
        const NodeDef& node = def_.nodes[static_cast<std::size_t>(at)];
        if (is_answer(node)) {
            return;
        }
        if (depth == kMaxDepth) {
            add(TreeDefectKind::kTooMany, at);
            return;
        }
        if (node.test.sense >= senses_) {
            add(TreeDefectKind::kUnknownSense, at);
        }
        judge(at, node.test);
        known_.push_back({node.test, true});
        step(at, node.yes, depth);
        known_.back().yes = false;
        step(at, node.no, depth);
        known_.pop_back();
    }

    void step(int from, int to, std::size_t depth) {
        if (to < 0 || static_cast<std::size_t>(to) >= def_.nodes.size()) {
            add(TreeDefectKind::kUnknownNode, from);
        } else if (++ways_in_[static_cast<std::size_t>(to)] > 1) {
            add(TreeDefectKind::kTwoWaysIn, to);
        } else {
            walk(to, depth + 1);
        }
    }

    /// The known bounds of the value: below an upper end, or not below a lower one.
    void judge(int at, const Condition& test) {
        for (const Known& known : known_) {
            if (known.test.sense != test.sense) {
                continue;
            }
            const float a = known.test.threshold;
            const float b = test.threshold;
            const bool below = test.compare == Compare::kBelow;
            const bool known_below = known.test.compare == Compare::kBelow;
            if (known_below == known.yes) {  // value < a, or value <= a
                const bool strict = known_below;
                if (below ? a <= b && (strict || a < b) : a <= b) {
                    add(below ? TreeDefectKind::kNeverNo : TreeDefectKind::kNeverYes, at);
                    return;
                }
            } else {  // value > a, or value >= a
                const bool strict = !known_below;
                if (below ? a >= b : a >= b && (strict || a > b)) {
                    add(below ? TreeDefectKind::kNeverYes : TreeDefectKind::kNeverNo, at);
                    return;
                }
            }
        }
    }

    const TreeDef& def_;
    std::size_t senses_;
    std::vector<int> ways_in_;
    std::vector<Known> known_;
    std::vector<TreeDefect> found_;
};

}  // namespace

std::vector<TreeDefect> defects_of(const TreeDef& def, std::size_t senses) {
    return TreeInspection(def, senses).run();
}

std::string text_of(const TreeDefect& defect) {
    switch (defect.kind) {
        case TreeDefectKind::kNoNodes:
            return "a tree needs at least one node";
        case TreeDefectKind::kUnknownNode:
            return "leads to a node that does not exist";
        case TreeDefectKind::kUnknownSense:
            return "reads a sense that these agents do not have";
        case TreeDefectKind::kUnreachable:
            return "is never reached: no question leads here";
        case TreeDefectKind::kTwoWaysIn:
            return "is reached in two ways, which makes it no tree";
        case TreeDefectKind::kNeverYes:
            return "is always answered no: a question above leaves nothing else";
        case TreeDefectKind::kNeverNo:
            return "is always answered yes: a question above leaves nothing else";
        case TreeDefectKind::kTooMany:
            return "is one too many: at most " + std::to_string(kMaxNodes) + " nodes, " +
                   std::to_string(kMaxDepth) + " deep";
    }
    return "is wrong";
}

DecisionTree::DecisionTree(const TreeDef& def, std::size_t senses) {
    ZONED_ASSERT(defects_of(def, senses).empty(), "a tree without defects is compiled");
    // Level by level: siblings come out side by side.
    std::vector<std::size_t> line{0};
    for (std::size_t at = 0; at < line.size(); ++at) {
        const NodeDef& from = def.nodes[line[at]];
        DecisionNode node;
        node.number = static_cast<std::uint16_t>(line[at]);
        node.action = from.action;
        node.next = static_cast<std::uint16_t>(at);
        if (!is_answer(from)) {
            node.sign = from.test.compare == Compare::kBelow ? 1.0F : -1.0F;
            node.threshold = from.test.threshold * node.sign;
            node.sense = from.test.sense;
            node.next = static_cast<std::uint16_t>(line.size());
            line.push_back(static_cast<std::size_t>(from.no));
            line.push_back(static_cast<std::size_t>(from.yes));
        }
        nodes_.push_back(node);
    }
}

std::uint16_t DecisionTree::decide(std::span<const float> values) const {
    std::size_t at = 0;
    while (nodes_[at].next != at) {
        const DecisionNode& node = nodes_[at];
        at = node.next + static_cast<std::size_t>(values[node.sense] * node.sign < node.threshold);
    }
    return nodes_[at].action;
}

std::uint16_t DecisionTree::explain(std::span<const float> values,
                                    std::vector<std::uint16_t>& way) const {
    way.clear();
    std::size_t at = 0;
    while (nodes_[at].next != at) {
        const DecisionNode& node = nodes_[at];
        way.push_back(node.number);
        at = node.next + static_cast<std::size_t>(values[node.sense] * node.sign < node.threshold);
    }
    return nodes_[at].number;
}

}  // namespace zoned::ai::tree
