// Suite `crowd`: agents that walk among each other.
#include "tests/bench/suite_crowd.h"

#include "tests/bench/suite_crowd_goals.h"

namespace zoned::bench {

namespace {

void run_crowd_suite(Session& session) {
    run_crowd_goals(session);
    if (session.wants_scene(kAvoidanceScene)) {
        run_crowd_avoidance(session);
    }
    if (session.wants_scene(kFlockScene)) {
        run_crowd_flock(session);
    }
    if (session.pictures) {
        draw_crowds(session);
    }
}

const Registration kCrowd({"crowd",
                           "crowds: time of a step, overlaps, paths for many at once",
                           {kGoalsScene, kAvoidanceScene, kFlockScene},
                           {"default", "cpu_1", "cpu_2", "opencl"},
                           run_crowd_suite});

}  // namespace

}  // namespace zoned::bench
