// DecisionUpdate: finds the agents that have something to do in a tick, and makes their decisions.
#pragma once

#include "server/ai/update/meeting_update.h"
#include "server/ai/update/trade_update.h"
#include "server/ai/update/viewer_update.h"

namespace zoned::ai {

/// Fills in turn.rows, turn.due and turn.herd_steps, the longest waiting agents first. Agents
/// beyond the budgets wait.
void collect_due(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings, TradeUpdate& trades);

/// Whether some active agent looks for other entities than players, or is looked for.
[[nodiscard]] bool needs_others(const AiContext& ai,
                                const AiTurn& turn,
                                const PerceptionRanges& ranges);

/// Places the suspended agents of turn.due first; then all agents perceive and decide.
void decide_due(const AiContext& ai,
                AiTurn& turn,
                const PerceptionRanges& ranges,
                const ViewerUpdate& viewers);

/// Finds agents whose state flaps between two states. Only reports use this.
void watch_changes(const AiContext& ai, const AiTurn& turn);

}  // namespace zoned::ai
