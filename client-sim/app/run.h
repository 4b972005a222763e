// run: drives a swarm over real sockets on the wall clock, from the command line to the exit code.
#pragma once

#include "client-sim/app/options.h"

namespace zoned::app {

/// Prints progress on standard error, the verdict table and one line `verdict: ...` on standard
/// output, writes the report. Returns the exit code.
int run(const Options& options);

/// All of client-sim but its main(). A game of one's own gives its bots here: they play in place of
/// --behaviour.
int client_main(int argc, char** argv, const bot::MakeOwnScript& make_own_script = {});

}  // namespace zoned::app
