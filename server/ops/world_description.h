// world_description: the constants of a world that clients are told at login, and their digest.
#pragma once

#include "server/ops/settings.h"
#include "proto/session.pb.h"

#include <string>
#include <string_view>

namespace zoned::ops {

/// What Welcome.world holds. The limits are the declared ones (testing.wrong_limit replaces them
/// here and nowhere else).
proto::WorldDescription describe_world(const Settings& settings);

/// SHA-256 (FIPS 180-4) in lower-case hex.
std::string sha256_hex(std::string_view bytes);

/// Settings::digest: the hash of the description in text format, honest limits included. Two
/// configs have the same digest exactly when clients cannot tell them apart.
std::string world_digest(const Settings& settings);

}  // namespace zoned::ops
