// DecisionUpdate: which agents have something to do in a tick, and what they decide.
#pragma once

#include "server/ai/update/meeting_update.h"
#include "server/ai/update/trade_update.h"
#include "server/ai/update/viewer_update.h"

namespace zoned::ai {

/// Fills in turn.rows, turn.due and turn.herd_steps: the longest waiting first; what is beyond
/// the budgets waits.
void collect_due(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings, TradeUpdate& trades);

/// Whether some active agent looks for others than players, or is looked for.
[[nodiscard]] bool needs_others(const AiContext& ai,
                                const AiTurn& turn,
                                const PerceptionRanges& ranges);

/// First the suspended agents of turn.due are put where they are, then all look around.
void decide_due(const AiContext& ai,
                AiTurn& turn,
                const PerceptionRanges& ranges,
                const ViewerUpdate& viewers);

/// Who goes to and fro between two states: for reports alone.
void watch_changes(const AiContext& ai, const AiTurn& turn);

}  // namespace zoned::ai
