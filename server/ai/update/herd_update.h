// HerdUpdate: herds that nobody sees go on, a step at a time.
#pragma once

#include "server/ai/offscreen/herd.h"
#include "server/ai/update/meeting_update.h"

namespace zoned::ai {

/// Where animals of herds are that nobody sees, in this tick.
HerdDrift drift_of(const AiContext& ai, const AiTurn& turn);

class HerdUpdate {
  public:
    /// Where the steps of those in turn.due and turn.herd_steps lead: all look around before any of
    /// them walks on.
    void head_herds(const AiContext& ai, AiTurn& turn);

    /// Steps of those who do nothing else, and their next ones.
    static void walk_herd_steps(const AiContext& ai, AiTurn& turn);
    static void settle_herd_steps(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// The first step of an active agent, from where its body is. False: it would leave the ground.
    static bool set_roaming(Agent& agent, const DueAgent& due, const AiContext& ai, AiTurn& turn);

  private:
    Herds herds_;
};

}  // namespace zoned::ai
