// Tracks of a config and who follows them, in the form in which agents have them, and what is wrong
// with them.
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

/// Tracks by themselves: names, that they lie in the world, that each can be followed. nullptr
/// where there are none, or some are wrong.
std::shared_ptr<const ai::splines::SplineNetwork> build_tracks(const proto::config::Config& config,
                                                               Diagnostics& diagnostics);

/// Names that mean nothing become the first lane of the first track.
ai::FollowDef expand_follow(const proto::config::Config& config,
                            const proto::config::FollowTrack& follow);

/// That what is followed is there; at `path`.
void check_follow(const proto::config::Config& config,
                  const proto::config::FollowTrack& follow,
                  const std::string& path,
                  Diagnostics& diagnostics);

/// What cannot work of followers as fast and as large as they are, each once: bends in which they
/// would need more acceleration than they have, lanes narrower than they are, tracks through what
/// stands in the world. Nothing where doors are on the way.
std::vector<std::string> track_warnings(const Settings& settings);

}  // namespace zoned::config
