// MeetingUpdate: resumes suspended agents before they can perceive an entity or be perceived.
#pragma once

#include "server/ai/offscreen/proximity_schedule.h"
#include "server/ai/update/ai_turn.h"

#include <vector>

namespace zoned::ai {

class MeetingUpdate {
  public:
    /// Updates which types look for which. After a change, indexes the suspended agents that meet
    /// others anew.
    void index_suspended(const AiContext& ai, AiTurn& turn);

    /// Adds to turn.waking the agents that may soon perceive an entity, or be perceived.
    void meet(const AiContext& ai, AiTurn& turn);

    /// Does AgentStore::settle(), and updates the proximity schedule too.
    void settle(const AiContext& ai, AiTurn& turn, Slot slot, Tick left, bool late = false);

    /// Whether an active agent that meets others can be suspended: no entity comes near it for
    /// `calm` ticks. Also finds the tick of its next check.
    [[nodiscard]] bool meets_nobody(const AiContext& ai,
                                    const AiTurn& turn,
                                    const DueAgent& due,
                                    Tick calm);

    /// Adds an active agent that was just suspended.
    void add(const AiContext& ai, Slot slot, world::Row row) {
        schedule_.put(slot, ai.entities.type[row], ai, false);
    }

    /// Forgets an agent that was resumed.
    void forget(Slot slot) { schedule_.forget(slot); }

    /// Lets the next update index all agents anew.
    void reset() { schedule_.ranges() = PerceptionRanges(); }

    [[nodiscard]] const PerceptionRanges& ranges() const { return schedule_.ranges(); }

  private:
    void look_around(const AiContext& ai,
                     AiTurn& turn,
                     PerceptionRanges::PerceiverKind kind,
                     world::Row row);
    void check_suspended(const AiContext& ai, AiTurn& turn, Slot slot);

    ProximitySchedule schedule_;
    std::vector<Slot> met_;  // suspended agents near the one that was checked
};

}  // namespace zoned::ai
