// sha256: the checksum that identifies the contents of files in configs.
#pragma once

#include <string>
#include <string_view>

namespace zoned::config {

/// SHA-256 (FIPS 180-4) in lower-case hex.
std::string sha256_hex(std::string_view bytes);

}  // namespace zoned::config
