// build: hot loops
#include "tests/bench/plain_sentry.h"

#include "tests/scenario/sentry.h"

namespace zoned::bench {

bool sentry_by_switch(ai::state_machine::ActiveState& state,
                      std::span<const float> senses,
                      Tick now) {
    ai::state_machine::CodedTurn turn(state, now);
    scenario::sentry_decide(turn, senses);
    return turn.change().has_value();
}

bool sentry_by_class(ai::state_machine::ActiveState& state,
                     std::span<const float> senses,
                     Tick now) {
    ai::state_machine::CodedTurn turn(state, now);
    scenario::sentry_objects()[turn.state()]->decide(turn, senses);
    return turn.change().has_value();
}

}  // namespace zoned::bench
