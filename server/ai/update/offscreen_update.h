// OffscreenUpdate: suspends agents that nobody sees, takes them from event to event, resumes them.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <span>
#include <vector>

namespace zoned::ai {

class OffscreenUpdate {
  public:
    void clear();

    /// Changes of tier in this tick, ascending by entity.
    [[nodiscard]] std::span<const EntityId> suspended() const { return suspended_; }

    [[nodiscard]] std::span<const EntityId> resumed() const { return resumed_; }

    /// Those of turn.waking.
    void resume_waking(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// Segments of suspended agents whose event this is.
    static void advance_suspended(const AiContext& ai, AiTurn& turn);

    /// Suspended agents whose event this was: to the next one.
    static void go_on(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// Active agents that have decided and that nobody can see for a while.
    void suspend_unseen(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

  private:
    std::vector<EntityId> suspended_;
    std::vector<EntityId> resumed_;
};

}  // namespace zoned::ai
