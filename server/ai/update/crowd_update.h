// CrowdUpdate: formation slots, and local avoidance between agents.
#pragma once

#include "server/ai/steering/formation_following.h"
#include "server/ai/steering/local_avoidance.h"
#include "server/ai/update/ai_turn.h"

#include <vector>

namespace zoned::ai {

class CrowdUpdate {
  public:
    /// Computes the current formation slot of each agent that keeps formation around another
    /// entity.
    void place_formations(const AiContext& ai, const AiTurn& turn);

    /// Makes agents on a collision course avoid each other. An agent's desired velocity stays its
    /// aim.
    void avoid(const AiContext& ai, AiTurn& turn);

  private:
    std::vector<AvoidingAgent> walkers_;
    steering::KnownWalls walls_;
    Formations formations_;
    LocalAvoidance avoidance_;
};

}  // namespace zoned::ai
