// ForageUpdate: creatures that look for food around the nests of a zone.
#pragma once

#include "server/ai/offscreen/forage.h"
#include "server/ai/update/ai_turn.h"

namespace zoned::ai {

class ForageUpdate {
  public:
    /// Where a door has turned, suspended creatures look up as well.
    void call_foragers(const AiContext& ai) const;

    /// Where those who look for food go next.
    void forage(const AiContext& ai, AiTurn& turn);

    [[nodiscard]] const Nests& nests() const { return nests_; }

    void load(const Nests::SavedNests& saved) { nests_.load(saved); }

  private:
    Nests nests_;
};

}  // namespace zoned::ai
