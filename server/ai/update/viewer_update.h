// ViewerUpdate: where players are, and which suspended agents they might see.
#pragma once

#include "server/ai/offscreen/viewer_coverage.h"
#include "server/ai/perception/perception.h"
#include "server/ai/update/meeting_update.h"

#include <vector>

namespace zoned::ai {

/// State about viewers that is kept from earlier ticks, for snapshots.
struct SavedViewers {
    std::vector<EntityId> viewers;   ///< of the last tick, ascending
    std::vector<Vec2> covered_from;  ///< x, z of the viewers when their coverage was last built
    float coverage_m = 1.0F;         ///< range of that coverage, > 0
};

class ViewerUpdate {
  public:
    /// Finds the players.
    void gather(const AiContext& ai) { players_.gather(ai.entities); }

    /// Follows the players, and adds the agents that they may see to turn.waking.
    void follow_viewers(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);

    [[nodiscard]] const Players& players() const { return players_; }

    /// Whether an entity at `at` (x, z, m) may be seen.
    [[nodiscard]] bool covers(const Vec2& at) const { return coverage_.covers(at); }

    [[nodiscard]] const SavedViewers& save() const { return saved_; }

    void load(const SavedViewers& saved);

  private:
    void cover();
    void follow_suspended(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings);
    void check_suspended(const AiContext& ai, AiTurn& turn, bool all);
    void check(const AiContext& ai, AiTurn& turn, Slot slot);

    ViewerCoverage coverage_;
    SavedViewers saved_;
    std::vector<EntityId> viewers_before_;
    Players players_;
    std::vector<OffscreenGrid::Cell> covered_squares_;  // squares in which agents may be seen
    std::vector<Slot> left_;
};

}  // namespace zoned::ai
