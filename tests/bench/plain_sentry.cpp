// build: hot loops
#include "tests/bench/plain_sentry.h"

#include "tests/scenario/sentry.h"

namespace zoned::bench {

void sentry_by_switch(ai::state_machine::ActiveStates& states,
                      const ai::SenseColumns& senses,
                      Tick now,
                      std::vector<ai::state_machine::StateChange>& changes) {
    ai::state_machine::step_coded(
        states,
        now,
        changes,
        [columns = scenario::SentryColumns(senses)](ai::state_machine::CodedTurn& turn) {
            scenario::sentry_decide(turn, columns);
        });
}

void sentry_by_class(ai::state_machine::ActiveStates& states,
                     const ai::SenseColumns& senses,
                     Tick now,
                     std::vector<ai::state_machine::StateChange>& changes) {
    ai::state_machine::step_coded(states, scenario::sentry_objects(), senses, now, changes);
}

}  // namespace zoned::bench
