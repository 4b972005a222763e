#include "tests/bench/plain_sentry.h"

#include "tests/scenario/sentry.h"

namespace zoned::bench {

void sentry_by_switch(ai::fsm::MachineStates& states,
                      const ai::SenseColumns& senses,
                      Tick now,
                      std::vector<ai::fsm::Change>& changes) {
    ai::fsm::step_coded(states,
                        now,
                        changes,
                        [columns = scenario::SentryColumns(senses)](ai::fsm::CodedTurn& turn) {
                            scenario::sentry_decide(turn, columns);
                        });
}

void sentry_by_class(ai::fsm::MachineStates& states,
                     const ai::SenseColumns& senses,
                     Tick now,
                     std::vector<ai::fsm::Change>& changes) {
    ai::fsm::step_coded(states, scenario::sentry_objects(), senses, now, changes);
}

}  // namespace zoned::bench
