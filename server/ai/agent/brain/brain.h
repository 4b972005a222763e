// Brain: the decision making of a character's agent, as written and as compiled.
#pragma once

#include "server/ai/agent/brain/forage_def.h"
#include "server/ai/agent/brain/formation_def.h"
#include "server/ai/agent/brain/points_of_interest.h"
#include "server/ai/agent/brain/spline_follow_def.h"
#include "server/ai/decision/fuzzy/fuzzy_state_machine.h"
#include "server/ai/decision/fuzzy/fuzzy_system.h"
#include "server/ai/decision/goap/goap_planner.h"
#include "server/ai/decision/senses.h"
#include "server/ai/decision/state_machine/coded_state_machine.h"
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

/// The action of a state: how its entity moves.
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
    kFollowTrack = 190,  ///< follow a spline by a timetable: `follow`
    kGuard = 112,  ///< hold home: run at a target within `radius_m` of home until it is beyond
                   ///< `leash_m`, then walk home
};

/// True if the action leads to places, so that a path may be needed; false where it moves by what
/// is near.
constexpr bool goes_to_places(ActionKind action) {
    return action != ActionKind::kIdle && action != ActionKind::kFlee &&
           action != ActionKind::kFlock;
}

/// The sensor that a transition's condition reads.
enum class Sensor : std::uint8_t {
    kPlayerDistance,  ///< to the nearest player, m; infinity when none is within `perception_m`
    kHomeDistance,    ///< m
    kTimeInState,     ///< s
    kRandom,          ///< uniform [0, 1) drawn once per decision
    kTimeOfDay = 20,  ///< s since the day began
    kTargetConfidence = 110,  ///< 1: noticed; remembered: falls with time; 0: none
    kAllies = 111,            ///< entities of allied types within perception
    kFoes = 112,              ///< targets within sight or hearing
    kLeads = 160,             ///< 1: it leads its company; 0: it does not
};

/// The senses of every agent, by SenseIndex. Its variables follow, then the outputs of its fuzzy
/// systems, then its senses of points_of_interest.
inline constexpr SenseIndex kSensePlayerDistance = 0;
inline constexpr SenseIndex kSenseHomeDistance = 1;
inline constexpr SenseIndex kSenseRandom = 2;
inline constexpr SenseIndex kSenseConfidence = 3;
inline constexpr SenseIndex kSenseAllies = 4;
inline constexpr SenseIndex kSenseFoes = 5;
inline constexpr SenseIndex kSenseTimeOfDay = 6;
inline constexpr SenseIndex kSenseLeads = 7;
inline constexpr SenseIndex kOwnSenses = 8;

/// The most variables that an agent can have.
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
        case Sensor::kLeads:
            return kSenseLeads;
    }
    return kStateTime;
}

/// A condition has to be true for `hold_s` seconds on end before the transition fires. With two
/// thresholds this gives hysteresis.
struct Transition {
    std::uint16_t to = 0;  ///< a sibling of the state that it leaves
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
    float per_s = 0.0F;  ///< in states that set no other rate
    float low = 0.0F;
    float high = 1.0F;
};

/// The change that a state makes to a variable. States inside it do the same unless they set their
/// own.
struct VariableChange {
    std::uint16_t variable = 0;
    std::optional<float> per_s;
    float on_enter = 0.0F;  ///< added when the state is entered
};

/// A choice gives a state its action at each decision. The state's own action is done where the
/// choice finds none. This choice is a decision tree.
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

/// Choice by a network that steers the agent at every tick. The state's own action has no meaning.
struct PolicyChoice {
    std::uint16_t number = 0;  ///< among the policies of the author of this brain
    std::shared_ptr<const GuardedPolicy> policy;  ///< set before the brain is compiled
    std::vector<std::uint16_t> variable;          ///< of the agent, for each input that names one
};

/// The most states that a blend can have.
inline constexpr std::size_t kMaxBlended = 6;

/// Several actions at a time, each to a degree. The actions are those of the fuzzy states.
struct BlendChoice {
    fuzzy::FuzzyStateMachineDef def;
    std::vector<SenseIndex> inputs;
};

struct BrainState;

/// Named actions. Each is like a state's action, without transitions.
using ActionStates = std::vector<BrainState>;

