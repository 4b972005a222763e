#include "server/zone/faults/broken_rules.h"

#include <csignal>
#include <stdexcept>
#include <utility>

namespace zoned::zone {

BrokenRules::BrokenRules(std::unique_ptr<Rules> rules, BreakKind kind, Tick at)
    : DecoratedRules(std::move(rules)),
      kind_(kind),
      at_(at) {
}

void BrokenRules::on_tick(RulesContext& context) {
    DecoratedRules::on_tick(context);
    if (context.now() >= at_) {
        fail();
    }
}

void BrokenRules::fail() const {
    if (kind_ != BreakKind::kThrow) {
        std::raise(kind_ == BreakKind::kCrash ? SIGSEGV : SIGABRT);
    }
    throw std::runtime_error("testing.break_zone: the rules throw on purpose");
}

}  // namespace zoned::zone
