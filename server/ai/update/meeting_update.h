// MeetingUpdate: resumes agents before they perceive somebody, or are perceived.
#pragma once

#include "server/ai/offscreen/proximity_schedule.h"
#include "server/ai/update/ai_turn.h"

#include <vector>

namespace zoned::ai {

class MeetingUpdate {
  public:
    /// Who looks for whom; where that is new, suspended agents that meet others are found anew.
    void index_suspended(const AiContext& ai, AiTurn& turn);

    /// Adds those to turn.waking who may come to perceive somebody, or be perceived.
    void meet(const AiContext& ai, AiTurn& turn);

    /// AgentStore::settle(), for meetings as well.
    void settle(const AiContext& ai, AiTurn& turn, Slot slot, Tick left, bool late = false);

    /// Whether an active agent can be suspended, though it meets others: for `calm` ticks nobody
    /// comes. Says when it is to be checked then.
    [[nodiscard]] bool meets_nobody(const AiContext& ai,
                                    const AiTurn& turn,
                                    const DueAgent& due,
                                    Tick calm);

    /// An active agent that was just suspended.
    void add(const AiContext& ai, Slot slot, world::Row row) {
        schedule_.put(slot, ai.entities.type[row], ai, false);
    }

    /// An agent that was resumed.
    void forget(Slot slot) { schedule_.forget(slot); }

    /// All are found anew.
    void reset() { schedule_.ranges() = PerceptionRanges(); }

    [[nodiscard]] const PerceptionRanges& ranges() const { return schedule_.ranges(); }

  private:
    void look_around(const AiContext& ai,
                     AiTurn& turn,
                     PerceptionRanges::PerceiverKind kind,
                     world::Row row);
    void check_suspended(const AiContext& ai, AiTurn& turn, Slot slot);

    ProximitySchedule schedule_;
    std::vector<Slot> met_;  // suspended, by one who looked whether it might be
};

}  // namespace zoned::ai
