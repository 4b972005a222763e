// NextChange: how long nothing can change for an agent that nobody sees.
#pragma once

#include "server/ai/agent/decision.h"

namespace zoned::ai {

/// What a forecast needs to know besides the agent.
struct ForecastInputs {
    float speed = 0.0F;  ///< of its entity, m/s
    float day_s = 0.0F;
    float dt = 0.0F;  ///< s
    const PointsOfInterest& points_of_interest;
    const PathSegment* segment =
        nullptr;  ///< that it goes along until it is asked again; null: anywhere
};

/// What forecast_next_change() finds.
struct NextChange {
    Tick until = kNever;  ///< > now
    StockWait wait{};     ///< its trades are none
};

/// No decision of the agent before `until` takes a transition, begins or ends a hold, or chooses
/// another action than the one it is at, as long as it perceives nobody, none of its variables is
/// changed from outside, and stock_changed() says no of `wait`: no transition, fact or question of
/// its state, tree or plan becomes other than the agent found it. `senses` are those of `now`,
/// which need not be those that it decided by: what has become other since then may change
/// something at once. A transition or a fact holds where all its conditions do, so it does not
/// before the last of those that fail. A distance changes at most by the way that is walked, or as
/// the walk leads, a variable grows at its rate, time passes; what cannot be told in advance (fuzzy
/// outputs of what changes) may change at once. Random numbers are known in advance: they are
/// looked at for a number of decisions. Others change stock: where nothing but stock keeps a
/// condition as it is, that is waited for.
///
/// So between two such ticks nothing needs to be computed, and what happens at them is exactly what
/// would have happened (next-event time progression; Law, "Simulation Modeling and Analysis", 5th
/// ed. 2015, section 1.3.1). Who waits for stock is looked at by stock, as conditional events are
/// in the three-phase approach (Pidd, "Computer Simulation in Management Science", 5th ed. 2004,
/// section 6.5).
NextChange forecast_next_change(const Agent& agent,
                                const CompiledBrain& brain,
                                const Senses& senses,
                                const ForecastInputs& inputs,
                                Tick now);

/// Whether stock at `now` is other than agents in `leaf` wait for.
bool stock_changed(const StockWait& wait,
                   const CompiledBrain& brain,
                   std::size_t leaf,
                   const PointsOfInterest& points_of_interest,
                   Tick now);

/// A tick > now before which able() says no of a trade that it does not say yes of at `now`, as
/// long as the agent does what it does; kNever: it will not.
Tick able_from(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now);

}  // namespace zoned::ai
