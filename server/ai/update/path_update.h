// PathUpdate: asks for the paths that agents need, and sets those out that were answered.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <vector>

namespace zoned::ai {

class PathUpdate {
  public:
    /// Paths for the agents in the lanes' `asking`, most often in the tick in which they ask.
    void find_paths(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// After `paths` were read: tells them where those who wait are.
    void wait_for(const PathService& paths, const AgentStore& agents);

  private:
    void request_paths(const AiContext& ai, AiTurn& turn);
    void count_bodies(const AiContext& ai);

    std::vector<Slot> asking_;    // ascending by entity
    std::vector<Slot> waiting_;   // for paths that they have asked for
    std::vector<Slot> answered_;  // and those who have another path than before
    std::vector<float> body_x_;   // of those whom paths lead around
    std::vector<float> body_z_;
};

}  // namespace zoned::ai
