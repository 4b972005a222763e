// PathUpdate: requests the paths that agents need, and sets agents out on the paths they get.
#pragma once

#include "server/ai/update/meeting_update.h"

#include <vector>

namespace zoned::ai {

class PathUpdate {
  public:
    /// Finds paths for the agents in the lanes' `asking`, most often in the tick of the request.
    void find_paths(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    /// After `paths` were loaded: tells the path service where the waiting agents are.
    void wait_for(const PathService& paths, const AgentStore& agents);

  private:
    void request_paths(const AiContext& ai, AiTurn& turn);
    void count_bodies(const AiContext& ai);

    std::vector<Slot> asking_;    // ascending by entity
    std::vector<Slot> waiting_;   // for paths that they have requested
    std::vector<Slot> answered_;  // and the agents whose path is new or has changed
    std::vector<float> body_x_;   // bodies that paths lead around
    std::vector<float> body_z_;
};

}  // namespace zoned::ai
