// Suite `crowd`: agents that walk among each other.
#include "tests/bench/suite_crowd_goals.h"

namespace zoned::bench {

namespace {

void run_crowd_suite(Session& session) {
    run_crowd_goals(session);
}

const Registration kCrowdSuite({"crowd",
                                "crowds: ways for many at once",
                                std::vector<std::string>{kGoalsScene},
                                std::vector<std::string>{"default"},
                                run_crowd_suite});

}  // namespace

}  // namespace zoned::bench
