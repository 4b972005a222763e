// NextChange: the time for which nothing can change for a suspended agent.
#pragma once

#include "server/ai/agent/decision.h"

namespace zoned::ai {

/// The inputs of a forecast besides the agent.
struct ForecastInputs {
    float speed = 0.0F;  ///< of its entity, m/s
    float day_s = 0.0F;
    float dt = 0.0F;  ///< s
    const PointsOfInterest& points_of_interest;
    const PathSegment* segment =
        nullptr;  ///< the segment that it walks until the next forecast; null: it may go anywhere
};

/// The result of forecast_next_change().
struct NextChange {
    Tick until = kNever;  ///< > now
    StockWait wait{};     ///< names no trades
};

/// Finds how long the agent's decisions change nothing. No decision before `until` takes a
/// transition, begins or ends a hold, or chooses another action. The agent's transitions, its
/// plan's facts and its tree's questions stay as it found them. This holds under three conditions:
/// - the agent perceives no other entity;
/// - no variable is changed from outside;
/// - stock_changed() is false for `wait`.
/// `senses` are those at `now`. The agent may have decided by older senses: a difference since then
/// may change something at once.
///
/// A transition or a fact needs all its conditions. So it does not hold before the last of its
/// failing conditions does. The bounds per condition are:
/// - a distance changes at most by the distance walked, or as the walk leads;
/// - a variable grows at its rate, and time passes;
/// - random numbers are known in advance, and a number of decisions ahead are looked at;
/// - a fuzzy output of changing inputs cannot be predicted, and may change at once;
/// - code says nothing of its conditions, so an agent that decides by code may change at once;
/// - other agents change stock. If only stock keeps a condition as it is, `wait` names it.
/// So nothing needs to be computed between two such ticks, and the results are exact. (Next-event
/// time progression: Law, "Simulation Modeling and Analysis", 5th ed. 2015, section 1.3.1.) Agents
/// that wait for stock are found by stock, like conditional events in the three-phase approach.
/// (Pidd, "Computer Simulation in Management Science", 5th ed. 2004, section 6.5.)
NextChange forecast_next_change(const Agent& agent,
                                const CompiledBrain& brain,
                                const Senses& senses,
                                const ForecastInputs& inputs,
                                Tick now);

/// Whether stock at `now` differs from the stock that agents in `leaf` wait for.
bool stock_changed(const StockWait& wait,
                   const CompiledBrain& brain,
                   std::size_t leaf,
                   const PointsOfInterest& points_of_interest,
                   Tick now);

/// A tick > now before which able() refuses a trade that it refuses at `now`, as long as the
/// agent's action stays the same. kNever: it will always refuse.
Tick able_from(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now);

}  // namespace zoned::ai
