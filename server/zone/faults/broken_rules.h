// BrokenRules: rules that fail on purpose in one tick, to test what becomes of their zone.
#pragma once

#include "server/zone/faults/decorated_rules.h"
#include "server/zone/faults/fault_settings.h"

#include <memory>

namespace zoned::zone {

/// All calls go on to the rules of a studio, but that of one tick.
class BrokenRules final : public DecoratedRules {
  public:
    BrokenRules(std::unique_ptr<Rules> rules, BreakKind kind, Tick at);

    void on_tick(RulesContext& context) override;

    /// So that its tick comes in a world at rest too.
    [[nodiscard]] bool busy() const override { return true; }

  private:
    /// A function of its own, so that the stack of a crash names it.
    [[noreturn, gnu::noinline]] void fail() const;

    BreakKind kind_;
    Tick at_;
};

}  // namespace zoned::zone
