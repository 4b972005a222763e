// ForageUpdate: creatures that look for food around the nests of a zone.
#pragma once

#include "server/ai/offscreen/forage.h"
#include "server/ai/update/ai_turn.h"

namespace zoned::ai {

class ForageUpdate {
  public:
    /// After a door has moved, suspended foraging creatures check their path as well.
    void call_foragers(const AiContext& ai) const;

    /// Chooses the next cell of each agent that forages.
    void forage(const AiContext& ai, AiTurn& turn);

    [[nodiscard]] const Nests& nests() const { return nests_; }

    void load(const Nests::SavedNests& saved) { nests_.load(saved); }

  private:
    Nests nests_;
};

}  // namespace zoned::ai