/// Shares of the three rules of flocking in a herd animal's heading (steering/flocking.h).
struct FlockWeights {
    float separation = 2.0F;
    float alignment = 1.0F;
    float cohesion = 0.8F;
};

struct BrainState {
    std::string name;
    ActionKind action = ActionKind::kIdle;
    float speed_factor = 1.0F;  ///< of the character's speed, [0, 1]
    bool sprint = false;
    float radius_m = 20.0F;
    float leash_m = 30.0F;                ///< kGuard
    std::uint8_t stance = 0;              ///< index of the behavioural radii while in this state
    std::vector<Transition> transitions;  ///< tried in order, the first that holds is taken
    std::vector<BrainState> inside;  ///< the states of a brain used as a state; they set all of the
                                     ///< above but transitions
    state_machine::StateHistory history = state_machine::StateHistory::kNone;
    std::vector<VariableChange> changes{};
    std::uint16_t place = 0;                  ///< of kGo
    std::optional<FormationDef> formation{};  ///< of kFormUp, which has one
    std::optional<ForageDef> forage{};        ///< of kForage, which has one
    std::optional<FollowDef> follow{};        ///< of kFollowTrack, which has one
    std::vector<std::uint16_t>
        along{};           ///< of kFlock: points of interest that the herd goes to in turn
    FlockWeights flock{};  ///< of kFlock
    std::vector<Trade>
        trades{};  ///< each done once, as soon as possible; of an innermost state or action
    /// Of an innermost state.
    std::variant<std::monostate, TreeChoice, PlanChoice, BlendChoice, PolicyChoice> choice{};
    ActionStates actions{};  ///< the actions that it chooses among
    std::optional<learning::RubberBand> rubber_band{};
};

/// A fuzzy system whose outputs are senses.
struct FuzzySense {
    fuzzy::FuzzyDef def;
    std::vector<SenseIndex> inputs;  ///< for each input a sense: its own, or a variable
};

/// The entities that an agent looks for, and how it notices them. The default: players, all round,
/// through walls, and forgotten at once.
struct Perception {
    bool given = false;  ///< false: the fields below have no effect
    bool players = true;
    std::vector<TypeIndex> targets{};  ///< also looked for
    std::vector<TypeIndex> allies{};   ///< counted
    std::vector<TypeIndex> wards{};    ///< looked after, like players where `ward_players`
    bool ward_players = false;
    /// Agents of one type choose one of them as the ward of the others where there is no other.
    bool succession = false;
    float cos_half_angle = -1.0F;  ///< of its cone of vision about its facing
    float around_m = 0.0F;         ///< within this distance it sees all round
    bool line_of_sight = false;    ///< not through static geometry
    float eyes_m = 0.6F;           ///< above its own centre, and above the centre of its target
    float hearing_m = 0.0F;        ///< the greatest distance at which it hears any entity
    float memory_s = 0.0F;         ///< for this long it remembers where its target was last
    bool keeps_target = false;     ///< as long as it notices the target, though others are nearer

    /// Whether other entities than players matter.
    [[nodiscard]] bool concerns_others() const {
        return given && !(targets.empty() && allies.empty() && wards.empty() && !succession);
    }
};

struct Brain {
    std::string name;
    std::vector<BrainState> states;          ///< the first is where an entity starts
    float perception_m = 40.0F;              ///< the greatest distance at which players are noticed
    float decide_every_s = 0.2F;             ///< period of decisions; steering runs every tick
    std::vector<BrainVariable> variables{};  ///< the first is sense kOwnSenses
    std::vector<FuzzySense> fuzzy;           ///< the first output comes after the variables
    std::vector<PointOfInterestSense>
        points_of_interest{};  ///< the first comes after the outputs of fuzzy systems
    bool inner = false;        ///< only used inside other brains, with their senses: not compiled
    Perception perception{};
    std::string coded{};  ///< the CodedMachine that makes its transitions; empty: none
};

/// A condition that some decision in a state may depend on.
struct WatchedCondition {
    SenseIndex sense = 0;  ///< beyond the brain's senses: time in the state of that level
    Compare compare = Compare::kAbove;
    float threshold = 0.0F;
};

