// Decision: one pass through the transitions of an agent's state.
#pragma once

#include "server/ai/agent/agent.h"
#include "server/ai/agent/percept.h"

#include <array>
#include <optional>

namespace zoned::ai {

/// What decisions need while they are made, and count; holds no state.
struct DecisionScratch {
    std::uint32_t max_plan_nodes = 1024;
    std::optional<goap::GoapPlanner> planner{};  ///< once some agent plans
    goap::Plan plan{};
    std::optional<state_machine::StateChange> change{};  ///< of the last decision
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;
    std::uint32_t plans_unreachable = 0;
};

/// What an agent senses at a decision.
using Senses = std::array<float, state_machine::kMaxSenses>;

/// BrainVariable v at `now`, not before variables_at: it has grown at the rate of what the agent
/// does. A function of what it was when that began, so that it is the same to the last bit however
/// often it was asked for.
float variable_at(const Agent& agent, const CompiledBrain& brain, std::size_t v, Tick now);

/// Writes the variables down as they are at `now`: before what the agent does changes.
void grow(Agent& agent, const CompiledBrain& brain, Tick now);

/// The number that the agent draws at a decision, in [0, 1): of the tick alone, so that decisions
/// which change nothing can be left out.
float drawn_at(const Agent& agent, Tick now);

/// Fills in what `brain` reads at `now`: its own senses, the variables, the outputs of its fuzzy
/// systems, then what it knows of points_of_interest. `here`: x, z where it takes itself to be,
/// zone-local, m. Of fuzzy outputs and points of interest only those `wanted`, by bit; others stay
/// as they are.
void sense(const Agent& agent,
           const CompiledBrain& brain,
           const Percept& percept,
           const Vec2& here,
           const PointsOfInterest& points_of_interest,
           Tick now,
           Senses& senses,
           std::uint64_t wanted = ~std::uint64_t{0});

/// Of what sense() left out, those `wanted`.
void sense_more(const Agent& agent,
                const CompiledBrain& brain,
                const Vec2& here,
                const PointsOfInterest& points_of_interest,
                Tick now,
                Senses& senses,
                std::uint64_t wanted);

/// Keeps what a decision needs of a percept.
void take_notice(Agent& agent, const Percept& percept, const CompiledBrain& brain, Tick now);

/// Senses, and takes the transition that fires, if any (state_machine::step_one); what
/// the states that it enters give is added. Then finds what to do: as the state says, its tree or
/// its plan, which is made anew when a fact has changed since; where no plan is found, the state's
/// own action. Returns whether a transition fired.
bool decide(Agent& agent,
            const CompiledBrain& brain,
            const Percept& percept,
            const Vec2& here,
            const PointsOfInterest& points_of_interest,
            Tick now,
            DecisionScratch& scratch);

/// Who has come to its spot is within so much of it, m.
inline constexpr float kAtPointM = 2.0F;

/// Whether the agent has at `now` what it gives and room for what it takes.
bool able(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now);

/// All trades that what is done asks for, by bit.
std::uint8_t all_trades(const BrainState& state);

struct TradeResult {
    std::uint32_t done = 0;
    std::uint32_t refused = 0;  ///< of those at whose place it is
};

/// Does those trades that the agent still wants and that can be done by somebody at `here` (x, z,
/// m).
TradeResult settle_trades(Agent& agent,
                          const CompiledBrain& brain,
                          const Vec2& here,
                          PointsOfInterest& points_of_interest,
                          Tick now);

/// Ticks between decisions, >= 1.
Tick decision_period(const CompiledBrain& brain, float dt);

/// The next tick after `now` at which the agent decides: entities are spread over the period by id,
/// so that a herd that was born in one tick does not decide in one tick for ever.
Tick next_decision(EntityId entity, Tick period, Tick now);

}  // namespace zoned::ai
