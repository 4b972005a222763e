// Brain: what the agent of a character is made of, as written and compiled.
#pragma once

#include "server/ai/agent/brain/forage_def.h"
#include "server/ai/agent/brain/formation_def.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/agent/brain/spline_follow_def.h"
#include "server/ai/decision/fuzzy/fuzzy_state_machine.h"
#include "server/ai/decision/fuzzy/fuzzy_system.h"
#include "server/ai/decision/goap/goap_planner.h"
#include "server/ai/decision/senses.h"
#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "server/ai/decision/tree/decision_tree.h"
#include "server/ai/learning/adaptation.h"
#include "server/ai/learning/guard.h"
#include "shared/core/ids.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace zoned::ai {

/// What a state makes its entity do.
enum class ActionKind : std::uint8_t {
    kIdle,    ///< stand still
    kWander,  ///< walk to random points within `radius_m` of home
    kPatrol,  ///< walk the square of `radius_m` around home, corner by corner
    kChase,   ///< run at the nearest player
    kFlee,    ///< run from the nearest player
    kFlock,  ///< separation, alignment, cohesion with its own type (Reynolds 1987), drifting around
             ///< home
    kReturn,             ///< walk home
    kGo = 20,            ///< walk to its spot at `place`, and stand there
    kFollow = 110,       ///< stay within `radius_m` of its ward, or else of its target
    kEscort = 111,       ///< stay `radius_m` beside its ward, or between it and the target
    kForage = 171,       ///< look for food around a nest, and carry it home: `forage`
    kFormUp = 170,       ///< keep a slot of `formation` around its ward
    kFollowTrack = 190,  ///< go along a track by a timetable: `follow`
    kGuard = 112,  ///< hold home: run at a target within `radius_m` of it until that is beyond
                   ///< `leash_m`, then walk home
};

/// What a transition's condition reads.
enum class Sensor : std::uint8_t {
    kPlayerDistance,  ///< to the nearest player, m; infinity when none is within `perception_m`
    kHomeDistance,    ///< m
    kTimeInState,     ///< s
    kRandom,          ///< uniform [0, 1) drawn once per decision
    kTimeOfDay = 20,  ///< s since the day began
    kTargetConfidence = 110,  ///< 1: noticed now; remembered ones less and less; 0: there is none
    kAllies = 111,            ///< entities of allied types within perception
    kFoes = 112,              ///< targets within sight or hearing
};

/// What every agent senses, by SenseIndex; its variables follow, then the outputs of its fuzzy
/// systems, then what it knows of points_of_interest.
inline constexpr SenseIndex kSensePlayerDistance = 0;
inline constexpr SenseIndex kSenseHomeDistance = 1;
inline constexpr SenseIndex kSenseRandom = 2;
inline constexpr SenseIndex kSenseConfidence = 3;
inline constexpr SenseIndex kSenseAllies = 4;
inline constexpr SenseIndex kSenseFoes = 5;
inline constexpr SenseIndex kSenseTimeOfDay = 6;
inline constexpr SenseIndex kOwnSenses = 7;

/// Numbers that an agent can have of its own.
inline constexpr std::size_t kMaxVariables = 8;

constexpr SenseIndex sense_of(Sensor sensor) {
    switch (sensor) {
        case Sensor::kPlayerDistance:
            return kSensePlayerDistance;
        case Sensor::kHomeDistance:
            return kSenseHomeDistance;
        case Sensor::kTimeInState:
            return kStateTime;
        case Sensor::kRandom:
            return kSenseRandom;
        case Sensor::kTimeOfDay:
            return kSenseTimeOfDay;
        case Sensor::kTargetConfidence:
            return kSenseConfidence;
        case Sensor::kAllies:
            return kSenseAllies;
        case Sensor::kFoes:
            return kSenseFoes;
    }
    return kStateTime;
}

/// True for `hold_s` seconds on end before the transition fires: together with two thresholds this
/// is the hysteresis.
struct Transition {
    std::uint16_t to = 0;  ///< a state beside the one that it leaves
    Sensor sensor = Sensor::kTimeInState;
    Compare compare = Compare::kAbove;
    float threshold = 0.0F;
    float hold_s = 0.0F;
    SenseIndex sense = 0;  ///< of a variable or fuzzy output, in place of `sensor`; 0: none
    std::vector<Condition> also{};  ///< must hold as well

    [[nodiscard]] Condition first() const {
        return {sense != 0 ? sense : sense_of(sensor), compare, threshold};
    }
};

/// A number of each agent that grows with time.
struct BrainVariable {
    std::string name;
    float start = 0.0F;
    float per_s = 0.0F;  ///< in states that say no other
    float low = 0.0F;
    float high = 1.0F;
};

