// Learning scenes of the suite `decisions`.
#pragma once

#include "tests/bench/suite.h"

namespace zoned::bench {

/// Scene `xor`: exclusive or by NEAT.
void run_xor(Session& session, const std::string& scene);

/// Scene `cartpole`: a pole on a cart, a genetic algorithm on a network of fixed topology
/// (default), and NEAT.
void run_cartpole(Session& session, const std::string& scene);

}  // namespace zoned::bench
