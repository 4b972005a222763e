// Path following: moves an agent along its path, one timed path segment after the other.
// The walk is the same for a simulated entity and for one that is only placed by its timetable.
#pragma once

#include "server/ai/agent/whereabouts.h"
#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// True: the walk depends on no other agent, so it goes by segments. Herd animals, followers,
/// chasers and agents that flee do not go by segments.
bool goes_by_segments(const Agent& agent, const BrainState& state);

/// Starts the agent's segment at its body, with the body's velocity. plan_segment() then has to set
/// its end.
void start_segment(Agent& agent, const Surroundings& around);

/// True: the segment has ended, or it is time to look again for a path that was missing.
inline bool segment_is_over(const Agent& agent, Tick now, float dt) {
    return now >= (agent.segment.length > 0.0F ? arrival_of(agent.segment, dt) : agent.again_at);
}

/// Sets the next segment from the present one: to the next corner of the path, or to another goal.
/// Moves on targets that are reached. True: the agent needs a path to agent.segment.goal first.
/// Then nothing has changed yet; the caller requests the path, sets agent.on_path and calls
/// follow_path() in the same tick. Different agents may plan at the same time.
bool plan_segment(Agent& agent, const BrainState& state, bool entered, const Surroundings& around);

/// For walks without segments: turns `desired` to the next corner of a path to its goal where the
/// body cannot go straight there. True: it needs a path. The path is requested anew at each
/// decision, because goals move.
bool turn_to_path(Agent& agent,
                  const BrainState& state,
                  DesiredVelocity& desired,
                  const Surroundings& around);

/// Called once the agent's path was requested and answered. The agent sets out to its next corner,
/// or straight ahead while it waits; it stands where there is no path.
void follow_path(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
