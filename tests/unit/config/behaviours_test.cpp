// Types as sets of behaviours: parameters, precedence, inheritance and difficulties take effect as
// written. Each mistake is found at its line and column.
#include "server/config/npc/behaviours.h"

#include "server/ai/agent/decision.h"
#include "server/config/npc/parameters.h"
#include "tests/unit/config/config_helpers.h"

#include <limits>

namespace zoned::config::test {
namespace {

/// Townsmen who work, eat when hungry and run from players; a glutton is a kind of townsman.
const std::string kTown = with("type {\n  name: \"guard\"",
                               R"(brain {
  name: "eating"
  variable { name: "hunger" start: 0.5 per_s: 0.1 }
  state { name: "walk" action: RETURN speed_factor_from: "haste"
    transition { to: "eat" sensor: HOME_DISTANCE compare: BELOW threshold: 2 }
  }
  state { name: "eat" action: IDLE
    change { variable: "hunger" per_s_from: "bite_ps" }
  }
}
brain {
  name: "escape"
  perception_m: 30
  state { name: "run" action: FLEE sprint: true }
}
brain {
  name: "labour"
  decide_every_s: 0.5
  state { name: "dig" action: WANDER radius_m_from: "beat_m"
    transition { to: "rest" threshold_from: "shift_s" hold_s_from: "shift_s" }
  }
  state { name: "rest" action: IDLE
    transition { to: "dig" threshold: 3 }
  }
}
behaviour {
  name: "feeding"
  brain: "eating"
  parameter { name: "hungry_at" value: 0.8 low: 0.2 high: 1 }
  parameter { name: "haste" value: 0.5 }
  parameter { name: "bite_ps" value: -0.2 low: -1 high: 0 }
  begins { when { sense: "hunger" threshold_from: "hungry_at" } }
  ends { when { sense: "hunger" compare: BELOW threshold: 0.1 } }
}
behaviour {
  name: "fear"
  brain: "escape"
  parameter { name: "notice_m" value: 10 low: 1 high: 25 }
  begins { when { sensor: PLAYER_DISTANCE compare: BELOW threshold_from: "notice_m" } }
  ends { when { sensor: PLAYER_DISTANCE threshold: 26 } hold_s: 1 }
}
behaviour {
  name: "work"
  brain: "labour"
  parameter { name: "beat_m" value: 12 low: 1 high: 50 }
  parameter { name: "shift_s" value: 6 low: 1 high: 100 }
}
difficulty {
  name: "hard"
  set { name: "notice_m" factor: 2 }
  set { name: "hungry_at" value: 0.9 behaviour: "feeding" type: "glutton" }
}
type {
  name: "townsman"
  kind: CHARACTER
  capsule { radius_m: 0.4 length_m: 1 }
  aura_m { normal: 40 idle: 20 }
  character { speed_mps: 2 }
  behaviour { name: "fear" }
  behaviour { name: "feeding" set { name: "haste" value: 0.6 } }
  behaviour { name: "work" }
}
type {
  name: "glutton"
  base: "townsman"
  aura_m { normal: 45 }
  behaviour { name: "feeding" set { name: "hungry_at" value: 0.4 } }
}
type {
  name: "guard")");

std::string town_with(const std::string& from, const std::string& to) {
    return with(from, to, kTown);
}

const ai::CompiledBrain& brain_of(const Outcome& out, const std::string& type) {
    for (const world::EntityType& of : out.settings.types) {
        if (of.name == type) {
            return out.settings.ai.compiled.at(of.brain - 1U);
        }
    }
    throw std::runtime_error("no type " + type);
}

/// One agent, its senses, and its decisions.
struct Walk {
    const ai::CompiledBrain& brain;
    ai::Agent agent;
    ai::DecisionScratch scratch;
    Tick now = 0;

    explicit Walk(const ai::CompiledBrain& of) : brain(of) {
        agent.entity = EntityId(1);
        ai::begin(agent, brain, 0);
    }

