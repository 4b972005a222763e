// Agents in a config: brains within brains and fuzzy senses run as written, and each
// mistake is found at its line and column.
#include "server/config/npc/brain_config.h"

#include "server/ai/agent/brain/sense_names.h"
#include "server/ai/agent/decision.h"
#include "tests/unit/config/config_helpers.h"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace zoned::config::test {
namespace {

/// A guard whose day is a brain of its own, and who chases as boldly as a fuzzy system says.
const std::string kBrains = with("brain {\n  name: \"guard\"",
                                 R"(fuzzy {
  name: "brave"
  input { name: "distance" sensor: PLAYER_DISTANCE low: 0 high: 40
    term { name: "near" b: 5 d: 20 }
    term { name: "far" a: 5 b: 20 }
  }
  output { name: "boldness"
    value { name: "timid" constant: 0.1 }
    value { name: "bold" constant: 0.9 slope { input: "distance" factor: -0.01 } }
  }
  rule { when { input: "distance" is: "near" } then: "bold" }
  rule { when { input: "distance" is_not: "near" } then: "timid" }
}
brain {
  name: "round"
  state { name: "walk" action: PATROL radius_m: 8
    transition { to: "stand" threshold: 10 }
  }
  state { name: "stand" action: IDLE
    transition { to: "walk" threshold: 5 }
  }
}
brain {
  name: "sentry"
  state { name: "calm" brain: "round" history: DEEP
    transition { to: "hunt" sense: "brave.boldness" compare: ABOVE threshold: 0.5
      also { sensor: HOME_DISTANCE compare: BELOW threshold: 50 }
    }
  }
  state { name: "hunt" action: CHASE
    transition { to: "calm" sense: "brave.boldness" compare: BELOW threshold: 0.3 }
  }
}
brain {
  name: "guard")",
                                 with("brain: \"guard\"", "brain: \"sentry\""));

std::string brains_with(const std::string& from, const std::string& to) {
    return with(from, to, kBrains);
}

TEST(AgentStore, AreBuiltFromBrainsWithinBrainsAndFuzzySenses) {
    const Outcome out = parse(kBrains);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& sentry = out.settings.ai.compiled[1];
    ASSERT_EQ(sentry.states.size(), 3U);
    EXPECT_EQ(sentry.states[0].name, "calm/walk");
    EXPECT_EQ(sentry.states[0].action, ai::ActionKind::kPatrol);
    EXPECT_EQ(sentry.states[0].radius_m, 8.0F);
    EXPECT_EQ(sentry.states[1].name, "calm/stand");
    EXPECT_EQ(sentry.states[2].name, "hunt");
    EXPECT_EQ(sentry.senses, ai::kOwnSenses + 1);
    // The others read no fuzzy system, and have none.
    EXPECT_TRUE(out.settings.ai.compiled[0].fuzzy.empty());
}

TEST(AgentStore, DoWhatTheyAreWritten) {
    const Outcome out = parse(kBrains);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& sentry = out.settings.ai.compiled[1];
    ai::Agent agent;
    ai::DecisionScratch scratch;
    agent.entity = EntityId(1);
    const auto decide = [&](float distance, float home_m, Tick now) {
        ai::Percept sight;
        sight.distance = distance;
        ai::decide(agent, sentry, sight, Vec2(home_m, 0.0F), ai::PointsOfInterest(), now, scratch);
        return sentry.states[agent.state_machine.leaf].name;
    };
    // Ticks of 1/30 s. Distance 5: near 1, boldness 0.9 - 0.05; 35: far, boldness 0.1.
    EXPECT_EQ(decide(35, 0, 0), "calm/walk");
    EXPECT_EQ(decide(35, 0, 301), "calm/stand");
    EXPECT_EQ(decide(5, 60, 302), "calm/stand");
    EXPECT_EQ(decide(5, 40, 303), "hunt");
    EXPECT_EQ(decide(35, 40, 304), "calm/stand");
    EXPECT_EQ(decide(35, 40, 455), "calm/walk");
}

TEST(AgentStore, FindUnknownSenses) {
    expect_single(brains_with("sense: \"brave.boldness\" compare: ABOVE",
                              "sense: \"brave.bold\" compare: ABOVE"),
                  "sense: \"brave.bold\"",
                  "agents of brain 'sentry' do not sense 'brave.bold'");
}

TEST(AgentStore, FindUnknownSensesInFurtherConditions) {
    expect_single(brains_with("also { sensor: HOME_DISTANCE", "also { sense: \"a.b\""),
                  "sense: \"a.b\"",
                  "do not sense 'a.b'");
}

