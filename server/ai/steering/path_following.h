// Path following: an agent's walk as path segments, one after the other, by a timetable. It is the
// same whether the agent's entity is simulated or only put where the timetable has it.
#pragma once

#include "server/ai/agent/whereabouts.h"
#include "server/ai/steering/desired_velocity.h"

namespace zoned::ai {

/// Whether the walk hangs on nobody else, so that it goes by segments: those of herds, of who
/// follows somebody, runs or runs after somebody do not.
bool goes_by_segments(const Agent& agent, const BrainState& state);

/// The agent's segment begins at its body, with the velocity of that; plan_segment() has to say
/// where it leads.
void start_segment(Agent& agent, const Surroundings& around);

/// Whether the segment is at its end, or it is time to look again for a path that was not there.
inline bool segment_is_over(const Agent& agent, Tick now, float dt) {
    return now >= (agent.segment.length > 0.0F ? arrival_of(agent.segment, dt) : agent.again_at);
}

/// Sets the segment to what the agent wants now, from its segment as it is: to the next corner of
/// its path, or to another goal. Moves on targets that are reached. True: it needs a path to
/// agent.segment.goal first (whoever asks for it sets agent.on_path), and follow_path() in the same
/// tick; nothing has changed so far. Different agents may plan at the same time.
bool plan_segment(Agent& agent, const BrainState& state, bool entered, const Surroundings& around);

/// For walks that go by no segments: turns `desired` to the next corner of a path to its goal where
/// the body can't go straight there. True: it needs a path, asked for anew at each decision, since
/// goals move.
bool turn_to_path(Agent& agent,
                  const BrainState& state,
                  DesiredVelocity& desired,
                  const Surroundings& around);

/// Once the agent's path was asked for and served: sets out to its next corner, or ahead of it as
/// long as it waits; stands where there is none.
void follow_path(Agent& agent, const BrainState& state, const Surroundings& around);

}  // namespace zoned::ai
