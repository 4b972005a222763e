// Suite `replication`: the bytes that clients receive, and the errors of their views.
#include "tests/bench/suite_replication.h"

namespace zoned::bench {

namespace {

void run_replication(Session& session) {
    if (session.wants_scene("dead_reckoning") || session.wants_scene("display")) {
        run_dead_reckoning(session);
    }
    run_scenes(session);
}

const Registration kReplication(
    {"replication",
     "bytes, errors and time of replication",
     {"cubes901_A", "cubes901_B", "bodies250", "crowd200", "crowd100", "dead_reckoning", "display"},
     {"default",
      "order0",
      "order1",
      "order2",
      "ballistic",
      "turning",
      "snap",
      "linear",
      "hermite",
      "unpredicted",
      "interpolate",
      "per_client",
      "auto"},
     run_replication});

}  // namespace

}  // namespace zoned::bench