TEST(AgentStore, FindUnknownBrains) {
    expect_single(brains_with("brain: \"round\"", "brain: \"rond\""),
                  "brain: \"rond\"",
                  "no brain named 'rond'");
}

TEST(AgentStore, FindStatesThatNobodyEnters) {
    expect_single(brains_with("  state { name: \"stand\" action: IDLE",
                              "  state { name: \"lost\"\n    transition { to: \"walk\" }\n  }\n"
                              "  state { name: \"stand\" action: IDLE"),
                  "state { name: \"lost\"",
                  "is never entered");
}

TEST(AgentStore, FindCycles) {
    expect_single(brains_with("state { name: \"stand\" action: IDLE",
                              "state { name: \"stand\" brain: \"sentry\""),
                  "brain: \"sentry\"\n    transition",
                  "'sentry' holds 'round' holds 'sentry'");
}

TEST(AgentStore, FindRingsThatNobodyUses) {
    expect_single(brains_with("brain {\n  name: \"sentry\"",
                              "brain {\n  name: \"a\"\n  state { name: \"s\" brain: \"a\" }\n}\n"
                              "brain {\n  name: \"sentry\""),
                  "brain: \"a\" }",
                  "cannot be inside itself");
}

TEST(AgentStore, FindBrainsThatAreTooDeep) {
    std::string brains;
    for (int level = 0; level < 5; ++level) {
        brains += "brain {\n  name: \"m" + std::to_string(level) + "\"\n  state { name: \"s\" ";
        brains += level < 4 ? "brain: \"m" + std::to_string(level + 1) + "\" }\n}\n" : "}\n}\n";
    }
    const Outcome out =
        parse(brains_with("brain {\n  name: \"sentry\"", brains + "brain {\n  name: \"sentry\""));
    ASSERT_EQ(out.errors.size(), 1U) << format_errors("test", out.errors);
    EXPECT_NE(out.errors[0].text.find("at most 4 levels"), std::string::npos);
    EXPECT_EQ(out.errors[0].line,
              place_of(kBrains, "brain {\n  name: \"sentry\"").first + 3 * 4 + 2);
}

TEST(AgentStore, EndWhereBrainsWithinBrainsExplode) {
    // 100 states of 100 states of ...: 10^8 in all.
    std::string brains;
    for (int level = 0; level < 4; ++level) {
        brains += "brain { name: \"m" + std::to_string(level) + "\"";
        for (int s = 0; s < 100; ++s) {
            brains += " state { name: \"s" + std::to_string(s) + "\"";
            brains += level < 3 ? " brain: \"m" + std::to_string(level + 1) + "\"" : "";
            brains += " transition { to: \"s" + std::to_string((s + 1) % 100) + "\" } }";
        }
        brains += " }\n";
    }
    const Outcome out =
        parse(brains_with("brain {\n  name: \"sentry\"", brains + "brain {\n  name: \"sentry\""));
    EXPECT_FALSE(out.ok);
    EXPECT_TRUE(std::any_of(out.errors.begin(), out.errors.end(), [](const ConfigError& error) {
        return error.text.find("is one too many") != std::string::npos;
    })) << format_errors("test", out.errors);
}

TEST(AgentStore, FindTransitionsThatNeverFire) {
    expect_single(brains_with("    transition { to: \"stand\" threshold: 10 }",
                              "    transition { to: \"stand\" threshold: 10 }\n"
                              "    transition { to: \"walk\" threshold: 20 }"),
                  "transition { to: \"walk\" threshold: 20 }",
                  "never fires");
}

TEST(AgentStore, FindConditionsThatExcludeEachOther) {
    expect_single(brains_with("also { sensor: HOME_DISTANCE",
                              "also { sense: \"brave.boldness\" compare: BELOW threshold: 0.4 }\n"
                              "      also { sensor: HOME_DISTANCE"),
                  "also { sense: \"brave.boldness\" compare: BELOW threshold: 0.4 }",
                  "excludes");
}

TEST(AgentStore, FindActionsOfBrainsAsStates) {
    expect_single(brains_with("name: \"calm\" brain", "name: \"calm\" action: IDLE brain"),
                  "state { name: \"calm\"",
                  "say its own states");
}

TEST(AgentStore, FindHistoriesOfNothing) {
    expect_single(brains_with("name: \"hunt\" action", "name: \"hunt\" history: DEEP action"),
                  "state { name: \"hunt\"",
                  "nothing inside");
}

