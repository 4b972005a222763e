// Difficulty log: puts the changes of adaptive difficulty and rubber bands into words.
#pragma once

#include "server/zone/zone.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace zoned::app {

/// One line: the difficulty of a zone among its possible ones, and the players' results there;
/// empty where difficulty stays as it is.
std::string difficulty_text(const zone::ZoneState& state);

/// Logs the change of difficulty of the zone's last tick, where there was one.
void log_difficulty(const zone::Zone& zone);

/// The factors of speed of NPCs in states with a rubber band.
struct BandFigures {
    std::uint32_t npcs = 0;
    float least = 1.0F;
    float most = 1.0F;
};

/// By brain, over all zones; brains of which no NPC is in such a state are left out.
std::map<std::string, BandFigures> bands_of(std::span<const std::unique_ptr<zone::Zone>> zones);

/// Rubber bands that were logged, and when.
struct LoggedBands {
    struct LoggedBand {
        BandFigures figures;
        std::optional<Tick> at;  ///< none: never yet
    };

    std::map<std::string, LoggedBand> by_brain;
};

/// Logs the brains whose least or most factor differs by 0.1 or more from the last log (1 to begin
/// with), each at most once in `between` ticks.
void log_bands(const std::map<std::string, BandFigures>& now,
               Tick tick,
               Tick between,
               LoggedBands& logged);

}  // namespace zoned::app
