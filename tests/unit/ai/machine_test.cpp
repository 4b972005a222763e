#include "server/ai/machine.h"

#include "server/ai/decision.h"
#include "server/ai/why.h"
#include "tests/unit/ai/field.h"

#include <gmock/gmock.h>

namespace zoned::ai::test {
namespace {

using testing::HasSubstr;

constexpr SenseIndex kHunger = kOwnSenses;
constexpr SenseIndex kBread = kOwnSenses + 1;

/// at_home { rest, eat }, out: hungry as time goes by, fed by eating bread.
Machine eater() {
    Machine machine;
    machine.name = "eater";
    machine.decide_every_s = 1.0F;
    machine.variables = {{"hunger", 0.25F, 0.01F, 0.0F, 1.0F}, {"bread", 3.0F, 0.0F, 0.0F, 10.0F}};
    State rest;
    rest.name = "rest";
    rest.changes = {{0, 0.005F, 0.0F}};
    Transition hungry{1, Sensor::kTimeInState, Compare::kAbove, 0.5F, 0.0F, kHunger};
    hungry.also = {{kBread, Compare::kAbove, 0.5F}};
    rest.transitions = {hungry};
    State eat;
    eat.name = "eat";
    eat.changes = {{0, -0.1F, 0.0F}, {1, {}, -1.0F}};
    eat.transitions = {{0, Sensor::kTimeInState, Compare::kBelow, 0.1F, 0.0F, kHunger}};
    State home;
    home.name = "at_home";
    home.inside = {rest, eat};
    home.changes = {{0, 0.02F, 0.0F}};
    home.transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 5.0F}};
    State out;
    out.name = "out";
    out.changes = {{1, {}, 5.0F}};
    out.transitions = {{0, Sensor::kPlayerDistance, Compare::kAbove, 5.0F}};
    machine.states = {home, out};
    return machine;
}

class Eater {
  public:
    Eater() : written(eater()), machine(compile(written, 1.0F)) {
        mind.entity = EntityId(1);
        begin(mind, machine, 0);
    }

    std::string decide(Tick now, float player = 100.0F) {
        sight.distance = player;
        ai::decide(mind, machine, sight, Vec3::Zero(), now);
        return machine.states[mind.fsm.state()].name;
    }

    Machine written;
    CompiledMachine machine;
    Mind mind;
    Sight sight;
};

TEST(Variables, GrowAndAreFedByStates) {
    Eater eater;
    EXPECT_EQ(eater.mind.variables[0], 0.25F);
    EXPECT_EQ(eater.decide(10), "at_home/rest");
    EXPECT_NEAR(eater.mind.variables[0], 0.3F, 1e-6F);  // the inner state's rate: 0.005 a second
    EXPECT_EQ(eater.decide(51), "at_home/eat");         // 0.505
    EXPECT_EQ(eater.mind.variables[1], 2.0F);           // a bread less, at once
    EXPECT_EQ(eater.decide(53), "at_home/eat");
    EXPECT_NEAR(eater.mind.variables[0], 0.305F, 1e-6F);
    EXPECT_EQ(eater.decide(61), "at_home/rest");
    EXPECT_EQ(eater.mind.variables[0], 0.0F);  // never below low
    EXPECT_EQ(eater.decide(62, 1.0F), "out");
    EXPECT_EQ(eater.mind.variables[1], 7.0F);
    // Out there nothing is said of hunger: the variable's own rate.
    EXPECT_EQ(eater.decide(72, 1.0F), "out");
    EXPECT_NEAR(eater.mind.variables[0], 0.005F + 0.1F, 1e-6F);
    EXPECT_EQ(eater.decide(73), "at_home/rest");
    EXPECT_EQ(eater.decide(74, 1.0F), "out");
    EXPECT_EQ(eater.mind.variables[1], 10.0F);  // never above high
}

