// Suspend and resume: off-screen agents go from event to event, and their entities are not
// simulated.
#pragma once

#include "server/ai/ai_context.h"
#include "server/ai/steering/path_following.h"
#include "shared/motion/static_geometry.h"

namespace zoned::ai {

/// Whether the agent's action can go on from event to event, as long as it meets no entity
/// (proximity_schedule.h). The action must depend on no other entity, or on a herd alone (herd.h).
bool can_suspend(const Agent& agent, const CompiledBrain& brain);

/// Brings the entity to rest at its position. Its walk goes on in agent.segment.
void suspend(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row);

/// Places the entity where agent.segment leads by the end of the last tick, on the ground and clear
/// of obstacles.
void catch_up(Agent& agent, const AiContext& ai, world::Row row);

/// Sets the segment of an agent that has changed its action, or has come to the end of its segment.
/// Call it after catch_up() and any decision of this tick. True: it needs a path first, see
/// plan_segment().
bool walk_on(Agent& agent,
             const CompiledBrain& brain,
             const AiContext& ai,
             world::Row row,
             Slot slot);

/// The tick of the agent's next event: the end of its segment, or a decision that may change
/// something. Decisions before it change nothing, unless the stock named in agent.wait changes.
/// Call it after all changes to the agent and to stock in this tick. Sets agent.next_decision and
/// agent.wait.
Tick next_event(Agent& agent, const CompiledBrain& brain, const AiContext& ai);

/// Does the same after an event without a decision or a trade, for an agent that waited for no
/// stock. The forecast of its last decision still holds where it does not depend on the walk.
Tick next_event_undecided(Agent& agent, const CompiledBrain& brain, const AiContext& ai);

/// Makes the entity go on as if it had always been simulated: position, velocity, command.
void resume(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row);

}  // namespace zoned::ai
