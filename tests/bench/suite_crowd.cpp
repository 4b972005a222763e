// Suite `crowd`: agents that walk among each other.
#include "tests/bench/suite_crowd.h"

namespace zoned::bench {

namespace {

void run_crowd_suite(Session& session) {
    if (session.wants_scene(kAvoidanceScene)) {
        run_crowd_avoidance(session);
    }
}

const Registration kCrowd({"crowd",
                           "crowds: time of a step, overlaps",
                           std::vector<std::string>{kAvoidanceScene},
                           {"default", "cpu_2"},
                           run_crowd_suite});

}  // namespace

}  // namespace zoned::bench
