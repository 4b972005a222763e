// AiUpdate: perception, decisions and steering of all agents of a zone. Its output is one
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

/// State that an update keeps from earlier updates, for snapshots.
struct SavedAiState {
    SavedViewers viewers;
    DifficultyState difficulty;  ///< the zone's level, and the outcomes of its players there
    float drift_m = 0.0F;        ///< see AiTurn
};

/// Runs the passes in order. It keeps its buffers from tick to tick, so a tick allocates nothing.
class AiUpdate {
  public:
    /// Writes `command` and `stance` of the rows of active agents, and places suspended agents.
    /// Players are the rows with a client and without kHidden. Rows of hidden or removed entities
    /// and of ghosts are left alone.
    ///
    /// Let n agents decide in every tick, with a budget of b decisions: no agent waits longer than
    /// ceil(n / b) ticks. A budget of 0 counts as 1. A ray budget below kRaysPerLook counts as
    /// kRaysPerLook. An agent that finds no rays left waits at most ceil(n / (rays / kRaysPerLook))
    /// ticks, and meanwhile goes on with its last percept. Steps of suspended herds are no
    /// decisions.
    ///
    /// Results do not depend on the order of rows, the history of add() and take(), or threads.
    AiReport run(const AiContext& context);

    /// Agents suspended and resumed in the last update, ascending by entity id. The entity of a
    /// suspended agent needs no body; the entity of a resumed agent does.
    [[nodiscard]] std::span<const EntityId> suspended() const { return offscreen_.suspended(); }

    [[nodiscard]] std::span<const EntityId> resumed() const { return offscreen_.resumed(); }

    /// The nests of creatures that forage. Their pheromones are part of the zone's state.
    [[nodiscard]] const Nests& nests() const { return forage_.nests(); }

    /// Adds to `hash` the state of each agent that had a decision or an event in the last update.
    void hash(const AgentStore& agents, core::StateHash& hash) const;

    [[nodiscard]] const DifficultyState& difficulty() const { return difficulty_; }

    [[nodiscard]] DifficultyState& difficulty() { return difficulty_; }

    [[nodiscard]] SavedAiState save() const {
        return {viewers_.save(), difficulty_, turn_.drift_m};
    }

    /// `agents` are the agents that the state belongs to.
    void load(const SavedAiState& saved,
              const Nests::SavedNests& nests,
              const AgentStore& agents,
              const AiSettings& settings);

    /// After `paths` were loaded: tells the path service where the waiting agents are.
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
