// Offscreen: agents that nobody can see go from event to event, and their entities are not
// simulated.
#pragma once

#include "server/ai/ai_context.h"
#include "server/ai/steering/path_following.h"
#include "shared/motion/static_geometry.h"

namespace zoned::ai {

/// Whether what the agent does can go on from event to event, as long as it meets nobody
/// (proximity_schedule.h): it depends on nobody else, or on a herd alone (herd.h).
bool can_suspend(const Agent& agent, const CompiledBrain& brain);

/// The entity comes to rest where it is; its way goes on in agent.segment.
void suspend(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row);

/// Puts the entity where the agent's segment has brought it by the end of the last tick, on the
/// ground and clear of what stands there.
void catch_up(Agent& agent, const AiContext& ai, world::Row row);

/// After catch_up() and any decision of this tick: sets the segment where the agent has turned to
/// something else, or its segment has come to its end. True: it needs a way first, see
/// plan_segment().
bool walk_on(Agent& agent,
             const CompiledBrain& brain,
             const AiContext& ai,
             world::Row row,
             Slot slot);

/// When something may happen to the agent next: the end of its segment, or a decision; at its
/// decisions before that nothing does, unless agent.wait says what stock it takes. To be called
/// after all that happens to it and to stock in this tick. Sets agent.next_decision and agent.wait.
Tick next_event(Agent& agent, const CompiledBrain& brain, const AiContext& ai);

/// The same after an event at which the agent took no decision, did not trade and waited for no
/// stock: the forecast of its last decision holds where that does not hang on where it walks.
Tick next_event_undecided(Agent& agent, const CompiledBrain& brain, const AiContext& ai);

/// The entity goes on as one that was simulated all the time: position, velocity, command.
void resume(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row);

}  // namespace zoned::ai
