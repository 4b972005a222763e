// difficulty_names: the difficulties that a config lists for adaptation, and its first one.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Adaptation;
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

inline constexpr const char* kAdaptationPath = "ai.adaptation";

/// The ends and the start of the adaptation's list, as indices. A setting not given takes its first
/// allowed value.
struct LevelRange {
    int least = 0;
    int most = 0;
    int start = 0;
};

LevelRange level_range(const proto::config::Adaptation& adaptation);

/// The first difficulty of the world: `ai.difficulty`, or the start of `ai.adaptation`; empty:
/// parameters are as types set them.
std::string first_difficulty(const proto::config::Config& config);

/// Checks `ai.adaptation` by itself: names that are unknown, repeated or not in the list, a start
/// outside least to most, and a difficulty set besides.
void check_adaptation(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