TEST(AgentStore, JudgeDistancesByWhatTheOuterBrainPerceives) {
    const std::string text = brains_with("to: \"stand\" threshold: 10",
                                         "to: \"stand\" sensor: PLAYER_DISTANCE threshold: 39");
    EXPECT_TRUE(parse(text).ok);
    expect_single(with("name: \"sentry\"\n", "name: \"sentry\" perception_m: 30\n", text),
                  "threshold: 39",
                  "beyond perception_m, 30");
}

/// The sentry tires of hunting.
const std::string kTired =
    with("name: \"hunt\" action: CHASE",
         "name: \"hunt\" action: CHASE change { variable: \"vigour\" per_s: -0.1 on_enter: -0.05 }",
         brains_with("name: \"sentry\"\n",
                     "name: \"sentry\"\n  variable { name: \"vigour\" start: 0.8 per_s: 0.02 }\n"));

TEST(AgentStore, HaveVariables) {
    const Outcome out = parse(with("sense: \"brave.boldness\" compare: BELOW threshold: 0.3",
                                   "sense: \"vigour\" compare: BELOW threshold: 0.3",
                                   kTired));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& sentry = out.settings.ai.compiled[1];
    EXPECT_EQ(sentry.senses, ai::kOwnSenses + 2);
    ai::Agent agent;
    ai::DecisionScratch scratch;
    agent.entity = EntityId(1);
    ai::begin(agent, sentry, 0);
    ai::Percept sight;
    sight.distance = 5.0F;
    ai::decide(agent, sentry, sight, Vec2::Zero(), ai::PointsOfInterest(), 30, scratch);
    EXPECT_EQ(sentry.states[agent.state_machine.leaf].name, "hunt");
    EXPECT_NEAR(agent.variables[0], 0.8F + 0.02F - 0.05F, 1e-6F);
    ai::decide(agent, sentry, sight, Vec2::Zero(), ai::PointsOfInterest(), 30 + 135, scratch);
    EXPECT_EQ(sentry.states[agent.state_machine.leaf].name, "hunt");  // 4.5 s: 0.32
    ai::decide(agent, sentry, sight, Vec2::Zero(), ai::PointsOfInterest(), 30 + 150, scratch);
    EXPECT_EQ(sentry.states[agent.state_machine.leaf].name, "calm/walk");
}

TEST(AgentStore, FindVariablesThatDoNotExist) {
    expect_single(with("variable: \"vigour\" per_s", "variable: \"vigor\" per_s", kTired),
                  "variable: \"vigor\"",
                  "brain 'sentry' has no variable named 'vigor'");
}

TEST(AgentStore, FindSystemsThatDependOnVariablesThatTheyDoNotHave) {
    const std::string text = with("input { name: \"distance\" sensor: PLAYER_DISTANCE",
                                  "input { name: \"distance\" sense: \"vigour\"",
                                  kTired);
    EXPECT_TRUE(parse(text).ok);
    const Outcome out =
        parse(with("variable { name: \"vigour\"",
                   "variable { name: \"power\"",
                   with("change { variable: \"vigour\" per_s: -0.1 on_enter: -0.05 }", "", text)));
    ASSERT_EQ(out.errors.size(), 2U) << format_errors("test", out.errors);
    EXPECT_NE(out.errors[0].text.find("it depends on 'vigour'"), std::string::npos);
}

TEST(AgentStore, FindVariablesThatStartOutside) {
    expect_single(with("start: 0.8", "start: 1.5", kTired), "start: 1.5", "outside of low to high");
    expect_single(with("per_s: 0.02", "high: 0 low: 0.5", kTired),
                  "variable { name: \"vigour\"",
                  "high must be above low");
}

