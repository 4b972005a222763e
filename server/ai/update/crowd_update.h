// CrowdUpdate: formations, and agents that make way for each other.
#pragma once

#include "server/ai/steering/formation_following.h"
#include "server/ai/steering/local_avoidance.h"
#include "server/ai/update/ai_turn.h"

#include <vector>

namespace zoned::ai {

class CrowdUpdate {
  public:
    /// Where those who form up around somebody are to be now.
    void place_formations(const AiContext& ai, const AiTurn& turn);

    /// Whoever would meet somebody avoids it; what it wants stays its aim.
    void avoid(const AiContext& ai, AiTurn& turn);

  private:
    std::vector<AvoidingAgent> walkers_;
    steering::KnownWalls walls_;
    Formations formations_;
    LocalAvoidance avoidance_;
};

}  // namespace zoned::ai
