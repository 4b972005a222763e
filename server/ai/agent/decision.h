// Decision: one pass through the transitions of an agent's state.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/percept.h"

#include <array>
#include <optional>

namespace zoned::ai {

/// Buffers and counters of decisions; holds no state.
struct DecisionScratch {
    std::uint32_t max_plan_nodes = 1024;
    std::optional<goap::GoapPlanner> planner{};  ///< created when some agent plans
    goap::Plan plan{};
    std::optional<state_machine::StateChange> change{};  ///< of the last decision
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;
    std::uint32_t plans_unreachable = 0;
};

/// The senses of an agent at a decision.
using Senses = std::array<float, state_machine::kMaxSenses>;

/// Variable v at `now`, which is not before variables_at. It grows at the rate of the agent's
/// action. It is computed from its value at the start of the action. So the result is the same to
/// the last bit however often it is read.
float variable_at(const Agent& agent, const CompiledBrain& brain, std::size_t v, Tick now);

/// Stores the values of the variables at `now`. Call it before the agent's action changes.
void grow(Agent& agent, const CompiledBrain& brain, Tick now);

/// The random number of the agent's decision at `now`, in [0, 1). It depends on the tick alone, so
/// decisions that change nothing can be left out.
float drawn_at(const Agent& agent, Tick now);

/// Fills in the senses that `brain` reads at `now`: its own, its variables, the outputs of its
/// fuzzy systems, then points_of_interest. `here`: x, z where the agent takes itself to be,
/// zone-local, m. Only the fuzzy outputs and points of interest in `wanted` (by bit) are filled in;
/// others stay as they are.
void sense(const Agent& agent,
           const CompiledBrain& brain,
           const Percept& percept,
           const Vec2& here,
           const PointsOfInterest& points_of_interest,
           Tick now,
           Senses& senses,
           std::uint64_t wanted = ~std::uint64_t{0});

/// Fills in the senses of `wanted` that sense() has left out.
void sense_more(const Agent& agent,
                const CompiledBrain& brain,
                const Vec2& here,
                const PointsOfInterest& points_of_interest,
                Tick now,
                Senses& senses,
                std::uint64_t wanted);

/// Whether an agent with this ward leads its company.
inline bool leads(const CompiledBrain& brain, EntityId ward) {
    return brain.perception.succession && !ward;
}

/// Stores the parts of a percept that a decision needs.
void take_notice(Agent& agent, const Percept& percept, const CompiledBrain& brain, Tick now);

/// Senses, and takes the transition that fires, if any (by table or by code). Entered states
/// make their changes to variables. Then chooses the action: by the state itself, its tree or its
/// plan. A plan is made anew when a fact has changed. Without a plan, the state's own action is
/// done. Returns whether a transition fired.
bool decide(Agent& agent,
            const CompiledBrain& brain,
            const Percept& percept,
            const Vec2& here,
            const PointsOfInterest& points_of_interest,
            Tick now,
            DecisionScratch& scratch);

/// An agent within this distance of its spot has arrived, m.
inline constexpr float kAtPointM = 2.0F;

/// Whether at `now` the agent has the goods that it gives, and room for those that it takes.
bool able(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now);

/// All trades that the action asks for, by bit.
std::uint8_t all_trades(const BrainState& state);

struct TradeResult {
    std::uint32_t done = 0;
    std::uint32_t refused = 0;  ///< of the trades at the agent's place
};

/// Does those trades that the agent still wants and that can be done at `here` (x, z, m).
TradeResult settle_trades(Agent& agent,
                          const CompiledBrain& brain,
                          const Vec2& here,
                          PointsOfInterest& points_of_interest,
                          Tick now);

/// Ticks between decisions, >= 1.
Tick decision_period(const CompiledBrain& brain, float dt);

/// The next tick after `now` at which the agent decides. Entities are spread over the period by id,
/// so that agents created in one tick do not all decide in one tick.
Tick next_decision(EntityId entity, Tick period, Tick now);

}  // namespace zoned::ai
