// FuzzylitePeer: one of our fuzzy systems, built with fuzzylite (J. Rada-Vilela, from Debian).
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"

#include <memory>
#include <vector>

namespace zoned::bench {

/// Mamdani: minimum for and, clipping, maximum to aggregate; the centroid takes as many pieces as
/// the output has samples, or the weighted average. Sugeno: constants only.
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
