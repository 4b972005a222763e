// difficulty_names: the difficulties that a config names for a world that goes among them by
// itself.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Adaptation;
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

inline constexpr const char* kAdaptationPath = "ai.adaptation";

/// What is not set is the first that it may be.
struct LevelRange {
    int least = 0;
    int most = 0;
    int start = 0;
};

LevelRange level_range(const proto::config::Adaptation& adaptation);

/// The difficulty that the world begins with: `ai.difficulty`, or where `ai.adaptation` starts;
/// empty: parameters are as types say.
std::string first_difficulty(const proto::config::Config& config);

/// `ai.adaptation` by itself: names that are none, given twice or not in the list, a start outside
/// of least and most, a difficulty chosen besides.
void check_adaptation(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
