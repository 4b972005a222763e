// PlainFlock: the peer of `boids_50k`, a first simple version with an agent array and cell lists.
#pragma once

#include "kernels/include/flock.h"

#include <cstddef>
#include <vector>

namespace zoned::bench {

class PlainFlock {
  public:
    struct Agent {
        float x, y, z, vx, vy, vz;
    };

    std::vector<Agent> agents;
    kernels::FlockRules rules{};
    std::size_t tested = 0;  ///< pairs, in the last step

    /// The same rules as kernels/include/flock.h, on one thread.
    void step();

  private:
    void sort();
    Agent moved(std::size_t i);

    int columns_ = 0, rows_ = 0;
    std::vector<int> begin_, cell_, list_;
    std::vector<Agent> next_;
};

}  // namespace zoned::bench