TEST(Variables, DoNotDependOnHowOftenTheyAreLookedAt) {
    Eater often;
    Eater seldom;
    for (Tick now = 1; now <= 40; ++now) {
        grow(often.mind, often.machine, now);
    }
    grow(seldom.mind, seldom.machine, 40);
    // 40 additions of 0.005 to a number below 1: a rounding of 2^-24 each.
    EXPECT_NEAR(often.mind.variables[0], seldom.mind.variables[0], 40.0F * 0x1.0p-24F);
}

TEST(Variables, StopAWayThatNeedsWhatIsNotThere) {
    Eater eater;
    eater.mind.variables[1] = 0.0F;
    EXPECT_EQ(eater.decide(100), "at_home/rest");
    EXPECT_GT(eater.mind.variables[0], 0.5F);
}

TEST(Why, TellsStatesSensesAndWhatIsWaitedFor) {
    Eater eater;
    eater.decide(10);
    eater.sight.distance = 42.0F;
    const std::string text = why(eater.mind,
                                 eater.written,
                                 eater.machine,
                                 eater.sight,
                                 Vec3(3.0F, 0.0F, 4.0F),
                                 20,
                                 1.0F);
    EXPECT_THAT(text, HasSubstr("machine eater, in state:\n  at_home for 20.00 s\n"
                                "  at_home/rest for 20.00 s\n"));
    EXPECT_THAT(text, HasSubstr("  player distance 42\n  home distance 5\n"));
    EXPECT_THAT(text, HasSubstr("  hunger 0.35\n  bread 3\n"));
    EXPECT_THAT(text, HasSubstr("  at_home -> out: player distance 42 below 5: no\n"));
    EXPECT_THAT(text,
                HasSubstr("  at_home/rest -> at_home/eat: hunger 0.35 above 0.5: no, and bread 3 "
                          "above 0.5: yes\n"));
    EXPECT_EQ(eater.mind.variables_at, 10) << "to ask changes nothing";
}

TEST(Why, TellsWhichRulesFireAndWhatIsHeld) {
    Machine machine;
    machine.name = "m";
    machine.fuzzy.emplace_back();
    fuzzy::FuzzyDef& def = machine.fuzzy[0].def;
    const float infinity = std::numeric_limits<float>::infinity();
    def.name = "fear";
    def.inputs = {{"distance", 0, 10, {{"near", -infinity, 0, 0, 10}, {"far", 0, 10, 10, infinity}}}};
    fuzzy::Output much;
    much.name = "much";
    much.values = {{"none", 0, {}}, {"all", 1, {}}};
    def.outputs = {much};
    def.rules = {{{{0, 0, false}}, false, 0, 1, 1}, {{{0, 1, false}}, false, 0, 0, 1}};
    machine.fuzzy[0].inputs = {kSensePlayerDistance};
    machine.states.resize(2);
    machine.states[0].name = "calm";
    machine.states[1].name = "afraid";
    machine.states[0].transitions = {
        {1, Sensor::kRandom, Compare::kAbove, 0.5F, 2.0F, kOwnSenses}};
    const CompiledMachine compiled = compile(machine, 0.5F);
    Mind mind;
    mind.entity = EntityId(1);
    begin(mind, compiled, 0);
    Sight sight;
    sight.distance = 2.5F;
    EXPECT_FALSE(ai::decide(mind, compiled, sight, Vec3::Zero(), 0));
    const std::string text = why(mind, machine, compiled, sight, Vec3::Zero(), 2, 0.5F);
    EXPECT_THAT(text, HasSubstr("  distance is near, then much is all: 0.75\n"));
    EXPECT_THAT(text, HasSubstr("  distance is far, then much is none: 0.25\n"));
    EXPECT_THAT(text, HasSubstr("fear.much 0.75 above 0.5: yes, held 1.00 of 2.00 s\n"));
    EXPECT_TRUE(ai::decide(mind, compiled, sight, Vec3::Zero(), 4));
}

}  // namespace
}  // namespace zoned::ai::test
