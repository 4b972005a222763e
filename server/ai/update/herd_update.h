// HerdUpdate: moves the suspended animals of herds, one step at a time.
#pragma once

#include "server/ai/offscreen/herd.h"
#include "server/ai/update/meeting_update.h"

namespace zoned::ai {

/// Positions of the suspended herd animals in this tick.
HerdDrift drift_of(const AiContext& ai, const AiTurn& turn);

class HerdUpdate {
  public:
    /// Finds where the steps of the animals in turn.due and turn.herd_steps lead. All of them look
    /// around before any of them walks on.
    void head_herds(const AiContext& ai, AiTurn& turn);

    /// Takes the steps of animals that do nothing else, and schedules their next steps.
    static void walk_herd_steps(const AiContext& ai, AiTurn& turn);
    static void settle_herd_steps(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// The first step of an active agent, from the position of its body. False: the step would
    /// leave the ground.
    static bool set_roaming(Agent& agent, const DueAgent& due, const AiContext& ai, AiTurn& turn);

  private:
    Herds herds_;
};

}  // namespace zoned::ai
