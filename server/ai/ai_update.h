// AiUpdate: perception, decisions and steering of all agents of a zone; its output is one
// InputCommand per character.
#pragma once

#include "server/ai/ai_context.h"
#include "server/ai/update/ai_turn.h"
#include "server/ai/update/crowd_update.h"
#include "server/ai/update/forage_update.h"
#include "server/ai/update/herd_update.h"
#include "server/ai/update/meeting_update.h"
#include "server/ai/update/offscreen_update.h"
#include "server/ai/update/path_update.h"
#include "server/ai/update/trade_update.h"
#include "server/ai/update/viewer_update.h"
#include "server/spatial/point_grid.h"

#include <span>

namespace zoned::ai {

/// What an update knows of those before it, for snapshots.
struct SavedAiState {
    SavedViewers viewers;
    DifficultyState difficulty;  ///< on which level, and what players have done there
};

/// The order of the passes, and what they keep from tick to tick, so that a tick allocates nothing.
class AiUpdate {
  public:
    /// Writes `command` and `stance` of the rows of active agents, and places those of suspended
    /// ones. Players are the rows with a client and without kHidden. Rows of hidden or removed
    /// entities and of ghosts are left alone. With n agents that decide in every tick and a budget
    /// of b decisions none waits longer than ceil(n / b) ticks. Results depend neither on the order
    /// of rows, nor on the history of add() and take(), nor on threads. A budget of 0 counts as 1,
    /// and one of less than kRaysPerLook rays as that: an agent that finds no rays left waits, and
    /// goes on with what it knew, at most ceil(n / (rays / kRaysPerLook)) ticks. Steps of herds
    /// that nobody sees are no decisions.
    AiReport run(const AiContext& context);

    /// Changes of tier in the last update, ascending by entity id: the entity of a suspended agent
    /// needs no body, that of a resumed one does.
    [[nodiscard]] std::span<const EntityId> suspended() const { return offscreen_.suspended(); }

    [[nodiscard]] std::span<const EntityId> resumed() const { return offscreen_.resumed(); }

    /// The nests of creatures that forage: their scents are part of the zone's state.
    [[nodiscard]] const Nests& nests() const { return forage_.nests(); }

    /// Chains what the agents are that had something to decide or an event in the last update.
    void hash(const AgentStore& agents, core::StateHash& hash) const;

    [[nodiscard]] const DifficultyState& difficulty() const { return difficulty_; }

    [[nodiscard]] DifficultyState& difficulty() { return difficulty_; }

    [[nodiscard]] SavedAiState save() const { return {viewers_.save(), difficulty_}; }

    /// `agents` are those that the state belongs to.
    void load(const SavedAiState& saved,
              const Nests::SavedNests& nests,
              const AgentStore& agents,
              const AiSettings& settings);

    /// After `paths` were read: tells them where those who wait are.
    void wait_for(const PathService& paths, const AgentStore& agents) {
        paths_.wait_for(paths, agents);
    }

  private:
    void steer_active(const AiContext& ai);
    void give_commands(const AiContext& ai);
    void add_up();

    AiTurn turn_;
    spatial::PointGrid nobody_;
    DifficultyState difficulty_;
    ViewerUpdate viewers_;
    MeetingUpdate meetings_;
    TradeUpdate trades_;
    PathUpdate paths_;
    HerdUpdate herds_;
    ForageUpdate forage_;
    CrowdUpdate crowd_;
    OffscreenUpdate offscreen_;
};

}  // namespace zoned::ai
