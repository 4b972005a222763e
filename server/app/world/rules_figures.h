// RulesFigures: what the rules of all zones count and measure, for the metrics.
#pragma once

#include "server/zone/zone_messages.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>

namespace zoned::app {

struct RulesFigures {
    std::map<std::string, double> counts;                          ///< of all zones together
    std::map<std::pair<std::string, std::size_t>, double> gauges;  ///< by name and index of a zone
    /// With a bad name, not finite, or of one name more than there may be.
    std::uint64_t refused = 0;

    /// Of one zone and tick.
    void take(std::span<const zone::RulesFigure> figures, std::size_t zone);
};

}  // namespace zoned::app
