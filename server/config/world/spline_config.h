// spline_config: reads and checks the splines of a config and their followers for agents.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/text/diagnostics.h"

#include <memory>
#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
class FollowTrack;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Checks splines by themselves: names, a place in the world, and that each can be followed.
/// nullptr without splines, or with mistakes.
std::shared_ptr<const ai::splines::SplineNetwork> build_tracks(const proto::config::Config& config,
                                                               Diagnostics& diagnostics);

/// Unknown names become the first lane of the first spline.
ai::FollowDef expand_follow(const proto::config::Config& config,
                            const proto::config::FollowTrack& follow);

/// Checks that the followed splines exist; at `path`.
void check_follow(const proto::config::Config& config,
                  const proto::config::FollowTrack& follow,
                  const std::string& path,
                  Diagnostics& diagnostics);

/// Reports splines that do not suit the speed and size of their followers, each once: bends that
/// need more acceleration than they have, lanes narrower than they are, splines through static
/// obstacles. Doors are not checked.
std::vector<std::string> track_warnings(const Settings& settings);

}  // namespace zoned::config