    /// Its action `ticks` ticks later.
    std::string after(Tick ticks, float player_m, float home_m = 10.0F) {
        now += ticks;
        ai::Percept sight;
        sight.distance = player_m;
        ai::decide(agent, brain, sight, Vec2(home_m, 0.0F), ai::PointsOfInterest(), now, scratch);
        return brain.states[agent.current_action].name;
    }
};

constexpr float kNobody = std::numeric_limits<float>::infinity();

TEST(TypesOfBehaviours, HaveOneBrainWithTheirParametersInIt) {
    const Outcome out = parse(kTown);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const ai::CompiledBrain& townsman = brain_of(out, "townsman");
    EXPECT_EQ(townsman.name, "townsman.brain");
    EXPECT_EQ(townsman.perception_m, 40.0F);   // of "labour" and "eating", the farthest
    EXPECT_EQ(townsman.decide_every_s, 0.2F);  // of "eating", the most frequent
    ASSERT_EQ(townsman.states.size(), 5U);
    EXPECT_EQ(townsman.states[0].name, "work/dig");
    EXPECT_EQ(townsman.states[0].radius_m, 12.0F);
    EXPECT_EQ(townsman.states[2].name, "fear/run");
    EXPECT_EQ(townsman.states[3].name, "feeding/walk");
    EXPECT_EQ(townsman.states[3].speed_factor, 0.6F);
    EXPECT_EQ(brain_of(out, "glutton").states[3].speed_factor, 0.6F) << "the base says so";
}

TEST(TypesOfBehaviours, ActByPrecedenceAndGoOnWhereTheyWere) {
    const Outcome out = parse(kTown);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    // At 30 Hz hunger grows by 0.1 in 30 ticks, from 0.5.
    Walk walk(brain_of(out, "townsman"));
    EXPECT_EQ(walk.after(30, kNobody), "work/dig");    // hunger 0.6, 1 s
    EXPECT_EQ(walk.after(30, 9.0F), "fear/run");       // 0.7: a player within 10 m
    EXPECT_EQ(walk.after(60, 20.0F), "fear/run");      // 0.9: hungry, but fear comes first
    EXPECT_EQ(walk.after(30, 27.0F), "fear/run");      // 1: out of reach, to be held for 1 s
    EXPECT_EQ(walk.after(30, 27.0F), "feeding/walk");  // it ends, and a cue of feeding holds
    EXPECT_EQ(walk.after(15, kNobody, 1.0F), "feeding/eat");
    EXPECT_EQ(walk.after(30, 9.0F), "fear/run");  // 0.8, half eaten
    EXPECT_EQ(walk.after(30, 27.0F), "fear/run");
    // Hunger has grown to 0.9 by now: it goes on eating, not walking home again.
    EXPECT_EQ(walk.after(30, 27.0F), "feeding/eat");
    EXPECT_EQ(walk.after(150, kNobody), "work/dig");  // 0.0 is below 0.1
}

TEST(TypesOfBehaviours, OverrideWhatTheirBaseSays) {
    const Outcome out = parse(kTown);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& types = out.settings.config->type();
    const auto& glutton = types[3];
    ASSERT_EQ(glutton.name(), "glutton");
    EXPECT_EQ(glutton.character().speed_mps(), 2.0);
    EXPECT_EQ(glutton.aura_m().normal(), 45.0);
    EXPECT_EQ(glutton.aura_m().idle(), 20.0);
    Walk walk(brain_of(out, "glutton"));
    EXPECT_EQ(walk.after(3, kNobody), "feeding/walk") << "hungry at 0.4, and it begins at 0.5";
}

TEST(TypesOfBehaviours, MixAndMatch) {
    const std::string brave = town_with("type {\n  name: \"guard\"",
                                        R"(type {
  name: "brave"
  base: "townsman"
  behaviour { name: "fear" remove: true }
}
type {
  name: "starving"
  base: "townsman"
  behaviour { name: "feeding" before: "fear" }
}
type {
  name: "guard")");
    const Outcome out = parse(brave);
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    Walk walk(brain_of(out, "brave"));
    EXPECT_EQ(walk.after(30, 1.0F), "work/dig");
    Walk starving(brain_of(out, "starving"));
    EXPECT_EQ(starving.after(120, 1.0F), "feeding/walk") << "hunger comes before fear";
}

TEST(TypesOfBehaviours, AreTheSameWhenTheirConfigIsReadAgain) {
    const Outcome once = parse(kTown);
    const Outcome again = parse(once.settings.text);
    ASSERT_TRUE(again.ok) << format_errors("test", again.errors);
    EXPECT_EQ(again.settings.text, once.settings.text);
    EXPECT_EQ(again.settings.config->SerializeAsString(),
              once.settings.config->SerializeAsString());
}

TEST(Difficulties, SetParametersWhateverTypesSay) {
    const Outcome out = parse(kTown, {"ai.difficulty=hard"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto parameter = [&](const std::string& type, const std::string& name) {
        for (const ParameterChoice& choice : out.settings.parameters) {
            if (choice.type == type && choice.parameter == name) {
                return choice;
            }
        }
        return ParameterChoice{};
    };
    EXPECT_EQ(parameter("townsman", "notice_m").value, 20.0);
    EXPECT_EQ(parameter("townsman", "hungry_at").value, 0.8);
    EXPECT_EQ(parameter("townsman", "hungry_at").reason, "as the behaviour says");
    EXPECT_EQ(parameter("townsman", "haste").reason, "as type townsman says");
    EXPECT_EQ(parameter("glutton", "haste").reason, "as type townsman says");
    EXPECT_EQ(parameter("glutton", "hungry_at").value, 0.9);
    EXPECT_EQ(parameter("glutton", "hungry_at").reason, "difficulty hard");
    Walk walk(brain_of(out, "townsman"));
    EXPECT_EQ(walk.after(30, 19.0F), "fear/run");
    const std::string text = parameters_text(out.settings);
    EXPECT_NE(text.find("difficulty: hard"), std::string::npos) << text;
    EXPECT_NE(text.find("hungry_at 0.9  difficulty hard"), std::string::npos) << text;
}

TEST(Difficulties, NeverGoBeyondTheBoundsOfAParameter) {
    const Outcome out = parse(kTown, {"ai.difficulty=hard", "difficulty[hard].set[0].factor=9"});
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.parameters[0].parameter, "notice_m");
    EXPECT_EQ(out.settings.parameters[0].value, 25.0);
    EXPECT_NE(out.settings.parameters[0].reason.find("at the bound"), std::string::npos);
}

struct TownCase {
    std::string from;
    std::string to;
    std::string needle;  ///< where the mistake must be reported
    std::string words;   ///< that its text must hold
};

/// Mistakes that follow from another one may be reported as well.
void expect_reported(const TownCase& c) {
    SCOPED_TRACE(c.to);
    const std::string text = town_with(c.from, c.to);
    const Outcome out = parse(text);
    EXPECT_FALSE(out.ok);
    const auto [line, column] = place_of(text, c.needle);
    bool found = false;
    for (const ConfigError& error : out.errors) {
        found = found || (error.line == line && error.column == column &&
                          error.text.find(c.words) != std::string::npos);
    }
    EXPECT_TRUE(found) << "wanted " << line << ":" << column << " " << c.words << "\n"
                       << format_errors("test", out.errors);
    EXPECT_LE(out.errors.size(), 3U) << format_errors("test", out.errors);
}

TEST(MistakesInTypes, AreFoundWhereTheyAre) {
    expect_reported({"base: \"townsman\"", "base: \"towns\"", "base: \"towns\"", "named 'towns'"});
    expect_reported({"  name: \"townsman\"\n",
                     "  name: \"townsman\"\n  base: \"glutton\"\n",
                     "base: \"townsman\"",
                     "its own base: 'townsman' is like 'glutton' is like 'townsman'"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"labor\" }",
                     "name: \"labor\"",
                     "no behaviour named 'labor'"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"work\" } behaviour { name: \"work\" }",
                     "name: \"work\" }\n}",
                     "already"});
    expect_reported({"set { name: \"haste\"",
                     "set { name: \"speed\"",
                     "name: \"speed\"",
                     "no parameter named 'speed'"});
    expect_reported({"value: 0.4", "value: 0.1", "value: 0.1", "outside of 0.2 to 1"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"work\" before: \"fear\" }",
                     "behaviour { name: \"work\" before",
                     "never begins"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"work\" before: \"rest\" }",
                     "before: \"rest\"",
                     "no behaviour 'rest'"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"work\" remove: true }",
                     "remove: true",
                     "no behaviour 'work'"});
    expect_reported({"behaviour { name: \"work\" }",
                     "behaviour { name: \"work\" } brain: \"guard\"",
                     "type {\n  name: \"townsman\"",
                     "one of `brain` and `behaviour`"});
    expect_reported({"brain: \"guard\"",
                     "brain: \"labour\"",
                     "brain: \"labour\"\n}\nbrain",
                     "takes parameters"});
}

TEST(MistakesInBehaviours, AreFoundWhereTheyAre) {
    expect_reported({"threshold_from: \"hungry_at\"",
                     "threshold_from: \"hungry\"",
                     "threshold_from: \"hungry\"",
                     "no parameter named 'hungry'"});
    expect_reported({"threshold_from: \"hungry_at\"",
                     "threshold: 0.8",
                     "parameter { name: \"hungry_at\"",
                     "no setting takes it"});
    expect_reported({"name: \"haste\" value: 0.5",
                     "name: \"haste\" value: 0.5 high: 2",
                     "parameter { name: \"haste\"",
                     "speed_factor, which lies in [0..1]"});
    expect_reported(
        {"value: 10 low: 1", "value: 10 low: 11", "parameter { name: \"notice_m\"", "outside"});
    expect_reported({"speed_factor_from: \"haste\"",
                     "speed_factor: 1 speed_factor_from: \"haste\"",
                     "speed_factor_from",
                     "either `speed_factor` or"});
    expect_reported(
        {"  brain: \"escape\"", "  brain: \"escapes\"", "brain: \"escapes\"", "no brain"});
    expect_reported({"  ends { when { sensor: PLAYER_DISTANCE threshold: 26 } hold_s: 1 }\n",
                     "",
                     "behaviour { name: \"fear\" }",
                     "never ends"});
    // A mistake in a behaviour's brain is reported once, at the brain as it is written.
    expect_reported({"{ sense: \"hunger\" compare: BELOW threshold: 0.1 }",
                     "{ sense: \"thirst\" compare: BELOW threshold: 0.1 }",
                     "sense: \"thirst\"",
                     "do not sense 'thirst': it is no variable of theirs, no "
                     "\"SYSTEM.OUTPUT\" of a fuzzy system, and no \"PLACE.distance\" or "
                     "\"PLACE.GOOD\" (in type 'townsman')"});
    expect_reported({"transition { to: \"dig\" threshold: 3 }",
                     "transition { to: \"digs\" threshold: 3 }",
                     "to: \"digs\"",
                     "no state named 'digs'"});
    expect_reported(
        {"threshold_from: \"notice_m\"", "threshold: 45", "threshold: 45", "beyond perception_m"});
    expect_reported({"  state { name: \"run\" action: FLEE",
                     "  variable { name: \"hunger\" }\n  state { name: \"run\" action: FLEE",
                     "behaviour { name: \"feeding\" set",
                     "variables of one name are one"});
    expect_reported({"set { name: \"notice_m\" factor: 2 }",
                     "set { name: \"notice_m\" }",
                     "set { name: \"notice_m\" }",
                     "either `value` or `factor`"});
    expect_reported({"set { name: \"notice_m\" factor: 2 }",
                     "set { name: \"notices_m\" factor: 2 }",
                     "set { name: \"notices_m\"",
                     "no behaviour has a parameter"});
}

TEST(MistakesInBehaviours, CoverParametersOutsideOfAnyAndDifficultiesThatAreNone) {
    expect_reported({"action: CHASE }",
                     "action: CHASE speed_factor_from: \"haste\" }",
                     "speed_factor_from: \"haste\" }\n}\nsession",
                     "part of none"});
    const Outcome out = parse(kTown, {"ai.difficulty=medium"});
    ASSERT_EQ(out.errors.size(), 1U) << format_errors("test", out.errors);
    EXPECT_EQ(out.errors[0].path, "ai.difficulty");
}

}  // namespace
}  // namespace zoned::config::test