/// The hamlet's villagers plan, its hinds follow a tree.
std::string hamlet() {
    std::ifstream in(ZONED_SOURCE_DIR "/config/hamlet.txtpb", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void expect_in_hamlet(const std::string& from,
                      const std::string& to,
                      const std::string& needle,
                      const std::string& words) {
    expect_single(with(from, to, hamlet()), needle, words);
}

/// The guard of kValid by code.
const std::string kCoded = with(
    "brain {\n  name: \"guard\"\n  state { name: \"rest\" action: IDLE transition { to: "
    "\"chase\" sensor: PLAYER_DISTANCE compare: BELOW threshold: 20 } }",
    "fuzzy {\n  name: \"fear\"\n"
    "  input { name: \"far\" sensor: HOME_DISTANCE high: 40\n"
    "    term { name: \"near\" b: 5 d: 20 }\n"
    "    term { name: \"far\" a: 5 b: 20 }\n  }\n"
    "  output { name: \"level\"\n"
    "    value { name: \"low\" constant: 0.1 }\n"
    "    value { name: \"high\" constant: 0.9 }\n  }\n"
    "  rule { when { input: \"far\" is: \"near\" } then: \"low\" }\n"
    "  rule { when { input: \"far\" is: \"far\" } then: \"high\" }\n}\n"
    "brain {\n  name: \"guard\"\n  coded: \"guard\" reads: \"fear.level\"\n"
    "  state { name: \"rest\" action: IDLE }");

TEST(CodedBrains, TakeNamesOfCodeAndWhatItReads) {
    const Outcome out = parse(kCoded);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::Brain& brain = out.settings.ai.brains[0];
    EXPECT_EQ(brain.coded, "guard");
    EXPECT_EQ(out.settings.ai.compiled[0].table.leaves(), 2U);
    const std::vector<std::string> names = ai::config_sense_names(brain);
    ASSERT_EQ(names.size(), ai::kOwnSenses + 1);
    EXPECT_EQ(names.back(), "fear.level");
    // Each sensor of the schema by its name there, but for the time in a state.
    for (int n = 0; n <= proto::config::Sensor_MAX; ++n) {
        if (!proto::config::Sensor_IsValid(n) || n == proto::config::TIME_IN_STATE) {
            continue;
        }
        EXPECT_EQ(names[ai::sense_of(static_cast<ai::Sensor>(n))],
                  proto::config::Sensor_Name(static_cast<proto::config::Sensor>(n)));
    }
}

TEST(CodedBrains, FindTransitionsBesideCode) {
    expect_single(with("state { name: \"rest\" action: IDLE }",
                       "state { name: \"rest\" action: IDLE transition { to: \"chase\" } }",
                       kCoded),
                  "transition {",
                  "code 'guard' makes the transitions of this brain");
}

TEST(CodedBrains, FindSensesThatAgentsDoNotHave) {
    expect_single(with("reads: \"fear.level\"", "reads: \"fear.depth\"", kCoded),
                  "reads:",
                  "do not sense 'fear.depth'");
    expect_single(
        with("coded: \"guard\" ",
             "",
             with("action: IDLE }", "action: IDLE transition { to: \"chase\" } }", kCoded)),
        "reads:",
        "needs `coded`");
}

TEST(CodedBrains, HaveOneLevelAndAreNoStates) {
    const std::string other = "brain {\n  name: \"other\"\n  state { name: \"be\" }\n}\n";
    expect_single(with("state { name: \"chase\" action: CHASE }",
                       "state { name: \"chase\" brain: \"other\" }",
                       kCoded) +
                      other,
                  "brain: \"other\"",
                  "no brain within a state");
    expect_single(kCoded + with("{ name: \"be\" }", "{ name: \"be\" brain: \"guard\" }", other),
                  "brain: \"guard\" }\n}",
                  "whose transitions come from code");
}

TEST(CodedBrains, AreRefusedForRulesByAScript) {
    const Outcome out = parse(kCoded + "script { file: \"none.lua\" avatar: \"player\" }\n");
    ASSERT_FALSE(out.ok);
    EXPECT_TRUE(std::any_of(out.errors.begin(), out.errors.end(), [](const ConfigError& error) {
        return error.text.find("rules by a script have no brains in code") != std::string::npos;
    })) << format_errors("test", out.errors);
}

TEST(Choices, OfTheHamletAreGood) {
    const Outcome out = parse(hamlet());
    ASSERT_TRUE(out.ok) << format_errors("hamlet", out.errors);
    const auto& brains = out.settings.ai.brains;
    EXPECT_TRUE(brains[0].inner);   // round
    EXPECT_TRUE(brains[1].inner);   // alarm
    EXPECT_FALSE(brains[2].inner);  // watch
    EXPECT_EQ(out.settings.ai.compiled[2].states.size(), 4U);
    EXPECT_EQ(out.settings.ai.compiled[3].trees.size(), 1U);
    EXPECT_EQ(out.settings.ai.compiled[4].plans.size(), 1U);
    EXPECT_EQ(out.settings.ai.compiled[4].states.size(), 5U);  // live, and four actions
}

TEST(Choices, FindTreesThatDoNotExist) {
    expect_in_hamlet(
        "tree: \"grazing\"", "tree: \"grasing\"", "tree: \"grasing\"", "no tree named");
}

TEST(Choices, FindNodesThatDoNotExist) {
    expect_in_hamlet("yes: \"run\"", "yes: \"ran\"", "yes: \"ran\"", "no node named 'ran'");
}

TEST(Choices, FindQuestionsThatAreAnsweredAlready) {
    expect_in_hamlet("ask { sensor: HOME_DISTANCE compare: ABOVE threshold: 50 }",
                     "ask { sensor: PLAYER_DISTANCE compare: ABOVE threshold: 7 }",
                     "node { name: \"strayed\"",
                     "always answered yes");
}

TEST(Choices, FindNodesThatAreNeitherQuestionNorAnswer) {
    expect_in_hamlet("do { action: FLEE stance: RUNNING }",
                     "",
                     "node { name: \"run\"",
                     "needs either `ask` or `do`");
}

TEST(Choices, FindSensesOfTreesThatAgentsDoNotHave) {
    expect_in_hamlet("ask { sensor: HOME_DISTANCE",
                     "ask { sense: \"courage\"",
                     "sense: \"courage\"",
                     "agents of brain 'hind' do not sense 'courage'");
}

TEST(Choices, FindFactsThatDoNotExist) {
    expect_in_hamlet("makes: \"not at_home\"",
                     "makes: \"not at_hom\"",
                     "makes: \"not at_hom\"",
                     "no fact named 'at_hom'");
}

TEST(Choices, FindActionsWithoutEffect) {
    expect_in_hamlet("needs: \"has_bread\" makes: \"fed\"",
                     "needs: \"has_bread\" needs: \"fed\" makes: \"fed\"",
                     "action { name: \"eat\"",
                     "changes nothing");
}

TEST(Choices, FindActionsThatNobodyWants) {
    expect_in_hamlet(
        "action { name: \"go_home\"",
        "action { name: \"stray\" makes: \"not has_bread\" }\n  action { name: \"go_home\"",
        "action { name: \"stray\"",
        "makes nothing that a goal or another action needs");
}

TEST(Choices, FindGoalsThatNothingMakes) {
    expect_in_hamlet("goal { name: \"be_fed\" wants: \"fed\" }",
                     "goal { name: \"be_fed\" wants: \"fed\" }\n"
                     "  goal { name: \"starve\" wants: \"not fed\" }",
                     "goal { name: \"starve\"",
                     "no action makes 'fed'");
}

TEST(Choices, FindVariablesThatActionsChangeAndAgentsDoNotHave) {
    expect_in_hamlet("change { variable: \"bread\" on_enter: 2 }",
                     "change { variable: \"breed\" on_enter: 2 }",
                     "variable: \"breed\"",
                     "brain 'villager' has no variable named 'breed'");
}

TEST(Choices, FindTwoWaysToSayWhatToDo) {
    expect_in_hamlet("state { name: \"live\" tree:",
                     "state { name: \"live\" brain: \"round\" tree:",
                     "state { name: \"live\" brain",
                     "takes one of");
}

TEST(FuzzySystems, FindGaps) {
    expect_single(
        brains_with("term { name: \"near\" b: 5 d: 20 }", "term { name: \"near\" b: 5 d: 3 }"),
        "term { name: \"near\"",
        "ascend");
    expect_single(
        brains_with("term { name: \"far\" a: 5 b: 20 }", "term { name: \"far\" a: 25 b: 30 }"),
        "input { name: \"distance\"",
        "values between 20 and 25 belong to no term");
}

TEST(FuzzySystems, FindNamesThatMeanNothing) {
    expect_single(brains_with("is: \"near\"", "is: \"neer\""),
                  "is: \"neer\"",
                  "input 'distance' has no term named 'neer'");
    expect_single(brains_with("when { input: \"distance\" is:", "when { input: \"range\" is:"),
                  "input: \"range\"",
                  "no input named 'range'");
    expect_single(brains_with("slope { input: \"distance\"", "slope { input: \"rage\""),
                  "input: \"rage\"",
                  "no input named 'rage'");
    expect_single(brains_with("then: \"timid\" }",
                              "output: \"odd\" then: \"timid\" }\n  rule { when { input: "
                              "\"distance\" is: \"far\" } then: \"timid\" }"),
                  "output: \"odd\"",
                  "no output named 'odd'");
}

TEST(FuzzySystems, FindWhatIsNeverSaid) {
    expect_single(brains_with("then: \"timid\"", "then: \"bold\""),
                  "value { name: \"timid\"",
                  "no rule ever says this");
}

TEST(FuzzySystems, FindPropositionsThatSayNothing) {
    expect_single(
        brains_with("is_not: \"near\"", ""), "when { input: \"distance\"  }", "needs either");
}

TEST(FuzzySystems, FindTermsOfTheWrongInference) {
    expect_single(brains_with("output { name: \"boldness\"",
                              "output { name: \"boldness\" term { name: \"x\" b: 1 }"),
                  "term { name: \"x\"",
                  "belong to inference: MAMDANI");
}

}  // namespace
}  // namespace zoned::config::test