/// What a state does to a variable, and all that is inside it unless that says otherwise.
struct VariableChange {
    std::uint16_t variable = 0;
    std::optional<float> per_s;
    float on_enter = 0.0F;  ///< added when the state is entered
};

/// How a state finds at each decision what to do; its own action is for where no way is found.
struct TreeChoice {
    tree::TreeDef def;  ///< answers are numbers of actions
};

struct PlanChoice {
    goap::Domain domain;
    std::vector<std::vector<Condition>> facts;  ///< by fact: true where all hold; not of kStateTime
    std::uint16_t goal = 0;                     ///< of the domain; actions are numbers of actions
};

/// A policy with the envelope that it cannot leave.
struct GuardedPolicy {
    learning::Policy policy;
    learning::Guard guard;
};

/// At every tick that it steers a network says where to go; the state's action has no meaning.
struct PolicyChoice {
    std::uint16_t number = 0;                     ///< among the policies of whoever wrote this
    std::shared_ptr<const GuardedPolicy> policy;  ///< given before the brain is compiled
    std::vector<std::uint16_t> variable;          ///< of the agent, by input that names one
};

/// States that a blend can have.
inline constexpr std::size_t kMaxBlended = 6;

/// Several actions at a time, each to a degree; actions are those of the fuzzy states.
struct BlendChoice {
    fuzzy::FuzzyStateMachineDef def;  ///< without outputs
    std::vector<SenseIndex> inputs;
};

struct BrainState;

/// What is done under a name: as a state's action, without transitions.
using ActionStates = std::vector<BrainState>;

struct BrainState {
    std::string name;
    ActionKind action = ActionKind::kIdle;
    float speed_factor = 1.0F;  ///< of the character's speed, [0, 1]
    bool sprint = false;
    float radius_m = 20.0F;
    float leash_m = 30.0F;                ///< kGuard
    std::uint8_t stance = 0;              ///< index of the behavioural radii while in this state
    std::vector<Transition> transitions;  ///< tried in order, the first that holds is taken
    std::vector<BrainState>
        inside;  ///< a brain as a state: what is above but for transitions is theirs
    state_machine::StateHistory history = state_machine::StateHistory::kNone;
    std::vector<VariableChange> changes{};
    std::uint16_t place = 0;                  ///< of kGo
    std::optional<FormationDef> formation{};  ///< of kFormUp, which has one
    std::optional<ForageDef> forage{};        ///< of kForage, which has one
    std::optional<FollowDef> follow{};        ///< of kFollowTrack, which has one
    std::vector<std::uint16_t>
        along{};  ///< of kFlock: points of interest that the herd goes to in turn
    std::vector<Trade>
        trades{};  ///< once, as soon as they can be done; of an innermost state or action
    /// Of an innermost state.
    std::variant<std::monostate, TreeChoice, PlanChoice, BlendChoice, PolicyChoice> choice{};
    ActionStates actions{};  ///< what it chooses among
    std::optional<learning::RubberBand> rubber_band{};
};

/// A fuzzy system whose outputs are senses.
struct FuzzySense {
    fuzzy::FuzzyDef def;
    std::vector<SenseIndex> inputs;  ///< for each input a sense: its own, or a variable
};

/// Whom an agent looks for, and by what it notices them. As it is to begin with: players, all
/// round, through walls, and forgotten at once.
struct Perception {
    bool given = false;  ///< else nothing below counts
    bool players = true;
    std::vector<TypeIndex> targets{};  ///< looked for as well
    std::vector<TypeIndex> allies{};   ///< counted
    std::vector<TypeIndex> wards{};    ///< looked after, as is a player where `ward_players`
    bool ward_players = false;
    float cos_half_angle = -1.0F;  ///< of the cone about its facing in which it sees
    float around_m = 0.0F;         ///< so near it sees all round
    bool line_of_sight = false;    ///< not through static geometry
    float eyes_m = 0.6F;           ///< above its centre, and above that of whom it looks at
    float hearing_m = 0.0F;        ///< the farthest at which it hears anybody
    float memory_s = 0.0F;         ///< for so long it knows where its target was last
    bool keeps_target = false;     ///< as long as it notices it, though others be nearer

    /// Whether anybody but players matters.
    [[nodiscard]] bool concerns_others() const {
        return given && !(targets.empty() && allies.empty() && wards.empty());
    }
};

struct Brain {
    std::string name;
    std::vector<BrainState> states;          ///< the first is where an entity starts
    float perception_m = 40.0F;              ///< how far players are noticed
    float decide_every_s = 0.2F;             ///< period of decisions; steering runs every tick
    std::vector<BrainVariable> variables{};  ///< the first is sense kOwnSenses
    std::vector<FuzzySense> fuzzy;           ///< the first output comes after the variables
    std::vector<PointOfInterestSense>
        points_of_interest{};  ///< the first comes after the outputs of fuzzy systems
    bool inner = false;        ///< only ever a state of others, whose senses it reads: not compiled
    Perception perception{};
};

