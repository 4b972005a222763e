#include "server/ai/decision/tree/decision_tree.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <limits>

namespace zoned::ai::tree::test {
namespace {

using testing::ElementsAre;

NodeDef ask(SenseIndex sense, Compare compare, float threshold, int yes, int no) {
    return {"", {sense, compare, threshold}, yes, no, 0};
}

NodeDef answer(std::uint16_t action) {
    return {"", {}, -1, -1, action};
}

/// Foe near? Strong? fight (1), else flee (2). Far: hungry? eat (3), else rest (4).
TreeDef choice_def() {
    return {"choice",
            {ask(0, Compare::kBelow, 10, 1, 2),
             ask(1, Compare::kAbove, 0.5F, 3, 4),
             ask(2, Compare::kAbove, 0.7F, 5, 6),
             answer(1),
             answer(2),
             answer(3),
             answer(4)}};
}

std::uint16_t decide(const TreeDef& def, const std::vector<float>& values) {
    return DecisionTree(def, values.size()).decide(values);
}

TEST(DecisionTree, GivesTheAnswersComputedByHand) {
    const TreeDef def = choice_def();
    EXPECT_EQ(decide(def, {5, 0.6F, 0}), 1);
    EXPECT_EQ(decide(def, {5, 0.5F, 1}), 2);
    EXPECT_EQ(decide(def, {10, 0.6F, 0.8F}), 3);
    EXPECT_EQ(decide(def, {20, 0.6F, 0.7F}), 4);
}

TEST(DecisionTree, AnswersNoForWhatIsNoNumber) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(decide(choice_def(), {nan, nan, nan}), 4);
}

TEST(DecisionTree, IsAnAnswerWithoutAQuestionToo) {
    EXPECT_EQ(decide({"t", {answer(9)}}, {1}), 9);
}

TEST(DecisionTree, ExplainsItsWay) {
    std::vector<std::uint16_t> way;
    const float values[] = {5, 0.5F, 1};
    EXPECT_EQ(DecisionTree(choice_def(), 3).explain(values, way), 4);
    EXPECT_THAT(way, ElementsAre(0, 1));
}

/// Grows a tree at random; each node asks one of four senses.
int grow(TreeDef& def, core::Rng& rng, int depth) {
    const auto at = static_cast<int>(def.nodes.size());
    if (depth == 0 || rng.below(5) == 0) {
        def.nodes.push_back(answer(static_cast<std::uint16_t>(rng.below(1000))));
        return at;
    }
    def.nodes.push_back(ask(static_cast<SenseIndex>(rng.below(4)),
                            rng.below(2) == 0 ? Compare::kBelow : Compare::kAbove,
                            rng.range(0, 1),
                            0,
                            0));
    const int yes = grow(def, rng, depth - 1);
    const int no = grow(def, rng, depth - 1);
    def.nodes[static_cast<std::size_t>(at)].yes = yes;
    def.nodes[static_cast<std::size_t>(at)].no = no;
    return at;
}

TEST(DecisionTree, AgreesWithAWalkThroughTheDefinition) {
    core::Rng rng(61);
    constexpr int kCount = 500;
    int compared = 0;
    while (compared < 20) {
        TreeDef def;
        grow(def, rng, 6);
        if (!defects_of(def, 4).empty()) {
            continue;  // asks for a known answer
        }
        ++compared;
        const DecisionTree tree(def, 4);
        for (int i = 0; i < kCount; ++i) {
            float values[4];
            for (float& value : values) {
                value = rng.range(0, 1);
            }
            std::size_t at = 0;
            while (def.nodes[at].yes >= 0) {
                const Condition& test = def.nodes[at].test;
                at = static_cast<std::size_t>(holds(test, values[test.sense]) ? def.nodes[at].yes
                                                                              : def.nodes[at].no);
            }
            ASSERT_EQ(tree.decide(values), def.nodes[at].action);
        }
    }
}

std::vector<TreeDefectKind> kinds(const TreeDef& def) {
    std::vector<TreeDefectKind> kinds;
    for (const TreeDefect& defect : defects_of(def, 3)) {
        kinds.push_back(defect.kind);
    }
    return kinds;
}

TEST(TreeDefects, AreEachFound) {
    EXPECT_TRUE(kinds(choice_def()).empty());
    EXPECT_THAT(kinds({"t", {}}), ElementsAre(TreeDefectKind::kNoNodes));
    TreeDef def = choice_def();
    def.nodes[2].no = -1;
    EXPECT_THAT(
        kinds(def),
        testing::UnorderedElementsAre(TreeDefectKind::kUnknownNode, TreeDefectKind::kUnreachable));
    def = choice_def();
    def.nodes[2].test.sense = 3;
    EXPECT_THAT(kinds(def), ElementsAre(TreeDefectKind::kUnknownSense));
    def = choice_def();
    def.nodes[2].no = 0;
    EXPECT_THAT(
        kinds(def),
        testing::UnorderedElementsAre(TreeDefectKind::kTwoWaysIn, TreeDefectKind::kUnreachable));
    def = choice_def();
    def.nodes[1].test = {0, Compare::kBelow, 12};
    EXPECT_THAT(kinds(def), ElementsAre(TreeDefectKind::kNeverNo));
    def.nodes[1].test = {0, Compare::kAbove, 10};
    EXPECT_THAT(kinds(def), ElementsAre(TreeDefectKind::kNeverYes));
    def.nodes[1].test = {0, Compare::kAbove, 9};
    EXPECT_TRUE(kinds(def).empty());
    TreeDef deep{"deep", {answer(0)}};
    for (int level = 0; level < 40; ++level) {
        const auto last = static_cast<int>(deep.nodes.size());
        deep.nodes.insert(deep.nodes.begin(),
                          ask(0, Compare::kBelow, static_cast<float>(-level), 1, last + 1));
        for (std::size_t n = 1; n < deep.nodes.size(); ++n) {
            if (deep.nodes[n].yes >= 0) {
                ++deep.nodes[n].yes;
                ++deep.nodes[n].no;
            }
        }
        deep.nodes.push_back(answer(1));
    }
    EXPECT_THAT(kinds(deep), testing::Contains(TreeDefectKind::kTooMany));
}

}  // namespace
}  // namespace zoned::ai::tree::test
