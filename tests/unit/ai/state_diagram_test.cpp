#include "server/ai/decision/state_machine/state_diagram.h"

#include "tests/scenario/villager.h"

#include <gmock/gmock.h>

namespace zoned::ai::state_machine::test {
namespace {

using testing::HasSubstr;

const std::string kSenseNames[] = {"alarm", "foe", "hunger", "load"};

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) {
        ++n;
    }
    return n;
}

TEST(Diagram, ShowsEveryStateAndTransition) {
    const std::string dot = dot_of(scenario::villager_def(), kSenseNames);
    EXPECT_EQ(count(dot, "subgraph"), 4U);  // day, labour, danger, fight
    // Innermost states, two transitions of each state, tabs of state machines as states.
    EXPECT_EQ(count(dot, "[label="), 8U + 24U + 4U);
    EXPECT_EQ(count(dot, "[style=dashed]"), 5U);  // where the five state machines begin
    EXPECT_THAT(dot,
                HasSubstr("\"day/labour/fetch\" -> \"day/labour/carry\" [label=\"load > 0.8\"]"));
    EXPECT_THAT(dot, HasSubstr("\"danger\" -> \"day\" [label=\"alarm < 0.5 and foe > 6\"]"));
    EXPECT_THAT(dot, HasSubstr("\"day\" [label=\"day (H*)\", shape=tab"));
    EXPECT_THAT(dot, HasSubstr("\"day/labour\" [label=\"labour (H)\", shape=tab"));
    EXPECT_THAT(dot, HasSubstr("time in state > 60"));
}

TEST(Diagram, ShowsHolds) {
    const std::string dot = dot_of(scenario::sentry_def(), kSenseNames);
    EXPECT_THAT(dot, HasSubstr("[label=\"alarm < 20 for 0.3 s\"]"));
}

TEST(Diagram, QuotesNames) {
    StateMachineDef def{"a\"b", {{"c\\d", 0, {}, {}, {}}}};
    EXPECT_THAT(dot_of(def, kSenseNames), HasSubstr("digraph \"a\\\"b\" {"));
    EXPECT_THAT(dot_of(def, kSenseNames), HasSubstr("\"c\\\\d\""));
}

}  // namespace
}  // namespace zoned::ai::state_machine::test