/// Conditions that matter only together: those of a transition or a fact, or the one that a tree
/// asks. A clause holds where all its conditions do.
struct Clause {
    std::uint32_t first = 0;     ///< of CompiledBrain::watches
    std::uint16_t others = 0;    ///< number of conditions that are not on stock; they come first
    std::uint16_t on_stock = 0;  ///< number of conditions on stock
    std::uint16_t transition = state_machine::kNone;  ///< the transition of these conditions
    std::int16_t fact = -1;                           ///< the fact of these conditions
    std::uint16_t stock_number = 0;                   ///< among the leaf's clauses on stock
};

/// A brain compiled for a time step: its tables, and the action of each innermost state.
struct CompiledBrain {
    struct Fuzzy {
        fuzzy::FuzzySystem system;
        std::vector<SenseIndex> inputs;
        SenseIndex first = 0;  ///< sense of its first output
    };

    /// The amount that entering a state adds to a variable.
    struct Gain {
        std::uint16_t node = 0;  ///< of the table
        std::uint16_t variable = 0;
        float amount = 0.0F;
    };

    std::string name;
    state_machine::FlatStateMachine table;
    /// Makes the transitions in place of the table, which knows their numbers alone:
    /// bind_code().
    std::optional<state_machine::BoundMachine> code;

    struct Blend {
        fuzzy::FuzzyStateMachine brain;  ///< one step per decision
        std::vector<SenseIndex> inputs;
    };

    struct Plans {
        goap::Actions actions;
        goap::Literals goal;
        std::vector<std::vector<Condition>> facts;
    };

    /// How a leaf chooses: by a tree, a plan or a blend (indexes into these). Where all are below
    /// 0, the leaf's own action is done. Its ActionStates begin at `first`.
    struct LeafChoice {
        int tree = -1;
        int plan = -1;
        int blend = -1;
        std::uint16_t first = 0;
    };

    std::vector<BrainState> states;   ///< by leaf of the table, then actions of leaves
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
    /// Its agents need to know all entities near them, players or not.
    bool knows_others = false;
    /// Some state of it has a rubber band that counts rivals: its agents need to know those near a
    /// player.
    bool counts_rivals = false;
    bool flocks = false;    ///< some state of it flocks
    bool forages = false;   ///< some state of it forages
    bool forms_up = false;  ///< some state of it keeps formation
    std::vector<WatchedCondition> watches;
    std::vector<Clause> clauses;              ///< transitions of a leaf in the order of their tests
    std::vector<std::uint32_t> first_clause;  ///< by leaf, and the end of the last
    /// By leaf: the senses that its clauses and its blend read, by bit.
    std::vector<std::uint64_t> senses_of_leaf;
    std::uint64_t senses_of_poi = 0;  ///< senses that change while an agent walks, by bit

    /// All conditions that decisions in a leaf depend on.
    [[nodiscard]] std::span<const Clause> clauses_of(std::size_t leaf) const {
        return std::span(clauses).subspan(first_clause[leaf],
                                          first_clause[leaf + 1] - first_clause[leaf]);
    }

    /// The conditions of a clause that are not on stock, and those that are.
    [[nodiscard]] std::span<const WatchedCondition> others(const Clause& clause) const {
        return std::span(watches).subspan(clause.first, clause.others);
    }

    [[nodiscard]] std::span<const WatchedCondition> on_stock(const Clause& clause) const {
        return std::span(watches).subspan(clause.first + clause.others, clause.on_stock);
    }

    /// Whether a sense is the stock of a place.
    [[nodiscard]] bool is_stock(SenseIndex sense) const {
        return sense >= first_poi_sense && sense < senses &&
               points_of_interest[sense - first_poi_sense].stock >= 0;
    }
};

/// The brain's state machine alone, in the form of state_machine, for checks and diagrams. Actions
/// are numbered like the innermost states.
state_machine::StateMachineDef state_machine_of(const Brain& brain);

/// The number of senses that state_machine_of() refers to.
std::size_t senses_of(const Brain& brain);

/// Compiles a `brain` without defects; `dt` in s, > 0.
CompiledBrain compile(const Brain& brain, float dt);

}  // namespace zoned::ai
