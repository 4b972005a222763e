// Imitation: simulates a recording again to extract the inputs and actions of its players.
#pragma once

#include "server/ai/learning/descent.h"
#include "server/ai/learning/policy.h"
#include "proto/training.pb.h"
#include "shared/core/result.h"

#include <string>
#include <vector>

namespace zoned::app {

/// One player at one tick, positions in the world's coordinates.
struct PlayedTick {
    std::uint32_t client = 0;
    ai::learning::Situation situation;  ///< before the tick
    ai::learning::Wanted wanted;        ///< the player's input of the tick
};

/// Every `every_ticks` ticks one sample for each player that was there for two ticks and is not
/// hidden, ascending by client. Fails with a reason where the recording cannot be simulated, or
/// does not give the hashes that it holds.
core::Result<std::vector<PlayedTick>> played_ticks(const proto::Training::Imitation& settings,
                                                   std::uint32_t every_ticks);

/// The samples of the players for training, and of those held out: the last to join, at least one
/// each.
struct Lessons {
    ai::learning::Samples training;
    ai::learning::Samples held_out;
    std::size_t players = 0;
    std::size_t players_held_out = 0;
    std::uint64_t hash = 0;  ///< over all samples
};

/// Fails where there are fewer than two players.
core::Result<Lessons> lessons_of(const std::vector<PlayedTick>& ticks,
                                 const proto::Training::Imitation& settings);

}  // namespace zoned::app
