// CrowdPathSettings: settings for counting bodies and for leaving a path for one around them.
#pragma once

#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

struct CrowdPathSettings {
    std::uint32_t look_ticks = 15;  ///< bodies are counted every so many ticks, > 0
    float remember = 0.9F;          ///< share of the known density that stays at each count, [0, 1)
    float jam_per_m2 = 4.5F;        ///< see DensitySettings
    float least_speed = 0.1F;
    float gain = 0.2F;  ///< a path is left for one that costs less by this share, (0, 1)
    std::uint64_t work_per_tick = 200'000;  ///< in units of about 2 ns (work_units.h)
};

/// SavedCrowds: the saved state of a map's crowding and of the goals with fields around it. Fields
/// are made anew from the saved density. Their answers are the same unless they were just being
/// brought up to date.
struct SavedCrowds {
    struct SavedBlock {
        std::uint32_t block = 0;
        float density = 0.0F;
        std::uint16_t crowding = 0;
    };

    struct SavedGoal {
        std::uint32_t place = ~0U;  ///< ~0: none
        std::uint64_t used = 0;
        bool answers = false;
    };

    std::vector<SavedBlock> blocks;  ///< blocks where agents are, or were of late
    std::vector<SavedGoal> goals;
    std::uint64_t ticks = 0;  ///< since the last count
    std::uint64_t tick = 0;
    std::uint64_t round = 0;
    std::uint64_t reviewed_round = 0;
    std::uint64_t next_review = 0;  ///< request that is reviewed next
};

}  // namespace zoned::ai::pathfinding