/// A condition that some decision in a state may depend on.
struct WatchedCondition {
    SenseIndex sense = 0;  ///< beyond the brain's senses: time in the state of that level
    Compare compare = Compare::kAbove;
    float threshold = 0.0F;
};

/// Conditions that matter together alone: those of a transition or of a fact, or the one that a
/// tree asks. It holds where all of them do.
struct Clause {
    std::uint32_t first = 0;     ///< of CompiledBrain::watches
    std::uint16_t others = 0;    ///< how many conditions are not on stock; they come first
    std::uint16_t on_stock = 0;  ///< and how many are
    std::uint16_t transition = state_machine::kNone;  ///< whose conditions they are
    std::int16_t fact = -1;                           ///< or which fact's
    std::uint16_t stock_number = 0;  ///< where some are: among those of the leaf with any
};

/// Brain for a time step: tables, and what each innermost state does.
struct CompiledBrain {
    struct Fuzzy {
        fuzzy::FuzzySystem system;
        std::vector<SenseIndex> inputs;
        SenseIndex first = 0;  ///< sense of its first output
    };

    /// What entering a state adds to a variable.
    struct Gain {
        std::uint16_t node = 0;  ///< of the table
        std::uint16_t variable = 0;
        float amount = 0.0F;
    };

    std::string name;
    state_machine::FlatStateMachine table;

    struct Blend {
        fuzzy::FuzzyStateMachine brain;  ///< a step is a decision
        std::vector<SenseIndex> inputs;
    };

    struct Plans {
        goap::Actions actions;
        goap::Literals goal;
        std::vector<std::vector<Condition>> facts;
    };

    /// How a leaf chooses: by a tree, a plan or a blend, index into these, or by itself where all
    /// are below 0. ActionStates begin at `first`.
    struct LeafChoice {
        int tree = -1;
        int plan = -1;
        int blend = -1;
        std::uint16_t first = 0;
    };

    std::vector<BrainState> states;  ///< what is done: by leaf of the table, then actions of leaves
    std::vector<LeafChoice> choices;  ///< by leaf
    std::vector<tree::DecisionTree> trees;
    std::vector<Plans> plans;
    std::vector<Blend> blends;
    std::vector<BrainVariable> variables;
    std::vector<float> rates;  ///< growth of variables per tick: of `states` x variables
    std::vector<Gain> gains;   ///< by node
    std::vector<Fuzzy> fuzzy;
    std::vector<PointOfInterestSense> points_of_interest;
    std::size_t first_poi_sense = 0;
    std::size_t senses = kOwnSenses;
    float perception_m = 40.0F;
    float decide_every_s = 0.2F;
    Perception perception{};
    /// Its agents need to know who is near, players or not.
    bool knows_others = false;
    bool flocks = false;    ///< some state of it does
    bool forages = false;   ///< some state of it does
    bool forms_up = false;  ///< some state of it does
    std::vector<WatchedCondition> watches;
    std::vector<Clause> clauses;              ///< transitions of a leaf in the order of their tests
    std::vector<std::uint32_t> first_clause;  ///< by leaf, and the end of the last
    /// By leaf: what its clauses and its blend read, by bit.
    std::vector<std::uint64_t> senses_of_leaf;
    std::uint64_t senses_of_poi = 0;  ///< those that change where an agent walks, by bit

    /// All that decisions in a leaf depend on.
    [[nodiscard]] std::span<const Clause> clauses_of(std::size_t leaf) const {
        return std::span(clauses).subspan(first_clause[leaf],
                                          first_clause[leaf + 1] - first_clause[leaf]);
    }

    /// Those conditions of a clause that are not on stock, and those that are.
    [[nodiscard]] std::span<const WatchedCondition> others(const Clause& clause) const {
        return std::span(watches).subspan(clause.first, clause.others);
    }

    [[nodiscard]] std::span<const WatchedCondition> on_stock(const Clause& clause) const {
        return std::span(watches).subspan(clause.first + clause.others, clause.on_stock);
    }

    /// Whether a sense is what a place has in stock.
    [[nodiscard]] bool is_stock(SenseIndex sense) const {
        return sense >= first_poi_sense && sense < senses &&
               points_of_interest[sense - first_poi_sense].stock >= 0;
    }
};

/// The state brain alone, in the form of state_machine, for checks and diagrams. Actions are
/// numbered as the innermost states are.
state_machine::StateMachineDef state_machine_of(const Brain& brain);

/// Of what state_machine_of() speaks of.
std::size_t senses_of(const Brain& brain);

/// `brain` without defects; `dt` in s, > 0.
CompiledBrain compile(const Brain& brain, float dt);

}  // namespace zoned::ai
