// FuzzylitePeer: a fuzzy system of ours, built with fuzzylite (J. Rada-Vilela, from Debian).
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"

#include <memory>
#include <vector>

namespace zoned::bench {

/// Minimum for and, clipping, maximum to put together; centroid over as many pieces as the output
/// has samples, or the weighted average. Constants only under Sugeno.
class FuzzylitePeer {
  public:
    explicit FuzzylitePeer(const ai::fuzzy::FuzzyDef& def);
    ~FuzzylitePeer();
    FuzzylitePeer(const FuzzylitePeer&) = delete;
    FuzzylitePeer& operator=(const FuzzylitePeer&) = delete;

    /// The first output for the inputs of one agent.
    double evaluate(const float* const* in, std::size_t agent);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace zoned::bench
