// StateFlapping: names the NPCs, over all zones, that switch to and fro between two states.
#pragma once

#include "server/recording/report.h"
#include "server/zone/zone.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::app {

/// By brain and states; the findings of several zones are summed.
std::vector<recording::FlappingFigures> flapping_of(
    std::span<const std::unique_ptr<zone::Zone>> zones);

/// Logs the pairs of `now` that are not in `logged`, each once, and adds them there.
void tell_flapping(const std::vector<recording::FlappingFigures>& now,
                   std::vector<recording::FlappingFigures>& logged);

}  // namespace zoned::app
