// Suite `crowd`: agents that walk among each other.
#include "tests/bench/suite_crowd.h"
#include "tests/bench/suite_crowd_goals.h"

namespace zoned::bench {

namespace {

void run_crowd(Session& session) {
    run_crowd_goals(session);
    if (session.wants_scene(kAvoidanceScene)) {
        run_crowd_avoidance(session);
    }
}

const Registration kCrowd({"crowd",
                           "crowds: time of a step, overlaps, ways for many at once",
                           std::vector<std::string>{kGoalsScene, kAvoidanceScene},
                           {"default", "cpu_2"},
                           run_crowd});

}  // namespace

}  // namespace zoned::bench
