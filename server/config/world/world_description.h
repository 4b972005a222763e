// world_description: the constants of a world that clients receive at login, and their digest.
#pragma once

#include "proto/session.pb.h"
#include "shared/motion/ground_surface.h"

#include <string>
#include <string_view>

namespace zoned::config {

struct Settings;

/// Appends what a client needs of a surface to predict its avatar on it.
void describe_geometry(const motion::Surface& from, proto::StaticSurface& out);

/// The content of Welcome.world. The limits are the declared ones (testing.wrong_limit replaces
/// them here and nowhere else).
proto::WorldDescription describe_world(const Settings& settings);

/// Settings::digest: the hash of the description in text format, honest limits included; the hash
/// of each surface's content stands for its geometry, replicated or not. Two configs have the same
/// digest exactly when clients cannot distinguish them and their surfaces are the same.
std::string world_digest(const Settings& settings);

}  // namespace zoned::config
