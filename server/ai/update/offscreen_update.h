// OffscreenUpdate: suspends off-screen agents, takes them from event to event, and resumes them.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <span>
#include <vector>

namespace zoned::ai {

class OffscreenUpdate {
  public:
    void clear();

    /// Agents suspended and resumed in this tick, ascending by entity.
    [[nodiscard]] std::span<const EntityId> suspended() const { return suspended_; }

    [[nodiscard]] std::span<const EntityId> resumed() const { return resumed_; }

    /// Resumes the agents of turn.waking.
    void resume_waking(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// Ends or begins the path segments of suspended agents that have an event now.
    static void advance_suspended(const AiContext& ai, AiTurn& turn);

    /// Schedules the next event of suspended agents that have had one now.
    static void go_on(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// Suspends active agents that have decided, once they have been off screen for a while.
    void suspend_unseen(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

  private:
    std::vector<EntityId> suspended_;
    std::vector<EntityId> resumed_;
};

}  // namespace zoned::ai
